"""``jaxwalk render``: a walk as film, strip of poses or page."""
