"""What a frozen policy's results owe to the physics' settings.

settings -> evaluate (for each) -> picture
"""
