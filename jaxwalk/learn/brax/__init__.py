"""Brax's own learners on the same task, to compare with."""
