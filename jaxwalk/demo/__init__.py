"""``jaxwalk demo``: what the shipped policy does, seen within half a minute of installing."""
