"""The controllers of Liu et al.: stiff legs, moved by servos, and a step that is settled at touch-down.

The defaults until policy format 1, and the preset ``paper``'s; kept for both.
"""
