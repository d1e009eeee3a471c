"""A planar tree of bodies in the Open Dynamics Engine, with NumPy alone: neither JAX nor MuJoCo is imported.

`Tree` says what there is; `World` holds it in ODE and makes ticks of it.
"""

from jaxwalk.ode.tree import Tree
from jaxwalk.ode.world import Method, World

__all__ = ["Method", "Tree", "World"]
