"""An exported policy at work, with NumPy alone: neither JAX nor MuJoCo is imported.

``Controller.load("policy.safetensors")`` holds the policy and every controller around it; once a tick it
takes what the instruments say and gives what the joints are to do. Its parts mirror the modules of the
same names one level up, which run many walkers at once; the tests hold the two together, tick by tick.
"""

from jaxwalk.deploy.controller import Controller
from jaxwalk.deploy.policy import Policy, load
from jaxwalk.deploy.sensors import Sensors

__all__ = ["Controller", "Policy", "Sensors", "load"]
