"""The walker through ROS 1, as the paper's was: a node that simulates it in ODE, and one that controls it.

`body`, `wire`, `simulation`, `watch` and `loop` are plain NumPy; the nodes add rospy. All of these run under
Debian's own Python, without JAX or MuJoCo. `command` starts them.
"""
