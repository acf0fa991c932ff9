"""Proof on concealed cases: independent truths are drawn and sealed, diagnosed without them, and revealed.

The secrets come from `modelgen.truths`; the diagnosis runs in processes of their own (`worker`) that are told
a folder and nothing else; `scores` says how often it was right, `baselines` what simpler methods make of the
same recordings, `real` what it finds in measured ones, `page` shows it.
"""
