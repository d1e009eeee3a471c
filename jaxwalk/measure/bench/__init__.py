"""How fast it is: bare ``mjx.step``, the whole tick, the push map and the training loop, side by side."""
