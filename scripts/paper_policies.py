"""Put the policy and the learning curve of a finished run where ``jaxwalk paper`` looks for them.

python scripts/paper_policies.py RUN NAME SEED [FOLDER]      (FOLDER: docs/paper)
"""

from __future__ import annotations

import sys
from pathlib import Path

from jaxwalk.common.errors import UserError
from jaxwalk.paper import trainings


def main(argv: list[str]) -> int:
    if len(argv) not in (3, 4) or not argv[2].isdigit():
        print("usage: python scripts/paper_policies.py RUN NAME SEED [FOLDER]", file=sys.stderr)
        return 2
    run, name, seed, *folder = argv
    try:
        trainings.keep(Path(run), name, int(seed), Path(folder[0] if folder else "docs/paper"))
    except UserError as error:
        print(f"paper_policies: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
