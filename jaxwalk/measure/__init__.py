"""Measuring policies: how they walk, which pushes they survive, what that owes to what, how fast all runs."""
