"""MuJoCo's step for a mechanism that is known in advance: its dynamics, Newton's method on its contacts."""
