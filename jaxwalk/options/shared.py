"""Options that several commands have: each is a type that brings its help."""

from __future__ import annotations

from typing import Annotated

import tyro

from jaxwalk.config import Engine as _Engine
from jaxwalk.options.parse import Impulses, OptionalFloat

_arg = tyro.conf.arg

Walkers = Annotated[int, _arg(help="Walkers in the test of undisturbed walking.")]
Seconds = Annotated[float, _arg(help="How long they walk, s.")]
MeasuredSeconds = Annotated[float, _arg(help="How long they walk, s; the first 3 are not measured.")]
Speed = Annotated[float, _arg(help="Forward speed that is asked for, m/s.")]
TriedImpulses = Annotated[
    Impulses, _arg(help="Pushes to try, N s, with commas between; positive ones push forward.")
]
AscendingImpulses = Annotated[
    Impulses, _arg(help="Pushes, N s, ascending, with commas between; positive ones push forward.")
]
Phases = Annotated[int, _arg(help="Points of the step at which a push begins, evenly spread.")]
Replicas = Annotated[int, _arg(help="Walkers for each impulse and phase.")]
PushHeight = Annotated[float, _arg(help="Where the push lands, m above the torso's centre.")]
PushDuration = Annotated[float, _arg(help="How long the push lasts, s.")]
PushAgain = Annotated[
    float,
    _arg(help="Seconds after its beginning that the same push comes a second time. Default: it does not."),
]
Slope = Annotated[float, _arg(help="Slope of the floor, degrees, uphill positive; controllers are not told.")]
Delay = Annotated[float, _arg(help="Time by which instruments of torso and soles are told late, s.")]
MotorStrength = Annotated[
    float, _arg(help="Share of their strength that motors have; of those that have one (--actuators).")
]
Stature = Annotated[
    OptionalFloat, _arg(help="Stature of all walkers, m. Default: that of the policy's configuration.")
]
Mass = Annotated[
    OptionalFloat, _arg(help="Mass of all walkers, kg. Default: that of the policy's configuration.")
]
OneStature = Annotated[OptionalFloat, _arg(help="Stature, m. Default: that of the policy's configuration.")]
OneMass = Annotated[OptionalFloat, _arg(help="Mass, kg. Default: that of the policy's configuration.")]
Noise = Annotated[float, _arg(help="Scale of the sensors' noise and bias: 1 realistic, 0 none.")]
Engine = Annotated[
    _Engine,
    _arg(
        help="What moves the walkers: mjx; mujoco (C MuJoCo in doubles, solved to convergence); ode or "
        "ode-quick (the Open Dynamics Engine by its world or its quick step)."
    ),
]
Seed = Annotated[int, _arg(help="Seed of everything that is drawn at random.")]
