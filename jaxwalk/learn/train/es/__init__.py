"""Learning by an evolution strategy, on the task and the reward of `jaxwalk.learn.ddpg`."""
