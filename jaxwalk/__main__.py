"""``python -m jaxwalk``, and the command ``jaxwalk``."""

import signal
import sys
from importlib import import_module


def main() -> int:
    """Run the command that the process was given, see `jaxwalk.cli.main`.

    Until it begins its work Ctrl-C ends the process without a word: there is nothing to save, and an import
    that is broken off would tell of itself.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return import_module("jaxwalk.cli").main()


if __name__ == "__main__":
    sys.exit(main())
