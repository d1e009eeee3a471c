"""What one walker senses and does from tick to tick: instruments, the step's clock, controllers, drives."""
