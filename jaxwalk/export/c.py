"""The policy and its controllers as one C99 header: ``controller.h`` with its numbers filled in."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from jaxwalk.config import DELAY_MOST, Observable
from jaxwalk.deploy import soundness
from jaxwalk.learn.policies import policy

_TEMPLATE = Path(__file__).with_name("controller.h")
_COMMANDS = {
    "rigid": "hip rate (rad/s), knee angle (rad), ankle torque (N m, dorsiflexion positive)",
    "compliant": "torques of hip, knee and ankle (N m; forward, flexion, dorsiflexion positive)",
}
_WIDTH = 100  # of the lines of numbers


def header(trained: policy.Policy, told: dict[str, Any]) -> bytes:
    """The header's text."""
    filled = _TEMPLATE.read_text()
    form = told["switches"]["form"]
    parts = {
        "VERSION": told["jaxwalk_version"],
        "COMMANDS": _COMMANDS[form],
        "DATA": _data(trained, told),
        "LAYERS": _layers(told),
        "LEGS": _TEMPLATE.with_name(f"{form}.h").read_text().rstrip() + "\n",
    }
    for name, text in parts.items():
        filled = filled.replace(f"@{name}@", text)
    return filled.encode()


def number(value: float | np.floating) -> str:
    """A float constant that reads back bit for bit."""
    text = np.format_float_scientific(np.float32(value), unique=True, trim="0")
    return f"{text}f"


def array(name: str, values: ArrayLike) -> str:
    """A constant array of floats, row by row."""
    lines, line = [], "   "
    for text in map(number, np.asarray(values, np.float32).ravel()):
        if len(line) + len(text) + 2 > _WIDTH:
            lines, line = [*lines, line], "   "
        line += f" {text},"
    body = "\n".join([*lines, line])
    return f"static const float {name}[{np.size(values)}] = {{\n{body}\n}};"


def _data(trained: policy.Policy, told: dict[str, Any]) -> str:
    names = [one["name"] for one in told["observation"]]
    low, high = ([one[end] for one in told["action"]] for end in ("low", "high"))
    gait, sensors = told["switches"], told["sensors"]
    values = {
        "TIMESTEP": told["timestep"],
        "GRAVITY": told["gravity"],
        "REFERENCE_HEIGHT": told["reference"]["height"],
        "REFERENCE_MASS": told["reference"]["mass"],
        "HEIGHT": told["person"]["height"],
        "MASS": told["person"]["mass"],
        "SPEED": told["numbers"]["speed_desired"]["value"],
        "DELAY_MOST": DELAY_MOST,
        "DELAY_TRAINED": told["delay_trained"],
        "SPEED_LEAST": told["speeds"][0],
        "SPEED_MOST": told["speeds"][1],
        "CLIP": told["observation_clip"] or 0.0,
    }
    counts = {
        "OBSERVATIONS": len(names),
        "ACTIONS": len(low),
        "WIDEST": max(len(names), len(low), *told["hidden"]),
        "MEAN_WINDOW": sensors["mean_window"],
        "BACK_STEP": int(gait["back_step"]),
        "TOE_OFF_LEGS": {"linear": 0, "one-leg": 1, "paper": 2}[gait["toe_off_form"]],
        "TOE_OFF_LATCHED": int(gait["toe_off_latched"]),
        "PLANNED": int(gait["steps"] == "planned"),
        "REPLAN": told["decisions"]["replan"],
        "WINDOW_TICKS": told["decisions"]["window_ticks"],
        "INPUTS": len(soundness.MOST),
        "HOLD_TICKS": soundness.hold_ticks(told["timestep"]),
        "LIMITED": int(told["strength"] is not None),
    }
    known = [*(f"JAXWALK_{name.upper()}_SEEN" for name in get_args(Observable)), "JAXWALK_SEEN"]
    seen = ", ".join(f"JAXWALK_{name.upper()}_SEEN" for name in names)
    arrays = [
        array("jaxwalk_mean", trained.observation_mean),
        array("jaxwalk_std", trained.observation_std),
        array("jaxwalk_low", np.array(low)),
        array("jaxwalk_high", np.array(high)),
        array("jaxwalk_most", soundness.MOST),
        array("jaxwalk_gain", np.array(sensors["kalman_gain"])),
        *(
            array(f"jaxwalk_{layer}_{leaf}", values)
            for layer, leaves in trained.actor.items()
            for leaf, values in sorted(leaves.items())
        ),
    ]
    return "\n".join(
        [
            f'#define JAXWALK_VERSION "{told["jaxwalk_version"]}"',
            f"#define JAXWALK_FORMAT {told['format_version']}",
            *(f"#define JAXWALK_{name} {number(value)}" for name, value in values.items()),
            *(f"#define JAXWALK_{name} {value}" for name, value in counts.items()),
            "",
            _names("observation", told["observation"]),
            _names("action", told["action"]),
            f"enum {{ {', '.join(known)} }};",
            f"static const int jaxwalk_seen[JAXWALK_OBSERVATIONS] = {{{seen}}};",
            "",
            *arrays,
            *_strength(told),
            "",
            *_numbers(told["numbers"]),
        ]
    )


def _strength(told: dict[str, Any]) -> Iterable[str]:
    """Of compliant legs' joints, forward and back: [2][3] largest torque, and two rates."""
    if told["switches"]["form"] != "compliant":
        return
    # Transposed: each joint's three numbers together.
    own = np.zeros((2, 3, 3)) if told["strength"] is None else np.array(told["strength"]).transpose(0, 2, 1)
    rows = ", ".join(
        "{" + ", ".join("{" + ", ".join(map(number, joint)) + "}" for joint in way) + "}" for way in own
    )
    yield f"static const float jaxwalk_strength[2][3][3] = {{{rows}}};"


def _names(what: str, ones: Iterable[dict[str, Any]]) -> str:
    """A C array of names and units, for whoever prints them."""
    rows = ", ".join(f'{{"{one["name"]}", "{one["unit"]}"}}' for one in ones)
    return f"static const char *const jaxwalk_{what}_names[][2] = {{{rows}}};"


def _numbers(numbers: dict[str, dict[str, Any]]) -> Iterable[str]:
    """The struct of the controllers' numbers, and how it goes with stature and mass."""
    yield "/* The controllers' numbers; their meaning is said in jaxwalk.config.GaitConfig. */"
    yield "struct jaxwalk_numbers {"
    yield from (f"    float {name}; /* {one['unit']} */" for name, one in numbers.items())
    yield "};"
    yield ""
    yield "/* The reference body's carried to ratios of stature h and mass m, by dynamic similarity. */"
    yield "static inline void jaxwalk_scale(struct jaxwalk_numbers *n, float h, float m) {"
    for name, one in numbers.items():
        powers = [
            f"powf({base}, {number(one[key])})" for base, key in (("h", "length"), ("m", "mass")) if one[key]
        ]
        yield f"    n->{name} = {' * '.join([number(one['value']), *powers])};"
    yield "}"


def _layers(told: dict[str, Any]) -> str:
    """Calls of the dense layers, from x to y and back."""
    widths = [len(told["observation"]), *told["hidden"], len(told["action"])]
    names = [*(f"hidden_{i}" for i in range(len(told["hidden"]))), "output"]
    lines = []
    for name, inputs, outputs in zip(names, widths[:-1], widths[1:], strict=True):
        lines.append(
            f"    jaxwalk_dense(jaxwalk_{name}_kernel, jaxwalk_{name}_bias, {inputs}, {outputs}, x, y);"
        )
        if name != "output":
            lines.append(f"    for (int i = 0; i < {outputs}; ++i) x[i] = fmaxf(y[i], 0.0f);")
    return "\n".join(lines)
