"""Learning to step: the learner, the training around it, its run folders, the policies that come of it."""
