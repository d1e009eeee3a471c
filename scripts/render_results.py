"""Write the tables of README.md and of docs/ anew, from the JSON files in docs/results.

    python scripts/render_results.py            or: make results-docs
    python scripts/render_results.py --check    writes nothing; exit code 1 if a page would change

A block ``<!-- results:NAME --> ... <!-- /results -->`` holds what docs/templates/NAME.md.j2 makes of them.
No figure in a block is written by hand, and each block ends with its command, and the commit (or version) and
date of its JSON.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import jinja2

from jaxwalk.cli import COMMANDS
from jaxwalk.options import lines

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "docs" / "results"
PAGES = ("README.md", "docs/results.md", "docs/deploy.md", "docs/native.md")
BLOCK = re.compile(r"(<!-- results:([a-z-]+) -->\n).*?(<!-- /results -->)", re.DOTALL)
LEARNERS = {  # the folders of docs/results/learning, and how they are told
    "ddpg": "DDPG (`jaxwalk train`)",
    "sac": "Brax SAC (`jaxwalk train-baseline sac`)",
    "ppo": "Brax PPO (`jaxwalk train-baseline ppo`)",
    "h200-ddpg": "DDPG, preset `gpu`, one H200",
}


@cache
def read(name: str) -> dict[str, Any]:
    """A result, with the place that it lies at."""
    return json.loads((RESULTS / name).read_text(encoding="utf-8")) | {"_at": f"docs/results/{name}"}


def stamp(found: Mapping[str, Any]) -> str:
    """When it was measured, and by what."""
    by = f"commit {found['commit'][:7]}" if found.get("commit") else f"version {found['versions']['jaxwalk']}"
    return f"{found['date'][:10] if 'date' in found else 'no date in the file'}, {by}"


def command(found: Mapping[str, Any]) -> str:
    """The line that measures it again; what is today's default is left out."""
    name = found["made_by"].removesuffix("-deploy")
    module = import_module(f"jaxwalk.{COMMANDS[name][0]}.options")
    kind = next(one for key, one in vars(module).items() if key.endswith("Args"))
    known = kind.__dataclass_fields__
    told = {
        key: tuple(value) if isinstance(value, list) else value
        for key, value in found["options"].items()
        if key in known
    }
    at = Path(found["_at"])
    told |= {"json": at} if "json" in known else {"out": at.parent}
    return lines.line(name, kind(**told))


def percent(share: float) -> str:
    """100 % is only what lost nobody."""
    text = f"{100 * share:.1f}".removesuffix(".0")
    return f"{'99.9' if text == '100' and share < 1 else text} %"


def pushed(pushes: Mapping[str, Any], impulse: float) -> str:
    """What one push does: who stays up over all phases and at the worst one, who is steady again, and the
    longest mean time that it takes."""
    if impulse not in pushes["impulses"]:
        return "-"
    at = pushes["impulses"].index(impulse)
    survival, again = pushes["survival"][at], pushes["steady"][at]
    seconds = [x for x in pushes["recovery_seconds"][at] if x is not None]
    told = f"{percent(sum(survival) / len(survival))} (worst phase {percent(min(survival))})"
    if not seconds:
        return told
    return f"{told}, {percent(sum(again) / len(again))} steady again, in {max(seconds):.1f} s at most"


def least(found: Mapping[str, Any], kind: str, way: str) -> str:
    """A threshold, or that the smallest push of the grid is too much."""
    if size := found[kind][way]:
        return f"{size:g} N s"
    tried = [abs(x) for x in found["pushes"]["impulses"] if (x > 0) == (way == "forward")]
    return f"below {min(tried):g} N s"


def limit(told: Mapping[str, Any]) -> str:
    """A map's thresholds; a plus where its grid ends."""
    ways = (told["forward"], told["backward"])
    return " / ".join(f"{one['impulse']:g}{'+' if one['censored'] else ''}" for one in ways)


def figures(value: float | None) -> str:
    """Two or three figures that mean something."""
    return "-" if value is None else f"{value:.1f}" if 1 <= value < 20 else f"{value:.2g}"


def learning() -> dict[str, Any]:
    """Footsteps and seconds until each run survived a share of the graded pushes, nobody falling unpushed."""
    found: dict[str, Any] = {}
    for name, told in LEARNERS.items():
        paths = sorted(RESULTS.glob(f"learning/{name}-*/metrics.jsonl"))
        runs = [[json.loads(line) for line in path.read_text().splitlines()] for path in paths]
        runs = [[row for row in rows if row.get("eval/survival") is not None] for rows in runs]
        shares = []
        for share in (0.8, 0.9):
            firsts = [
                next((r for r in rows if r["eval/survival"] >= share and r["eval/calm"] == 1), None)
                for rows in runs
            ]
            never = [
                f"never ({percent(max(r['eval/survival'] for r in rows))})"
                for rows, first in zip(runs, firsts, strict=True)
                if first is None
            ]
            reached = sorted((r["footsteps"], round(r["seconds"])) for r in firsts if r is not None)
            footsteps = ", ".join([f"{round(n, -2):,}" for n, _ in reached] + never)
            shares.append({"footsteps": footsteps, "seconds": ", ".join(str(s) for _, s in reached)})
        found[told] = {"seeds": len(runs), "shares": shares}
    return found


def render(text: str) -> str:
    """A page with all its blocks as the results have them now."""
    loader = jinja2.FileSystemLoader(ROOT / "docs" / "templates")
    environment = jinja2.Environment(
        loader=loader, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters |= {"percent": percent, "figures": figures}
    environment.globals |= {
        "json": read, "stamp": stamp, "command": command, "pushed": pushed, "least": least, "limit": limit,
        "learning": learning,
    }  # fmt: skip

    def block(found: re.Match[str]) -> str:
        made = environment.get_template(f"{found[2]}.md.j2").render()
        tidy = "\n".join(line.rstrip() for line in made.strip().splitlines())
        return f"{found[1]}\n{tidy}\n\n{found[3]}"

    return BLOCK.sub(block, text)


def main(argv: list[str]) -> int:
    """All pages, written only where they change."""
    stale = []
    for name in PAGES:
        path = ROOT / name
        before = path.read_text(encoding="utf-8")
        after = render(before)
        if after != before:
            stale.append(name)
            if "--check" not in argv:
                path.write_text(after, encoding="utf-8")
    print("\n".join(stale) or "all tables are as the results have them")
    return 1 if stale and "--check" in argv else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
