"""The step back: when it is due, where it goes, and that it saves a walker."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, GaitConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import sensors
from jaxwalk.control.person import Person
from jaxwalk.control.posture import capture_point
from jaxwalk.control.rigid import back_step, controllers, form
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model import anthropometry, kinematics
from jaxwalk.model.engine import Setup
from jaxwalk.task import footstep, scenarios
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import BINS, Profile, Runner

NUMBERS = GaitConfig(
    back_step_margin=0.06, back_step_reach=0.1, back_step_least=0.1, back_step_force=150.0,
    back_step_knee=0.4, back_step_near=0.3, terminal_hip_gain=16.0, swing_rate_max=10.0,
)  # fmt: skip
BONES = kinematics.skeleton(anthropometry.build(BodyConfig()), jnp.float32(1))
LEG = 0.441 + 0.4428  # thigh and shank, m
PACE = (0.954 / 9.81) ** 0.5  # sqrt(L / g) = 0.31184 s


def f(value):
    return jnp.float32(value)


def clock(elapsed=0.3, stance=0):
    """0.04 s of toe-off, then 0.1 s of early swing."""
    return StepClock(jnp.int32(stance), f(elapsed), f(0.6), f(0.1), f(60), f(0.04))


def estimate(speed, hips, touch=(700.0, 0.0), pitch=0.0, stance=0):
    """``hips`` and ``touch``: of the stance leg, then of the other."""
    order = slice(None) if stance == 0 else slice(None, None, -1)
    return sensors.Estimate(
        speed=f(speed), acceleration=f(0), pitch=f(pitch), pitch_rate=f(0),
        joints=jnp.zeros((2, 3)).at[:, 0].set(jnp.array(hips[order])), joint_rates=jnp.zeros((2, 3)),
        touch=jnp.array(touch[order]),
    )  # fmt: skip


def test_the_capture_point_is_that_of_the_linear_pendulum():
    """v sqrt(L / g) ahead of the body, which a lean of 0.1 rad moves by 0.678 x 0.32452 m x sin 0.1."""
    assert capture_point(BONES, estimate(0.8, (0.0, 0.0))) == pytest.approx(0.8 * PACE, rel=1e-5)
    leaning = capture_point(BONES, estimate(0.8, (0.0, 0.0), pitch=0.1))
    assert leaning == pytest.approx(0.8 * PACE + 0.021966, rel=1e-4)


@pytest.mark.parametrize("stance", [0, 1])
@pytest.mark.parametrize(
    ("speed", "stance_hip", "elapsed", "due"),
    [
        # The stance ankle is 0.8838 sin 0.3 = 0.2612 m ahead: 0.2012 m / 0.31184 s = 0.645 m/s are needed.
        (0.64, 0.3, 0.3, True),
        (0.65, 0.3, 0.3, False),
        (-0.5, 0.3, 0.3, True),
        (0.64, 0.3, 0.05, True),
        (0.64, 0.3, 0.03, False),  # toe-off may still help
        (-0.5, -0.3, 0.3, False),  # 0.2012 m behind: -0.5 m/s is not enough to fall back over it
    ],
)
def test_a_step_back_is_due_when_the_capture_point_is_behind_the_stance_foot(
    stance, speed, stance_hip, elapsed, due
):
    seen = estimate(speed, (stance_hip, -0.3), stance=stance)
    assert bool(back_step.needed(NUMBERS, BONES, clock(elapsed, stance), seen)) == due
    without = dataclasses.replace(NUMBERS, back_step=False)
    assert not back_step.needed(without, BONES, clock(elapsed, stance), seen)


@pytest.mark.parametrize("stance", [0, 1])
@pytest.mark.parametrize(
    ("swing_hip", "force", "speed", "landed"),
    [
        (-0.05, 200.0, 0.0, True),  # 0.0883 + 0.0442 m behind the other
        (-0.01, 200.0, 0.0, False),  # 0.0972 m
        (-0.05, 140.0, 0.0, False),  # not yet loaded
        (-0.05, 200.0, 0.8, False),  # moves on: no step back is due
    ],
)
def test_a_step_back_has_landed_far_enough_behind_and_loaded(stance, swing_hip, force, speed, landed):
    seen = estimate(speed, (0.1, swing_hip), touch=(500.0, force), stance=stance)
    assert bool(back_step.touched_down(NUMBERS, BONES, clock(stance=stance), seen)) == landed


def test_the_foot_goes_behind_the_capture_point_and_the_knee_straightens_in_time():
    # At -0.2 m/s: -0.0624 - 0.1 m from the hip; 0.1 m behind the stance ankle would be 0.0765 ahead.
    target = np.arcsin((-0.2 * PACE - 0.1) / 0.954)
    rate, knee = back_step.swing(NUMBERS, BONES, clock(), estimate(-0.2, (0.2, 0.0)))
    assert rate == pytest.approx(16 * target, rel=1e-4) and knee == 0.0
    rate, knee = back_step.swing(NUMBERS, BONES, clock(), estimate(-0.2, (0.2, 0.4)))
    assert rate == pytest.approx(16 * (target - 0.4), rel=1e-4) and knee == pytest.approx(0.4)
    rate, _ = back_step.swing(NUMBERS, BONES, clock(), estimate(-0.2, (0.2, 0.6)))
    assert rate == -10.0  # limited
    # A stance foot further behind than that: 0.1 m behind its ankle.
    place = -LEG * np.sin(0.3) - 0.1
    rate, _ = back_step.swing(NUMBERS, BONES, clock(), estimate(-0.2, (-0.3, -0.3)))
    assert rate == pytest.approx(16 * (np.arcsin(place / 0.954) + 0.3), rel=1e-4)


def test_a_leg_ahead_does_not_push_off():
    """After a step back the leg that trails is ahead of the hip; the paper's equations know no such thing."""
    config = PRESETS["rigid"]

    def torque(hip, **changes):
        who = Person.of(dataclasses.replace(config.gait, **changes), f(1.8), f(75))
        seen = estimate(0.5, (-0.2, hip))
        return form._toe_off(Setup.of(config), who, BONES, seen, jnp.int32(1))[0]

    assert torque(0.3) == 0.0 < torque(-0.3)
    assert torque(0.3, back_step=False) > 0


def test_the_controllers_use_it_only_when_it_is_due():
    def swing_leg(speed):
        seen = estimate(speed, (0.3, 0.35))
        command = controllers.command(NUMBERS, BONES, clock(), seen).reshape(2, 3)
        return command[1], back_step.swing(NUMBERS, BONES, clock(), seen)

    command, (rate, knee) = swing_leg(0.0)
    assert command[0] == rate < 0 and command[1] == knee > 0
    command, _ = swing_leg(1.0)
    assert abs(command[0]) < 1 and command[1] == 0


def test_it_saves_walkers_that_a_push_from_the_front_has_stopped():
    """60 N s soon after touch-down, more than the linear pendulum stands without a step back."""
    config = PRESETS["rigid"]
    many = 8
    cases = scenarios.batch(
        config, np.full(many, -60, np.float32), np.full(many, 0.125, np.float32), scenarios.keys(0, 9, many)
    )
    runner = Runner(Task.of(config), lambda step, observation: step, many)
    step = footstep.nominal_action(Person.of(config.gait, f(1.8), f(75)))

    def survivors(**changes):
        numbers = dataclasses.replace(config.gait, **changes)
        ended = runner.run(step, numbers, Profile(jnp.zeros(BINS), f(0.5)), cases, 9.0)
        return (~ended.state.terminated).sum()

    assert survivors() >= many - 1
    assert survivors(back_step_margin=10.0) <= 1  # never due
