"""The command line: ``jaxwalk COMMAND [options]``.

Nothing heavy is imported before a command's options have been read and found good.
"""

from __future__ import annotations

import contextlib
import difflib
import functools
import importlib
import io
import operator
import shlex
import sys
from collections.abc import Sequence

from jaxwalk import __version__
from jaxwalk.common import environment, interrupt, output, runtime
from jaxwalk.common.errors import UserError

COMMANDS = {
    "demo": ("demo", "the shipped policy walks in your browser: push it"),
    "train": ("learn.train", "train a policy into a run folder"),
    "train-baseline": ("learn.brax", "train Brax's PPO or SAC on the same task, to compare with"),
    "refine": ("learn.refine", "search on from a trained policy, under the pushes that rank policies"),
    "sweep": ("learn.sweep", "search training's options, several machines on one study"),
    "evaluate": ("measure.evaluate", "measure a policy's walking and the pushes that it survives"),
    "push-map": ("measure.push_map", "which pushes a policy survives, at every phase of the step"),
    "compare": ("measure.compare", "measure several policies, with their seeds, on the same pushes"),
    "agreement": ("measure.agreement", "whether MJX and another engine say the same of a policy"),
    "sensitivity": ("measure.sensitivity", "what a policy's results owe to the physics' settings"),
    "generalise": (
        "measure.generalise",
        "other bodies, loads, floors, sensors and speeds, the policy frozen",
    ),
    "gait": (
        "measure.gait",
        "a gait report: joints, forces and powers over the stride, beside people's",
    ),
    "report": ("measure.report", "all of a policy's results as one page that stands alone"),
    "paper": ("paper", "every claim of the paper, measured, with a verdict by a stated rule"),
    "export": (
        "export",
        "write a policy for other runtimes: safetensors, npz, ONNX, StableHLO, C",
    ),
    "render": ("show.render", "show a policy's walk: mp4, gif, png, or a page that replays it"),
    "play": ("show.play", "a page on which a policy walks in the browser, and can be pushed by hand"),
    "view": ("show.viewer", "watch a policy walk in MuJoCo's viewer, and push it by the keyboard"),
    "ros": ("ros", "walk through ROS 1: simulated in ODE, controlled by a node, pushed by a service"),
    "bench": ("measure.bench", "measure the speed of the simulation and of training"),
}
"""By its name: the package of its options and of the command itself; what it does."""
_NEXT = {  # what one would type after each
    "demo": "evaluate shipped",
    "play": "push-map {policy} --out map",
    "evaluate": "push-map {policy} --out map",
    "push-map": "render {policy} --push 60 --out push.mp4",
    "agreement": "sensitivity {policy} --out sensitivity",
    "sensitivity": "generalise {policy} --out generalised",
    "generalise": "gait {policy} --out gait",
    "gait": "render {policy} --out walk.html",
}
_SHELLS = ("bash", "zsh")
_RECORDED = ("train", "train-baseline", "refine", "sweep")  # whose results hold the line that was typed


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
      argv: the arguments after the program's name; the process's own by default.

    Returns:
      Exit code: 0 done, 2 bad input (one line on standard error says what), 130 interrupted, 129 or 143 a
      training that SIGHUP or SIGTERM ended, 141 nobody reads the output any more.
    """
    argv = sys.argv[1:] if argv is None else list(argv)
    interrupt.exit_code(begun=True)
    try:
        with output.told():
            _dispatch(argv)
        code = interrupt.exit_code()
    except UserError as error:
        code = _end(2, f"error: {error}")
    except KeyboardInterrupt:
        code = _end(130, "interrupted")
    except BrokenPipeError:
        code = 141  # as a shell tells of who is ended by SIGPIPE
    output.forget()
    return code


def _end(code: int, said: str) -> int:
    try:
        print(f"jaxwalk: {said}", file=sys.stderr, flush=True)
    except BrokenPipeError:
        return 141
    except OSError:  # it goes to a full disk
        pass
    return code


def _dispatch(argv: list[str]) -> None:
    known = ", ".join(COMMANDS)
    if not argv:
        raise UserError(f"no command: give one of {known}, or --help")
    name, *rest = argv
    if name in ("-h", "--help"):
        print(_help())
        return
    if name == "--version":
        print(f"jaxwalk {__version__}")
        return
    if name == "completion":
        print(_completion(*rest))
        return
    if name not in COMMANDS:
        close = difflib.get_close_matches(name, COMMANDS, n=1)
        meant = f" (did you mean {close[0]}?)" if close else ""
        raise UserError(f"unknown command {name!r}: give one of {known}{meant}")
    try:
        _run(name, rest)
    except SystemExit as finished:  # a command's --help
        if isinstance(finished.__context__, BrokenPipeError):  # as Rich tells of it
            raise finished.__context__ from None
        if finished.code:
            raise


def _run(name: str, argv: list[str]) -> None:
    home = f"jaxwalk.{COMMANDS[name][0]}"
    args = importlib.import_module(f"{home}.options").read(argv)
    runtime.setup()
    if not getattr(args, "distributed", False):  # such have to find each other first
        environment.start_devices()
    main = importlib.import_module(f"{home}.command").main
    with interrupt.listening():
        if name in _RECORDED:
            main(args, shlex.join(["jaxwalk", name, *argv]))
        else:
            main(args)
    if name in _NEXT:
        print(f"next: jaxwalk {_NEXT[name].format(policy=shlex.quote(getattr(args, 'policy', '')))}")


def _completion(shell: str = "", *more: str) -> str:
    """A script that lets ``shell`` complete commands and options."""
    if shell in ("-h", "--help"):
        return f"usage: jaxwalk completion {'|'.join(_SHELLS)}"
    if shell not in _SHELLS or more:
        raise UserError(f"jaxwalk completion: give one of {', '.join(_SHELLS)}")
    import typing

    import tyro

    kinds = []
    for name, (home, what) in COMMANDS.items():
        read = importlib.import_module(f"jaxwalk.{home}.options").read
        kind = typing.get_type_hints(read)["return"]
        kinds.append(typing.Annotated[kind, tyro.conf.subcommand(name=name, description=what)])
    with contextlib.redirect_stdout(io.StringIO()) as script, contextlib.suppress(SystemExit):
        tyro.cli(
            functools.reduce(operator.or_, kinds), prog="jaxwalk", args=["--tyro-print-completion", shell]
        )
    return script.getvalue()


def _help() -> str:
    width = max(map(len, COMMANDS)) + 2
    commands = "\n".join(f"  {name:<{width}}{what}" for name, (_, what) in COMMANDS.items())
    return (
        "usage: jaxwalk COMMAND [options]\n\n"
        "Learned stepping for powered exoskeletons, many walkers at once.\n\n"
        f"commands:\n{commands}\n\n"
        "'jaxwalk COMMAND --help' lists a command's options; 'jaxwalk --version' tells the version;\n"
        "'jaxwalk completion bash' (or zsh) prints a script that completes them."
    )
