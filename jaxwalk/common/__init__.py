"""What every part uses and what knows nothing of walkers: errors, files, untrusted input, devices."""
