"""What a run's best policy is worth: beside rules that learn nothing, on the pushes of its finals."""

from __future__ import annotations

import shlex
from pathlib import Path

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.train import finals
from jaxwalk.learn.train.evaluation import Marks
from jaxwalk.task import rules


def of_rules(config: Config, seed: int) -> dict[str, Marks]:
    """How each rule of `rules.RULES` does in the finals of a run of ``config`` and ``seed``; none on rigid
    legs, for which they were not tuned."""
    if config.gait.form == "rigid":
        return {}
    mesh, person = devices.mesh(), rules.reference(config.gait)
    grouped: dict[Config, dict[str, rules.Rule]] = {}
    for name, rule in rules.RULES.items():
        grouped.setdefault(rules.configured(config, rule), {})[name] = rule
    marks: dict[str, Marks] = {}
    for seen, group in grouped.items():
        exam = finals.examination(seen, rules.act, mesh, seed)
        marks |= {n: exam((rules.strong(r), person))[0] for n, r in group.items()}
    return marks


def lines(folder: Path) -> list[str]:
    """What the end of a run says: how its policy fares, and what one would type next."""
    messages, summary = [], run_folder.read_summary(folder)
    settled = summary.get("finals")
    if summary.get("interrupted") and "algorithm" not in summary:  # other learners' runs end for good
        messages.append(f"it goes on by {shlex.join(['jaxwalk', 'train', '--resume', str(folder)])}")
    if settled:
        own = settled[0]
        messages.append(
            f"it survives {own['survival']:.1%} of the finals' pushes, {own['worst']:.1%} at their worst "
            f"phases, at {own['speed']:.2f} m/s"
        )
        if found := of_rules(run_folder.load_config(folder), run_folder.load_origin(folder).seed):
            name, rule = max(found.items(), key=lambda one: one[1].score)
            messages[-1] += (
                f"; of the rules that learn nothing, {name} is best: "
                f"{rule.survival:.1%}, {rule.worst:.1%}, at {rule.speed:.2f} m/s"
            )
    page = shlex.join(["jaxwalk", "render", str(folder), "--out", f"{folder}.html"])
    return [*messages, f"next: {page}"]
