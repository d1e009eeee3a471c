"""What searches have found: how strong a push each walk holds, against the work that it does.

    python scripts/tune_front.py docs/results/search/search-*.json shipped --replicas 8

Each file is of ``scripts/tune.py``. A threshold is the largest push that, with every smaller one, is
survived by 95 % at the worst of 16 phases.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
import tyro

sys.path.insert(0, str(Path(__file__).parent))
import tune

from jaxwalk.common import figures, files, runtime
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.policies import provenance
from jaxwalk.measure import survival

IMPULSES = tuple(float(sign * size) for sign in (1, -1) for size in range(20, 151, 10))


@dataclass(frozen=True)
class Args:
    """Compare what searches have found."""

    found: tyro.conf.Positional[tuple[Path, ...]]
    """Files of scripts/tune.py; or `shipped`, the default walk."""
    out: Path = Path("front")
    """Where front.json and front.png go."""
    replicas: int = 32
    """Walkers at each phase of each push."""


def threshold(rates: dict[float, float], sign: int) -> float:
    """The largest impulse that it, and every smaller one, is survived by enough at the worst phase, N s."""
    held = 0.0
    for size in sorted(abs(i) for i in rates if i * sign > 0):
        if rates[sign * size] < survival.SURVIVED:
            break
        held = size
    return held


def tried(bench: tune.Trials, numbers: dict[str, Any], replicas: int) -> dict[str, Any]:
    """One walk's measures, worst phases and thresholds."""
    numbers = tune.filled(numbers)
    if missing := sorted(set(tune.RANGES) - set(numbers["legs"]) - set(numbers["rule"])):
        sys.exit(f"{numbers['options']}: it lacks {', '.join(missing)}")
    legs, rule = (
        {n: np.array([x], np.float32) for n, x in numbers[part].items()} for part in ("legs", "rule")
    )
    calm, up, measured = bench.impulse == 0, [], []
    for turn in range(replicas):
        walked = bench(legs, rule, turn)
        up.append(~np.asarray(walked.trial.state.terminated)[0])
        own = jax.tree.map(lambda x: x[:, calm], walked)
        measured.append({n: float(x[0]) for n, x in tune.measures(bench.config, own).items()})
    rates = np.mean(up, axis=0)
    worst = {i: float(rates[bench.impulse == i].min()) for i in IMPULSES}
    return {
        "options": numbers["options"],
        "never_fell": float(rates[calm].mean()),
        "measures": {n: float(np.mean([one[n] for one in measured])) for n in tune.SHOWN},
        "worst_phase": {f"{i:+.0f}": x for i, x in worst.items()},
        "forward": threshold(worst, 1),
        "backward": threshold(worst, -1),
    }


def draw(rows: dict[str, dict[str, Any]]) -> Any:
    """Both thresholds against work, a point for each walk."""
    figure = figures.new_figure(7.5, 4.5)
    axes = figure.subplots()
    for way, marker, colour in (("forward", "o", "#0072B2"), ("backward", "s", "#D55E00")):
        work = [row["measures"]["joint_work"] for row in rows.values()]
        axes.plot(work, [row[way] for row in rows.values()], marker, color=colour, label=f"pushed {way}")
    for name, row in rows.items():
        place = row["measures"]["joint_work"], row["forward"]
        axes.annotate(name, place, xytext=(4, 4), textcoords="offset points", fontsize=8)
    axes.set_xlabel("positive work of all joints, J/(N m)")
    axes.set_ylabel("impulse that 95 % survive at the worst phase, N s")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def main(args: Args) -> None:
    """Try each, write the table and the picture."""
    config = PRESETS["default"]
    found = {
        path: tune.of_config(config) if str(path) == tune.SHIPPED else json.loads(path.read_text())
        for path in args.found
    }
    for path, numbers in found.items():
        if not {"legs", "rule", "options"} <= set(numbers):
            sys.exit(f"{path}: not of a search; give files of scripts/tune.py")
    bench = tune.Trials(
        config, 1, tune.Plan(IMPULSES, calm=16, phases=16, offsets=1, weaker=0.0, seconds=14.0, hard=())
    )
    rows = {}
    for path in sorted(found, key=lambda path: (len(path.stem), path.stem)):
        rows[path.stem] = row = tried(bench, found[path], args.replicas)
        print(path.stem, f"{row['forward']:.0f} / {row['backward']:.0f} N s", row["measures"], flush=True)
    args.out.parent.mkdir(parents=True, exist_ok=True)
    told = provenance.stamp("scripts/tune_front.py", args, None, config) | {"walks": rows}
    told["options"]["found"] = [path.name for path in args.found]
    files.write_json(args.out.with_suffix(".json"), told)
    figures.write_png(draw(rows), args.out.with_suffix(".png"))


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
