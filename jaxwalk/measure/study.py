"""A measurement from a command's options to its files: measured with a bar, written whole, printed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure
from rich.console import Console

from jaxwalk.common import figures, files
from jaxwalk.config import Config
from jaxwalk.learn.policies import provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import screen
from jaxwalk.measure.screen import OnProgress
from jaxwalk.task import backend

Result = dict[str, Any]


def carry_out(
    command: str,
    args: Any,
    config: Config,
    subject: Subject | None,
    measure: Callable[[OnProgress], Result],
    show: Callable[[Console, Result], None],
    draw: Callable[[Result], Figure] | None = None,
    table: Callable[[Result], bytes] | None = None,
    stem: str = "",
    also: str = "",
) -> Result:
    """Measure, and leave ``STEM.json``, with ``.csv`` and ``.png`` where there are such, in ``args.out``.

    The numbers are on disk before anything is drawn of them.

    Args:
      command: its name, which stamps the result; the files' too, unless ``stem`` says otherwise.
      args: its options; ``out`` is a folder, made if it is not there; or ``json`` a file, or None.
      config: under which walkers walk. subject: who walks; None: several.
      measure: the numbers, with whom to tell of what is under way.
      show: prints them. draw, table: a picture and a CSV of them.
      also: what ``measure`` itself has left in the folder, to be told of.

    Raises:
      UserError: the results cannot be written; or as ``measure`` does.
    """
    folder = getattr(args, "out", None)
    told = (("json", files.json_file), ("csv", table), ("png", draw))
    makers = [(ending, make) for ending, make in told if make is not None]
    if folder is not None:
        files.make_folder("--out", folder)
        for ending, _ in makers:
            files.check_output("--out", folder / f"{stem or command}.{ending}")
    console = Console(markup=False)
    backend.begin(config, getattr(args, "engine", "mjx"))
    with screen.bars(console) as progress:
        result = measure(progress) | provenance.stamp(command, args, subject, config)
    names = [also] if also else []
    if folder is None:
        if args.json is not None:
            files.write_json(args.json, result)
    else:
        for ending, make in makers:
            made = make(result)
            content = figures.png(made) if isinstance(made, Figure) else made
            names.append(f"{stem or command}.{ending}")
            files.write_bytes(folder / names[-1], content)
    show(console, result)
    if folder is not None:
        console.print(f"{', '.join(names)} in {folder}", highlight=False, soft_wrap=True)
    return result
