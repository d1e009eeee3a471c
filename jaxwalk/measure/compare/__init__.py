"""Several policies, with their seeds, on the same pushes."""
