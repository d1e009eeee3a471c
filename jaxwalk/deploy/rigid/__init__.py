"""Rigid legs: see `jaxwalk.control.rigid`."""
