"""Whether two engines say the same of one policy.

evaluate (twice) -> compare -> picture
"""
