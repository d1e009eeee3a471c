"""``python -m jaxwalk``."""

import sys

from jaxwalk.cli import main

sys.exit(main())
