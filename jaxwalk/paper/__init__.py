"""Liu et al.'s claims, one by one: what the paper says, what is measured, and a verdict by a stated rule.

trainings, lab -> claims/ (measure -> numbers; numbers -> checks, table, figure) -> page
"""
