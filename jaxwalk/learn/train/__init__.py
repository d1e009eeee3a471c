"""Training: the device loop, the evaluations within it, the run around both, of one seed or of many."""
