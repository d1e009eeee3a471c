"""``jaxwalk view``: a walker in MuJoCo's viewer, to be pushed by the keyboard."""
