"""The one exception that means: the user's input was wrong, not the program."""


class UserError(Exception):
    """Bad input. The message is one line: what, where, and what would be right.

    Commands print it to standard error and exit with code 2.
    """
