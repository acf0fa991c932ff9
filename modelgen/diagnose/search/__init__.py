"""The search over hypotheses: single effects, then one more while the evidence grows."""
