"""Push maps: which pushes a policy survives, by phase of the step, impulse, point and duration.

grid -> run -> summary -> picture
"""
