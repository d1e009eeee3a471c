"""A trained policy, and all that the controllers around it need, for other runtimes.

Each format carries the manifest (`manifest`) inside it; self-test vectors lie beside it (`selftest`).
"""
