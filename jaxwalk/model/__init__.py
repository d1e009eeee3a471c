"""The body and what moves it: segments, MJCF, the plant by MJX's data and by C MuJoCo, pushes and burdens."""
