"""A search over training's own options: each trial is a training, several machines share one study.

The study and its way of searching are Optuna's (Akiba et al. 2019), which the extra ``sweep`` installs.
"""
