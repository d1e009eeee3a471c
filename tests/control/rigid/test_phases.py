"""The gait's clock, and what counts as a touch-down."""

import dataclasses

import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, GaitConfig, PhysicsConfig
from jaxwalk.config.gait import SWITCHES
from jaxwalk.control import scaling, sensors, step_clock
from jaxwalk.control.rigid import phases
from jaxwalk.control.rigid.phases import Phase
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model import anthropometry, kinematics, physics
from jaxwalk.model.similarity import Similarity

NUMBERS = GaitConfig(touchdown_share=0.5, touchdown_ahead=0.02, touchdown_force=20.0)
SKELETON = kinematics.skeleton(anthropometry.build(BodyConfig()), jnp.float32(1))


def clock(elapsed, stance=0):
    """0.04 s of toe-off, then 0.2 s of early swing."""
    return StepClock(
        stance=jnp.int32(stance),
        elapsed=jnp.float32(elapsed),
        length=jnp.float32(0.8),
        duration=jnp.float32(0.2),
        toe_off=jnp.float32(90),
        toe_off_seconds=jnp.float32(0.04),
    )


def estimate(hips=(0.0, 0.0), touch=(0.0, 0.0), pitch=0.0, speed=1.0):
    zero = jnp.zeros(())
    return sensors.Estimate(
        speed=jnp.float32(speed), acceleration=zero, pitch=jnp.float32(pitch), pitch_rate=zero,
        joints=jnp.zeros((2, 3)).at[:, 0].set(jnp.array(hips)), joint_rates=jnp.zeros((2, 3)),
        touch=jnp.array(touch),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("elapsed", "phase", "progress"),
    [
        (0.0, Phase.TOE_OFF, -0.2),  # (0 - 0.04) / 0.2
        (0.039, Phase.TOE_OFF, -0.005),
        (0.041, Phase.EARLY_SWING, 0.005),
        (0.14, Phase.EARLY_SWING, 0.5),
        (0.239, Phase.EARLY_SWING, 0.995),
        (0.241, Phase.TERMINAL_SWING, 1.005),
        (3.0, Phase.TERMINAL_SWING, 14.8),
    ],
)
@pytest.mark.parametrize("stance", [0, 1])
def test_a_step_goes_through_its_phases_by_the_clock(elapsed, phase, progress, stance):
    now = clock(elapsed, stance)
    assert int(phases.swing_phase(now)) == phase
    assert phases.swing_progress(now) == pytest.approx(progress, abs=1e-5)
    assert now.is_stance.tolist() == [stance == 0, stance == 1]


@pytest.mark.parametrize("stance", [0, 1])
def test_step_length_is_how_far_the_swing_ankle_leads(stance):
    # Thighs at +0.3 and -0.2 rad, legs 0.8838 m: 0.8838 (sin 0.3 + sin 0.2) = 0.43676 m. The torso's
    # pitch is in the hip angles: the legs stand where they stood.
    for pitch in (0.0, 0.15):
        hips = [-0.2 + pitch, 0.3 + pitch]
        seen = estimate(hips=hips if stance == 0 else hips[::-1], pitch=pitch)
        assert step_clock.step_length(SKELETON, clock(0.1, stance), seen) == pytest.approx(0.43676, abs=2e-5)
        assert step_clock.step_length(SKELETON, clock(0.1, 1 - stance), seen) == pytest.approx(
            -0.43676, abs=2e-5
        )


def test_ankles_are_where_mujoco_puts_them():
    height = 1.63
    model = physics.compile_mujoco(BodyConfig(height=height), PhysicsConfig())
    skeleton = kinematics.skeleton(anthropometry.build(BodyConfig()), jnp.float32(height / 1.8))
    data = mujoco.MjData(model)
    data.qpos[:] = [0.7, 2.0, 0.2, 0.4, 0.9, 0.3, -0.5, 0.1, -0.2]
    mujoco.mj_forward(model, data)
    x, z = kinematics.ankles(skeleton, jnp.float32(data.qpos[3:].reshape(2, 3)), jnp.float32(0.2))
    for side, name in enumerate(("left", "right")):
        ankle = data.body(f"foot_{name}").xpos - data.body("torso").xpos
        assert (x[side], z[side]) == pytest.approx((ankle[0], ankle[2]), abs=1e-6)


# Swing leg right, 0.3 rad ahead against -0.2 rad, 60 N under it, 60 % of early swing over: it has landed.
LANDED = dict(elapsed=0.16, hips=(-0.2, 0.3), touch=(700.0, 60.0), speed=1.0)


@pytest.mark.parametrize(
    ("change", "landed"),
    [
        ({}, True),
        ({"elapsed": 0.138}, False),  # 49 % of early swing: too early
        ({"elapsed": 0.142}, True),
        ({"elapsed": 0.02}, False),  # still pushing off
        ({"hips": (0.1, 0.1)}, False),  # beside the other foot
        ({"hips": (0.3, -0.2)}, False),  # behind it
        ({"hips": (0.0, 0.0227)}, True),  # 0.8838 sin 0.0227 = 0.0201 m ahead
        ({"hips": (0.0, 0.0225)}, False),  # 0.0199 m
        ({"touch": (700.0, 19.0)}, False),  # hardly touches
        ({"touch": (700.0, 21.0)}, True),
        ({"touch": (0.0, 60.0)}, True),  # the other foot need not carry
        ({"speed": -0.01}, False),  # a foot ahead carries nobody who moves backward
    ],
)
@pytest.mark.parametrize("stance", [0, 1])
def test_a_touchdown_is_late_enough_far_enough_and_firm_enough(change, landed, stance):
    case = LANDED | change
    order = slice(None) if stance == 0 else slice(None, None, -1)
    seen = estimate(hips=case["hips"][order], touch=case["touch"][order], speed=case["speed"])
    assert bool(phases.touched_down(NUMBERS, SKELETON, clock(case["elapsed"], stance), seen)) == landed


def test_without_the_step_back_a_foot_ahead_lands_whatever_the_speed():
    seen = estimate(hips=LANDED["hips"], touch=LANDED["touch"], speed=-0.01)
    paper = dataclasses.replace(NUMBERS, back_step=False)
    assert phases.touched_down(paper, SKELETON, clock(LANDED["elapsed"]), seen)


LEGS = {
    "rotational_damping": (80, "hip_damping knee_damping ankle_damping swing_damping swing_knee_damping "
                               "landing_knee_damping swing_ankle_damping back_knee_damping"),
    "rate": (0.5, "hip_rate_max swing_rate_max"),
    "rate^2": (0.25, "swing_acceleration_most"),
    "speed": (2, "hip_speed_min speed_usual lag_speed"),
    "torque": (40, "knee_stiffness ankle_stiffness push_off_torque swing_stiffness swing_knee_stiffness "
                   "landing_knee_stiffness swing_ankle_stiffness knee_stop back_knee_stiffness ankle_stop"),
    "time": (2, "length_speed capture_speed "
                "knee_seconds toe_off_seconds landing_seconds landing_time passing_seconds swing_soonest "
                "lag_seconds"),
    "length": (4, "landing_capture landing_behind back_ahead lag_most"),
    "force": (10, "back_force"),
    "torque for each m/s": (20, "push_off_gain push_off_speed"),
    "torque for each m": (10, "ankle_capture_gain lag_push_off"),
    "angle for each m": (0.25, "pitch_capture_gain lag_pitch"),
}  # fmt: skip
PLAN = {
    "length": (4, "change_length length_least back_margin back_reach back_least pitch_gain"),
    "time": (2, "change_duration duration_least duration_most back_time back_latest back_soonest"),
    "speed": (2, "back_speed"),
    "time for each m": (0.5, "duration_gain"),
}


def _scaled_alike(before, after, kinds):
    factors = {name: factor for factor, names in kinds.values() for name in names.split()}
    for field in dataclasses.fields(before):
        old, new = getattr(before, field.name), getattr(after, field.name)
        np.testing.assert_allclose(new, old * factors.get(field.name, 1), err_msg=field.name)


def test_numbers_scale_by_dynamic_similarity():
    """A body four times as long and 10 times as heavy: times 2, speeds 2, rates 1/2, torques 40."""
    numbers = GaitConfig()
    large = scaling.scaled(numbers, Similarity(4.0, 10.0))
    factors = {
        "length_nominal": 4, "length_min": 4, "length_max": 4, "touchdown_ahead": 4,
        "duration_nominal": 2, "duration_min": 2, "duration_max": 2, "stall_seconds": 2,
        "toe_off_duration": 2, "toe_off_duration_min": 2, "toe_off_duration_max": 2,
        "stance_rate_max": 0.5, "swing_rate_max": 0.5, "terminal_hip_gain": 0.5,
        "stance_speed_min": 2,
        "ankle_stiffness": 40, "toe_off_full": 40,
        "ankle_rate_gain": 80,  # torque per rate
        "toe_off_gain": 20,  # torque per speed
        "back_step_margin": 4, "back_step_reach": 4, "back_step_least": 4, "back_step_force": 10,
        "restart_seconds": 2, "restart_torque": 40,
        "touchdown_force": 10,
    }  # fmt: skip
    for field in dataclasses.fields(GaitConfig):
        before, after = getattr(numbers, field.name), getattr(large, field.name)
        if field.name in SWITCHES:
            assert after == before
        elif field.name == "compliant":
            _scaled_alike(before, after, LEGS)
        elif field.name == "step_plan":
            _scaled_alike(before, after, PLAN)
        else:
            # What is not listed is an angle, a share, or the speed that the user asked for.
            np.testing.assert_allclose(after, before * factors.get(field.name, 1), err_msg=field.name)


@pytest.mark.parametrize(
    ("elapsed", "latched", "torque", "seconds"),
    [
        (0.01, False, 120.0, 0.06),  # the walker is slower than at touch-down: more
        (0.039, False, 120.0, 0.06),
        (0.04, False, 90.0, 0.04),  # over: the foot has left
        (0.01, True, 90.0, 0.04),  # the paper's: set at touch-down
    ],
)
def test_toe_off_grows_while_it_lasts(elapsed, latched, torque, seconds):
    numbers = dataclasses.replace(NUMBERS, toe_off_latched=latched)
    after = phases.pressed(numbers, clock(elapsed), jnp.float32(120), jnp.float32(0.06))
    assert (after.toe_off, after.toe_off_seconds) == pytest.approx((torque, seconds))


def test_toe_off_never_shrinks():
    after = phases.pressed(NUMBERS, clock(0.01), jnp.float32(60), jnp.float32(0.03))
    assert (after.toe_off, after.toe_off_seconds) == pytest.approx((90.0, 0.04))
