"""``jaxwalk report`` from its options to its page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, validate
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.report import collect, headline, page
from jaxwalk.measure.report.collect import Found
from jaxwalk.measure.report.page import Figure, Page
from jaxwalk.measure.report.parts import PARTS, Part
from jaxwalk.measure.report.sections import SECTIONS
from jaxwalk.measure.report.words import NOTHING, Table
from jaxwalk.options import lines

if TYPE_CHECKING:
    from jaxwalk.measure.report.options import ReportArgs


def main(args: ReportArgs) -> None:
    """Run ``jaxwalk report``."""
    subject = named.load(args.policy)
    console = Console(markup=False)
    parts = [part for name, part in PARTS.items() if name in args.parts]
    # All that is there is read before minutes of work, so that what is wrong with it is said at once.
    ready = {part.command: figure for part in parts if (figure := _figure(part, args, subject))}
    missing = [part for part in parts if part.command not in ready]
    for place, part in enumerate(missing, 1):
        console.print(f"{place} of {len(missing)}: {part.command}", highlight=False)
        collect.measure(part, args.policy, args.folder, args.quick, args.seed)
        figure = _figure(part, args, subject)
        if figure is None:
            raise UserError(f"jaxwalk {part.command} left no {part.json} in {args.folder / part.command}")
        ready[part.command] = figure
    both = [ready[part.command] for part in parts]
    content = page.render(_page(args, subject, both))
    files.write_bytes(args.out, content)
    console.print(f"{args.out}: {len(content) / 2**20:.2f} MiB; results in {args.folder}", highlight=False)


def _figure(part: Part, args: ReportArgs, subject: Subject) -> tuple[Found, Figure] | None:
    found = collect.find(part, args.policy, args.folder)
    if found is None:
        return None
    try:
        figure = Figure(
            anchor=part.command,
            title=part.title,
            section=SECTIONS[part.command](found.result),
            picture=found.picture,
            command=lines.line(part.command, found.args),
            date=found.result["date"],
            small=part.small(found.args),
        )
        page.render(_page(args, subject, [(found, figure)]))  # what cannot be shown is told at once, too
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise UserError(
            f"{found.path} is no result of jaxwalk {part.command} ({type(error).__name__}: {error!s:.100}): "
            "move it away to have it measured anew"
        ) from error
    return found, figure


def _page(args: ReportArgs, subject: Subject, both: Sequence[tuple[Found, Figure]]) -> Page:
    found, figures = [one for one, _ in both], [figure for _, figure in both]
    days = sorted({figure.date[:10] for figure in figures})
    return Page(
        policy=args.policy,
        digest=subject.digest,
        dates=days[0] if len(days) == 1 else f"{days[0]} to {days[-1]}",
        facts=_facts(args.policy, subject),
        headline=headline.table({one.part.command: one.result for one in found}, subject),
        small=tuple(figure.title for figure in figures if figure.small),
        figures=figures,
        measured=Table(
            "Each part: when, the seed of all that is drawn at random, and the machine.",
            ("part", "date (UTC)", "seed", "processor", "cores", "memory, GB", "devices", "system"),
            tuple(_measured(one) for one in found),
        ),
        versions=_versions(found),
        configuration=_configuration(subject.config),
        command=lines.line("report", args),
    )


def _facts(name: str, subject: Subject) -> tuple[tuple[str, str], ...]:
    facts = [("digest", subject.digest[:16])]
    origin = named.origin(name)
    if origin is None:
        facts.append(("origin", "not trained: a rule that ships with jaxwalk"))
    else:
        score = "" if origin.score is None else f", score {origin.score:.3g} in its evaluation"
        facts += [
            ("training", f"{origin.footsteps:,} footsteps, seed {origin.seed}{score}"),
            ("trained by", f"{origin.command} (jaxwalk {origin.jaxwalk_version})"),
        ]
    body = subject.config.body
    facts.append(("body", f"{body.height:g} m, {body.mass:g} kg, {body.table}"))
    return tuple(facts)


def _measured(found: Found) -> tuple[str, ...]:
    told, machine = found.result, found.result["hardware"]
    return (
        found.part.title,
        told["date"][:16].replace("T", " "),
        str(told["options"]["seed"]),
        machine["cpu"],
        str(machine["cores"]),
        f"{machine['memory_gb']:g}",
        _counted(machine["devices"]),
        machine["system"],
    )


def _counted(devices: Sequence[str]) -> str:
    return ", ".join(f"{devices.count(one)} x {one}" for one in dict.fromkeys(devices))


def _versions(found: Sequence[Found]) -> Table:
    """A table with a column for each set of versions; one, if all parts were measured with the same."""
    columns: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for one in found:
        columns.setdefault(tuple(sorted(one.result["versions"].items())), []).append(one.part.title)
    names = dict.fromkeys(name for one in found for name in one.result["versions"])
    rows = tuple((name, *(dict(column).get(name, NOTHING) for column in columns)) for name in names)
    titles = ("version",) if len(columns) == 1 else tuple(", ".join(parts) for parts in columns.values())
    return Table("Software.", ("package", *titles), rows)


def _configuration(config: Config) -> tuple[Table, ...]:
    """A table for each part of the configuration."""
    defaults = dict(validate.leaves(Config()))
    groups: dict[str, list[tuple[str, str]]] = {}
    for name, value in validate.leaves(config):
        group, _, field = name.rpartition(".")
        default = "" if value == defaults[name] else f" (default {_shown(defaults[name])})"
        groups.setdefault(group, []).append((field, _shown(value) + default))
    return tuple(Table(group or "policy", ("field", "value"), tuple(rows)) for group, rows in groups.items())


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(_shown, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
