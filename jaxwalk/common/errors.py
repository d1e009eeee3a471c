"""The one exception that means: the user's input was wrong, not the program."""


class UserError(Exception):
    """Bad input. The message is one line: what, where, and what would be right.

    What a message quotes from a file or an option may hold anything: white space is made one blank, and
    what a terminal might take for a command is shown by its code. docs/errors.md says what each means.

    Commands print it to standard error and exit with code 2.
    """

    def __init__(self, message: str) -> None:
        line = " ".join(message.split())
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in line))


class Agreed(UserError):
    """One that all processes of a run come to, so that none waits for another."""
