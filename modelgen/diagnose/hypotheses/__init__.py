"""Hypotheses: what they are made of, fitted, weighed against each other and ranked."""
