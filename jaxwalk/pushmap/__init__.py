"""Push maps: which pushes a policy survives, by phase of the step, impulse, height and duration.

grid -> run -> summary -> picture
"""
