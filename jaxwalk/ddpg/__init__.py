"""The learner: deep deterministic policy gradients, with TD3 as a switch."""

from jaxwalk.ddpg import learner, networks, noise, normalizer, replay
from jaxwalk.task.transition import Transition

__all__ = ["Transition", "learner", "networks", "noise", "normalizer", "replay"]
