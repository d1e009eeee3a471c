"""What the moving mean and the Kalman filter make of acceleration and velocity."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.verdict import Check, below, mean_of, told

STAGES = ("raw", "mean", "filtered")
LABELS = {"raw": "as measured", "mean": "after the moving mean", "filtered": "after the Kalman filter too"}
SMOOTHER, HALF, OFF = 1.0, 0.5, 0.05  # ratios of the change from tick to tick; m/s
SHOWN = 500  # ticks in the figure


def measure(lab: Lab, model: BodyModel) -> Numbers:
    trace = lab.trace(model)
    up = np.flatnonzero(~trace.fell.any(axis=1))
    dt = lab.timestep(model)
    found: dict = {"walkers": len(up), "timestep": dt}
    for column, name in enumerate(("velocity", "acceleration")):
        rough = {
            stage: np.sqrt(np.mean(np.diff(getattr(trace, stage)[up, :, column], axis=1) ** 2, axis=1))
            for stage in STAGES
        }
        found[name] = {
            "roughness": {stage: mean_of(rough[stage]) for stage in STAGES},
            "mean_to_raw": mean_of(rough["mean"] / rough["raw"]),
            "filtered_to_mean": mean_of(rough["filtered"] / rough["mean"]),
            "filtered_to_raw": mean_of(rough["filtered"] / rough["raw"]),
        }
    errors = {s: getattr(trace, s)[up, :, 0] - trace.velocity[up] for s in STAGES}
    found["velocity"]["error"] = {s: mean_of(np.sqrt(np.mean(e**2, axis=1))) for s, e in errors.items()}
    if len(up):
        one = up[0]
        found["example"] = {
            stage: getattr(trace, stage)[one, :SHOWN].astype(float).round(4).tolist() for stage in STAGES
        }
    return found


def checks(numbers: Numbers) -> tuple[Check, ...]:
    out = []
    for name in ("acceleration", "velocity"):
        for key, words, bar in (
            ("mean_to_raw", "moving mean to measured", SMOOTHER),
            ("filtered_to_mean", "Kalman filter to moving mean", SMOOTHER),
            ("filtered_to_raw", "Kalman filter to measured", HALF),
        ):
            message = f"{name}, change from tick to tick, {words}: {told(numbers[name][key], '.2f')}"
            out.append(Check(message, below(numbers[name][key], bar)))
    error = numbers["velocity"]["error"]["filtered"]
    out.append(
        Check(
            f"filtered velocity off the true one by {told(error)} m/s (root mean square)", below(error, OFF)
        )
    )
    return tuple(out)


def table(numbers: Numbers) -> list[dict[str, object]]:
    units = {"velocity": "m/s", "acceleration": "m/s^2"}
    return [
        {
            "signal": name, "stage": stage, "unit": units[name],
            **{f"change_per_tick_{k}": v for k, v in numbers[name]["roughness"][stage].items()},
            "rms_error": numbers[name].get("error", {}).get(stage, {}).get("mean"),
        }
        for name in units
        for stage in STAGES
    ]  # fmt: skip


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(2, len(numbers), width=5.0, sharex=True, sharey="row")
    looks = {"raw": ("0.75", 0.8), "mean": (pictures.ORANGE, 1.0), "filtered": (pictures.BLUE, 1.6)}
    for column, one in enumerate(numbers.values()):
        for stage in STAGES:
            if "example" not in one:
                continue
            both = np.array(one["example"][stage])
            x = np.arange(len(both)) * one["timestep"]
            for row, signal in ((0, 1), (1, 0)):
                colour, width = looks[stage]
                axes[row, column].plot(x, both[:, signal], color=colour, linewidth=width, label=LABELS[stage])
        axes[1, column].set_xlabel("s")
    axes[0, 0].set_ylabel("acceleration, m/s²")
    axes[1, 0].set_ylabel("velocity, m/s")
    pictures.legend(figure, axes[0, 0])
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="filters",
    title="A moving mean and a Kalman filter make the signals usable",
    says="Acceleration and velocity of the torso pass a moving mean and a Kalman filter before the "
    "zero-moment point is computed of them; both come out smooth.",
    where="Fig. 3; eq. 4",
    rule="Each of the two filters lessens the change from tick to tick (root mean square) of acceleration "
    f"and of velocity, both together to below {HALF:g} of what was measured, and the filtered velocity "
    f"stays within {OFF:g} m/s (root mean square) of the true one; with all of the 95 % intervals.",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
