"""Options from dataclasses by tyro, with one-line errors in place of its boxes."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import math
import re
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Protocol, TypeVar, get_args, get_origin, runtime_checkable

import tyro

from jaxwalk.common.errors import UserError
from jaxwalk.config import Actuators, BodyModel
from jaxwalk.config.presets import PresetName
from jaxwalk.model.push_points import Point

T = TypeVar("T")
_NO_DEFAULT = " (default: None)"
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def parse(kind: type[T], argv: Sequence[str], command: str, default: T | None = None) -> T:
    """The options of ``jaxwalk command`` as a dataclass.

    Args:
      kind: dataclass whose fields are the options.
      default: an instance that holds the defaults, if not those of ``kind``.

    Raises:
      UserError: an option or a value that is wrong.
      SystemExit: code 0, after printing the help that was asked for.
    """
    words, doubtful = _without_values(argv, set(_switches(kind)))
    with _one_line_errors(command, doubtful):
        return tyro.cli(
            kind,
            args=words,
            prog=f"jaxwalk {command}",
            default=tyro.MISSING_NONPROP if default is None else default,
        )


@runtime_checkable
class Options(Protocol):
    """What a command's dataclass of options can do, beside holding them."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """


Checked = TypeVar("Checked", bound=Options)


def checked(
    kind: type[Checked], argv: Sequence[str], command: str, default: Checked | None = None
) -> Checked:
    """`parse`, and then see that the values can be meant.

    Raises:
      UserError, SystemExit: as there; an option out of its range.
    """
    args = parse(kind, argv, command, default)
    args.check()
    return args


def reader(kind: type[Checked], command: str) -> Callable[[Sequence[str]], Checked]:
    """A command's ``read``, which is `checked`."""

    def read(argv: Sequence[str]) -> Checked:
        return checked(kind, argv, command)

    read.__annotations__["return"] = kind
    return read


def parse_known(kind: type[T], argv: Sequence[str], command: str) -> T:
    """Only the options that ``kind`` has; all others are left for a later look.

    Raises:
      UserError: a wrong value for one of them.
    """
    with _one_line_errors(command):
        found, _ = tyro.cli(
            kind, args=argv, prog=f"jaxwalk {command}", return_unknown_args=True, add_help=False
        )
    return found


def _switches(kind: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """(what precedes its name, its name) of each option that is on or off."""
    for name, hint in typing.get_type_hints(kind, include_extras=True).items():
        own = name
        if get_origin(hint) is Annotated:
            own = next(
                (extra.name for extra in hint.__metadata__ if getattr(extra, "name", None) == ""), name
            )
            hint = get_args(hint)[0]
        if hint is bool:
            yield prefix, own.replace("_", "-")
        elif dataclasses.is_dataclass(hint):
            yield from _switches(hint, f"{prefix}{own}.".replace("_", "-") if own else prefix)


def _without_values(argv: Sequence[str], switches: set[tuple[str, str]]) -> tuple[list[str], dict[str, str]]:
    """``--name`` and ``--no-name`` for ``--name True`` and ``--name False``, as switches once were given.

    Beside them, what to say of each word after a switch, should it prove to be nothing else than its value.
    """
    words, given, doubtful = [], list(argv), {}
    while given:
        option, _, value = (word := given.pop(0)).partition("=")
        before, _, name = option.removeprefix("--").replace("_", "-").rpartition(".")
        prefix = f"{before}." if before else ""
        if option.startswith("--") and (prefix, name) in switches:
            if not value and given and given[0] in ("True", "False"):
                value = given.pop(0)
            said = f"is a switch; give {option} or --{prefix}no-{name}"
            if value not in ("", "True", "False"):
                raise UserError(f"{word:.60}: {said}")
            if not value and given:
                doubtful[given[0]] = f"{word} {given[0]:.60}: {said}"
            if value:
                word = f"--{prefix}{'' if value == 'True' else 'no-'}{name}"
        words.append(word)
    return words, doubtful


@contextlib.contextmanager
def _one_line_errors(command: str, doubtful: Mapping[str, str] = MappingProxyType({})) -> Iterator[None]:
    output = io.StringIO()
    try:
        with contextlib.redirect_stderr(output):
            yield
    except SystemExit as stop:
        if not stop.code:
            raise
        said = flatten(output.getvalue())
        for word, better in doubtful.items():
            if said.startswith(f"Unrecognized options: {word}"):
                said = better
        raise UserError(f"{said}; see jaxwalk {command} --help") from None


def flatten(box: str) -> str:
    """tyro's error box as one line, without its frame and title.

    The box is a title, then paragraphs between rules: what is wrong, what would be right, where
    the help is. Its frame is ASCII where the locale
    is, and coloured on a terminal. Of options that were perhaps meant,
    three names are enough.
    """
    paragraphs: list[list[str]] = [[]]
    for line in _COLOUR.sub("", box).splitlines()[1:]:
        text = line.strip(" │╭╮╰╯")
        if text.strip("─-"):
            paragraphs[-1].append(text)
        else:
            paragraphs.append([])
    parts = []
    for paragraph in (" ".join(lines) for lines in paragraphs if lines):
        if paragraph.startswith("Perhaps you meant"):
            parts.append("perhaps you meant " + " or ".join(re.findall(r"(?<!\S)--[\w.-]+", paragraph)[:3]))
        elif not paragraph.startswith("For full helptext"):
            parts.append(paragraph.removeprefix("Argument helptext: ").removesuffix(_NO_DEFAULT).rstrip("."))
    return "; ".join(parts)


def _numbers_from_str(values: list[str], what: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(item) for item in values[0].split(","))
    except ValueError:
        numbers = ()
    if not numbers or not all(map(math.isfinite, numbers)):
        raise ValueError(
            f"{values[0]!r} is no list of {what}, give numbers with commas between, as in 30,-40"
        )
    return numbers


def plain(value: Any) -> str:
    """A value as it is given on the command line; a number in the fewest digits that read back."""
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)


def _is_numbers(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(item, float) for item in value)


def _list_of(what: str) -> tyro.constructors.PrimitiveConstructorSpec:
    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar="N,N,...",
        instance_from_str=lambda values: _numbers_from_str(values, what),
        is_instance=_is_numbers,
        str_from_instance=lambda numbers: [",".join(map(plain, numbers))],
    )


def _names_of(metavar: str, read: Callable[[str], str]) -> tyro.constructors.PrimitiveConstructorSpec:
    """Names with commas between; ``read`` gives each as it is kept."""
    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda values: tuple(map(read, values[0].split(","))),
        is_instance=lambda value: isinstance(value, tuple) and all(isinstance(item, str) for item in value),
        str_from_instance=lambda names: [",".join(names)],
    )


def _optional(read: Callable[[str], Any], metavar: str) -> tyro.constructors.PrimitiveConstructorSpec:
    """What may be left out, and is None then; tyro itself would name None among the choices."""
    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda values: read(values[0]),
        is_instance=lambda value: True,  # defaults are ours
        str_from_instance=lambda value: [plain(value)],
    )


def _one_of(kind: Any) -> Callable[[str], str]:
    """Reads one of a Literal's values."""

    def read(text: str) -> str:
        if text not in get_args(kind):
            raise ValueError(f"{text!r:.60} is none of {', '.join(get_args(kind))}")
        return text

    return read


def _braced(kind: Any) -> str:
    return f"{{{','.join(get_args(kind))}}}"


POLICIES = (
    "A run folder, a policy file, 'shipped', 'shipped-rigid' (on stiff legs), 'fixed' (the nominal step, "
    "never adapted), 'constant' (a step searched for, never adapted), or a rule: 'raibert' (length from "
    "speed), 'capture-point' (length and duration), 'replan' (planned at every tick)."
)
Policy = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="POLICY", help=POLICIES)]
OptionalPolicy = Annotated[str | None, _optional(str, "POLICY")]
OptionalFile = Annotated[Path | None, _optional(Path, "PATH")]
OptionalFloat = Annotated[float | None, _optional(float, "FLOAT")]
OptionalInt = Annotated[int | None, _optional(int, "INT")]
OptionalModel = Annotated[
    BodyModel | None,
    _optional(_one_of(BodyModel), _braced(BodyModel)),
    tyro.conf.arg(
        help="The body: in the plane, or free between two frictionless walls, as the paper's. Default: that "
        "of the policy's configuration.",
    ),
]
OptionalActuators = Annotated[
    Actuators | None,
    _optional(_one_of(Actuators), _braced(Actuators)),
    tyro.conf.arg(
        help="Whose strength the joints have: a young man's, a powered exoskeleton's, or no limit but the "
        "motors'. Default: that of the policy's configuration.",
    ),
]
OptionalPreset = Annotated[PresetName | None, _optional(_one_of(PresetName), _braced(PresetName))]
Impulses = Annotated[tuple[float, ...], _list_of("impulses")]
"""Impulses in N s, as ``30,-40`` on the command line; positive ones push forward."""
Numbers = Annotated[tuple[float, ...], _list_of("numbers")]
Names = Annotated[tuple[str, ...], _names_of("NAME,NAME,...", str.strip)]
Points = Annotated[tuple[str, ...], _names_of("POINT,POINT,...", lambda item: Point.of(item).name)]
"""Points on the body by the names of `push_points.Point`, as ``torso-0.1,torso,stance-thigh``."""
