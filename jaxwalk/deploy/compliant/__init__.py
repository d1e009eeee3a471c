"""Compliant legs: see `jaxwalk.control.compliant`."""
