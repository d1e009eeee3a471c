"""Numbers by hand for every claim: such that it holds, does not, or cannot be told."""

from __future__ import annotations

import dataclasses

from jaxwalk.paper.claims import registry

ANSWERS = {"holds": 1, "does not hold": -1, "cannot be told": 0}


def about(mean, half, n=40):
    return {"mean": mean, "low": mean - half, "high": mean + half, "n": n}


def signed(sign, size=1.0):
    """Above 0, below it, or on both sides."""
    return about(sign * size, size / 2) if sign else about(size / 10, size)


def shares(sign, bar=0.9):
    """Above the bar, below it, or on both sides."""
    return {1: about(bar + 0.06, 0.03), -1: about(bar - 0.3, 0.05), 0: about(bar, 0.05)}[sign]


def speed(sign):
    mean = {1: about(1.02, 0.01), -1: about(1.3, 0.01), 0: about(1.1, 0.02)}[sign]
    course = {name: [1.0, 0.9, 1.2] for name in ("mean", "low", "high")}
    return {"speed": mean, "late": about(0.8, 0.1), "steps": 99, "course": course}


def filters(sign):
    ratio = {1: about(0.2, 0.05), -1: about(0.9, 0.05), 0: about(0.5, 0.05)}[sign]
    signal = {
        "roughness": {stage: about(0.1, 0.01) for stage in ("raw", "mean", "filtered")},
        "mean_to_raw": about(0.2, 0.1),
        "filtered_to_mean": about(0.6, 0.1),
        "filtered_to_raw": ratio,
    }
    errors = {stage: about(0.02, 0.01) for stage in ("raw", "mean", "filtered")}
    example = {stage: [[1.0, 0.1], [1.1, -0.1]] for stage in ("raw", "mean", "filtered")}
    both = {"acceleration": signal, "velocity": {**signal, "error": errors}}
    return {"walkers": 9, "timestep": 0.002, "example": example, **both}


def pushes(sign):
    from jaxwalk.paper.claims.pushes import IMPULSES, POINTS

    rows = [
        {"impulse": i, "point": p, "up": shares(1), "steady": shares(sign), "longest": 1.5}
        for i in IMPULSES
        for p in POINTS
    ]
    return {"rows": rows, "all": {"+30": shares(1), "-40": shares(sign)}}


def pitch(sign):
    swing = {1: about(0.08, 0.01), -1: about(0.2, 0.01), 0: about(0.1, 0.02)}[sign]
    mean = about(0.09, 0.01)
    return {"swing": swing, "largest": 0.2, "mean": mean, "timestep": 0.002, "example": [0.0, 0.1]}


def steps(sign):
    both = {"length": signed(sign, 0.1), "duration": signed(-1, 0.01)}
    back = {"length": signed(-1, 0.1), "duration": signed(1, 0.01)}
    point = {"walker": 0, "push": "forward", "when": "before"} | {
        "speed": 1.0,
        "length": 0.6,
        "duration": 0.1,
    }
    return {"slopes": both, "changes": {"forward": both, "backward": back}, "points": [point]}


def phases(sign):
    toe_off, swing = {1: (0.9, 0.5), -1: (0.5, 0.9), 0: (0.7, 0.69)}[sign]
    both = {"toe-off": about(toe_off, 0.05), "swing": about(swing, 0.05)}
    rows = [{"impulse": 60.0, "part": "swing", "phase": 0.3, **about(swing, 0.05)}]
    ways = dict.fromkeys(("both ways", "forward", "backward"), both)
    return {"parts": {"toe-off": [0.0, 0.15], "swing": [0.15, 0.5]}, "ways": ways, "rows": rows}


def trade(sign):
    def row(speed, up):
        survived = [True] * up + [False] * (20 - up)
        speeds = [speed - 0.01, speed, speed + 0.01]
        told = {"calm": shares(1), "pushed": about(up / 20, 0.05), "speed": about(speed, 0.01)}
        return {**told, "speeds": speeds, "survived": survived}

    slow, fast = {1: (19, 5), -1: (5, 19), 0: (11, 10)}[sign]
    return {
        "desired speed": {"0.8": row(0.8, slow), "1.2": row(1.2, fast)},
        "ankle damping": {"0.25": row(1.2, 5), "4": row(0.8, 19)},
    }


def trained(full, other, name, curves=(0.9, 0.5)):
    def runs(share, height):
        return [
            {
                "seed": seed,
                "curve": {
                    "footsteps": [2000, 4000], "survival": [height, height + seed / 100], "score": [0, 0],
                },
                "calm": shares(1), "pushed": about(share, 0.04), "speed": about(1.0, 0.01),
            }
            for seed in range(3)
        ]  # fmt: skip

    exam = {"calm": shares(1), "pushed": about(0.4, 0.04), "speed": about(1.0, 0.01)}
    pair = {"full": runs(full, curves[0]), name: runs(other, curves[1])}
    return {"missing": [], "runs": pair, "fixed": exam}


def state(sign):
    return trained(*{1: (0.9, 0.35), -1: (0.9, 0.8), 0: (0.9, 0.45)}[sign], "pair")


def rates(sign):
    return trained(*{1: (0.8, 0.9), -1: (0.9, 0.4), 0: (0.9, 0.85)}[sign], "printed")


def start(sign):
    found = trained(0.9, 0.9, "random", {1: (0.9, 0.5), -1: (0.5, 0.9), 0: (0.7, 0.7)}[sign])
    if sign == 0:
        found["runs"]["random"][0]["curve"]["survival"] = [0.1, 0.1]
        found["runs"]["random"][1]["curve"]["survival"] = [0.95, 0.99]
    return found


def loads(sign):
    both = (("nothing to carry", 1), ("10 kg backpack", sign))
    rows = [{"case": c, "height": 1.8, "pack": 0.0, "up": shares(s), "speed": about(1, 0.1)} for c, s in both]
    return {"seconds": 8.0, "rows": rows}


def controllers(sign):
    from jaxwalk.paper.claims.controllers import ALL, FROZEN, TAKEN

    without = {1: 0.3, -1: 0.95, 0: 0.68}[sign]
    shares_of = dict.fromkeys((*TAKEN.values(), FROZEN), 0.2) | {TAKEN["toe-off"]: without, ALL: 0.7}
    order = (ALL, *TAKEN.values(), FROZEN)
    rows = {
        n: {"calm": shares(1), "pushed": about(shares_of[n], 0.05), "speed": about(1, 0.1)} for n in order
    }
    return {"torque": 80.0, "rows": rows}


def bodies(sign):
    speed = {1: about(1.02, 0.01), -1: about(1.3, 0.01), 0: about(1.1, 0.02)}[sign]
    return {
        "speed": speed, "length": about(0.45, 0.01), "duration": about(0.44, 0.01),
        "threshold": {"forward": 30.0, "backward": 60.0},
        "rows": [{"impulse": i, **shares(1)} for i in (-60.0, -40.0, 30.0)],
    }  # fmt: skip


NUMBERS = {
    "speed": speed, "filters": filters, "pushes": pushes, "pitch": pitch, "steps": steps, "phases": phases,
    "trade": trade, "state": state, "rates": rates, "start": start, "loads": loads,
    "controllers": controllers, "bodies": bodies,
}  # fmt: skip


def claims(measured, drawn=False):
    """The claims with numbers by which they hold in place of measurements.

    ``measured`` gets (claim, body) of each that is made. Figures take time: there are none unless asked for.
    """

    def measure(name):
        def made(lab, model):
            measured.append((name, model))
            return NUMBERS[name](1)

        return made

    return {
        name: dataclasses.replace(claim, measure=measure(name), draw=claim.draw if drawn else None)
        for name, claim in registry().items()
    }
