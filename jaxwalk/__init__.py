"""jaxwalk: learned stepping for powered exoskeletons, many walkers at once in MJX.

Importing the package imports nothing else; take what is needed from its modules.
"""

__version__ = "0.1.0"
