"""``jaxwalk evaluate``: does a policy walk, which pushes does it survive, how soon is it steady again."""
