"""Controllers against numbers worked by hand from the paper's equations."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, GaitConfig
from jaxwalk.control import scaling, sensors
from jaxwalk.control.rigid import controllers
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model import anthropometry, kinematics
from jaxwalk.model.similarity import Similarity

# Round numbers, so that arithmetic can be done in the comments.
NUMBERS = GaitConfig(
    speed_desired=1.0, pitch_nominal=0.02, stance_rate_max=6.0, stance_speed_min=0.5, swing_rate_max=8.0,
    swing_pitch_gain=0.5, swing_knee=1.2, swing_knee_share=0.6, swing_ankle=0.25, terminal_hip_gain=5.0,
    ankle_stiffness=77.0, ankle_rate_gain=1.0, toe_off_form="linear", toe_off_duration=0.05,
    toe_off_duration_min=0.02, toe_off_duration_max=0.08, toe_off_full=60.0, toe_off_ankle=0.5,
    toe_off_gain=400.0, toe_off_speed=1.5,
)  # fmt: skip
BONES = kinematics.skeleton(anthropometry.build(BodyConfig()), jnp.float32(1))


def f(value):
    return jnp.float32(value)


@pytest.mark.parametrize(
    ("speed", "angle", "pitch", "rate"),
    [
        (1.0, 0.0, 0.02, -1.1111),  # a' = v / (L cos a) = 1 / 0.9; w = -a' phi / phi0 = -a'
        (1.0, 0.0, 0.04, -2.2222),  # twice the pitch, twice the rate: it falls back
        (1.0, 0.0, -0.01, 0.5556),  # leaning back turns the other way
        (1.0, 0.3, 0.02, -1.1630),  # 1 / (0.9 cos 0.3) = 1 / (0.9 x 0.95534)
        (1.0, -0.3, 0.02, -1.1630),
        (0.2, 0.0, 0.02, -0.5556),  # never slower than 0.5 m/s: 0.5 / 0.9
        (-1.0, 0.0, 0.02, -0.5556),
        (1.0, 0.0, 0.5, -6.0),  # limited
        (1.0, 0.0, -0.5, 6.0),
    ],
)
def test_stance_turns_the_hip_in_proportion_to_pitch(speed, angle, pitch, rate):
    told = controllers.stance_hip_rate(NUMBERS, f(0.9), f(speed), f(angle), f(pitch))
    assert told == pytest.approx(rate, abs=1e-4)


def test_the_pitch_comes_to_rest_at_phi0():
    """Eqs 10-13: the torso turns at a' + w, which is nought at phi0 and pulls back from either side."""

    def torso_rate(pitch, speed=1.2, angle=0.2, leg=0.9):
        return speed / (leg * np.cos(angle)) + float(
            controllers.stance_hip_rate(NUMBERS, f(leg), f(speed), f(angle), f(pitch))
        )

    assert torso_rate(0.02) == pytest.approx(0.0, abs=1e-6)
    assert torso_rate(0.03) < 0 < torso_rate(0.01)


@pytest.mark.parametrize(
    ("target", "angle", "left", "rate"),
    [
        (0.5, 0.1, 0.1, 4.0),  # 0.4 rad in 0.1 s
        (0.1, 0.5, 0.1, -4.0),
        (0.5, 0.1, 0.02, 8.0),  # 20 rad/s: limited
        (0.5, 0.1, 0.0, 8.0),  # no time left: still finite
        (0.1, 0.5, -0.1, -8.0),
    ],
)
def test_early_swing_arrives_in_time(target, angle, left, rate):
    assert controllers.early_swing_hip_rate(NUMBERS, f(target), f(angle), f(left)) == pytest.approx(rate)


def test_terminal_swing_closes_in_on_the_target():
    assert controllers.terminal_swing_hip_rate(NUMBERS, f(0.5), f(0.1)) == pytest.approx(2.0)  # 5 x 0.4


@pytest.mark.parametrize(
    ("length", "pitch", "target"),
    [
        (0.9, 0.0, 0.5236),  # asin(0.45 / 0.9) = 30 degrees
        (0.9, 0.1, 0.5736),  # and half of the pitch
        (0.0, 0.0, 0.0),
        (5.0, 0.0, 1.2532),  # longer than legs reach: asin 0.95
    ],
)
def test_swing_target_lands_half_a_step_ahead_of_the_hip(length, pitch, target):
    assert controllers.swing_target(NUMBERS, f(0.9), f(length), f(pitch)) == pytest.approx(target, abs=1e-4)


@pytest.mark.parametrize(
    ("knee", "inertia"),
    [
        (0.0, 2.1333),  # straight: one rod of 10 kg and 0.8 m about its end, 10 x 0.64 / 3
        # Right angle: thigh 5 x 0.16 / 3 = 0.26667; shank 5 x (0.16 / 12 + 0.4^2 + 0.2^2) = 1.06667.
        (np.pi / 2, 1.3333),
        # Folded: thigh 0.26667; shank's middle 0.2 m from the hip, 5 x (0.16 / 12 + 0.04) = 0.26667.
        (np.pi, 0.5333),
    ],
)
def test_inertia_is_that_of_two_rods(knee, inertia):
    """A leg about the hip; legs about the front ankle are rods of the same kind."""
    assert controllers.rods_inertia(f(5.0), f(0.4), f(np.pi - knee)) == pytest.approx(inertia, abs=1e-4)


def toe_off(form, speed, **changes):
    numbers = dataclasses.replace(NUMBERS, toe_off_form=form, **changes)
    inertias = controllers.Inertias(torso=f(12.0), leg_mass=f(6.0), damping=f(1.0))
    return float(controllers.toe_off_torque(numbers, inertias, f(0.9), f(speed), f(-0.3), f(0.3), f(0.0)))


def test_the_papers_toe_off_restores_the_speed_lost():
    # Eqs 14-22: dv = 1 x 1 - 0.8 = 0.2 m/s; da' = 0.2 / (0.9 cos 0.3) = 0.23261 rad/s;
    # Legs of 12 kg and 0.9 m, 0.6 rad apart, about the front ankle: 3.24 of the front one; of the trailing
    # one, by the law of cosines, 0.81 + 12 x 0.81 (1.25 - cos 0.6) = 4.9377;
    # tau = c da' + (12 + 8.1777) 0.23261 / 0.05 = 0.2326 + 93.870.
    restored = functools.partial(toe_off, "paper", toe_off_speed=1.0)
    assert restored(0.8) == pytest.approx(94.10, abs=0.01)
    # Before, J_leg was 12 kg x 0.9^2 / 3 = 3.24: 0.2326 + (12 + 3.24) 0.23261 / 0.05 = 71.13.
    assert toe_off("one-leg", 0.8, toe_off_speed=1.0) == pytest.approx(71.13, abs=0.01)
    # Half the time, twice the effort; the damping's share stays.
    assert restored(0.8, toe_off_duration=0.025) == pytest.approx(187.97, abs=0.01)
    assert restored(1.0) == pytest.approx(0.0, abs=1e-4)
    assert restored(1.5) == 0.0  # the foot cannot pull
    # The speed that is aimed at may be more at touch-down than on the mean.
    assert toe_off("paper", 1.1, toe_off_speed=1.3) == pytest.approx(94.10, abs=0.01)


def test_the_tuned_toe_off_is_a_line_in_the_speed_lost():
    assert toe_off("linear", 1.2) == pytest.approx(120.0, abs=1e-3)  # 400 (1.5 - 1.2)
    assert toe_off("linear", 1.4) == pytest.approx(40.0, abs=1e-3)
    assert toe_off("linear", 2.0) == 0.0  # the foot cannot pull
    assert toe_off("linear", 0.55, speed_desired=0.5) == pytest.approx(80.0, abs=1e-3)  # 1.5 x 0.5 - 0.55


@pytest.mark.parametrize(
    ("asked", "torque", "seconds"),
    [
        (100.0, 100.0, 0.05),
        (150.0, 150.0, 0.05),
        (180.0, 150.0, 0.06),  # 180 x 0.05 = 150 x 0.06 N m s
        (300.0, 150.0, 0.08),  # would take 0.1 s: at most 0.08
        (30.0, 30.0, 0.025),  # half of what makes a full push: half the time
        (0.0, 0.0, 0.02),
    ],
)
def test_a_strong_push_is_longer_and_a_weak_one_shorter(asked, torque, seconds):
    told = controllers.push_off(NUMBERS, f(150.0), f(asked))
    assert [float(x) for x in told] == pytest.approx([torque, seconds])


def test_the_ankle_servo_is_a_damped_spring():
    # 77 (0.2 - 0.1) - 1 x 2
    assert controllers.ankle_servo(NUMBERS, f(0.2), f(0.1), f(2.0)) == pytest.approx(5.7, abs=1e-4)


# Left leg stands, right leg swings; 0.05 s of toe-off, then 0.2 s of early swing.
JOINTS = np.array([[0.1, 0.05, -0.1], [0.15, 0.6, 0.2]], np.float32)
RATES = np.array([[-1.0, 0.2, 1.0], [3.0, -2.0, 0.5]], np.float32)


def told(elapsed, stance=0, joints=JOINTS, rates=RATES, speed=1.0, pitch_rate=0.4):
    clock = StepClock(
        stance=jnp.int32(stance), elapsed=f(elapsed), length=f(0.8), duration=f(0.2), toe_off=f(90.0),
        toe_off_seconds=f(0.05),
    )  # fmt: skip
    seen = sensors.Estimate(
        speed=f(speed), acceleration=f(0.0), pitch=f(0.03), pitch_rate=f(pitch_rate),
        joints=jnp.asarray(joints), joint_rates=jnp.asarray(rates), touch=jnp.array([700.0, 0.0]),
    )  # fmt: skip
    return np.asarray(controllers.command(NUMBERS, BONES, clock, seen)).reshape(2, 3)


# Hip speed 1 - 0.32452 x 0.4 = 0.87019 m/s; thigh 0.1 - 0.03 = 0.07 rad from the vertical;
# a' = 0.87019 / (0.954 cos 0.07) = 0.91439 rad/s; w = -a' 0.03 / 0.02.
STANCE_HIP = -1.37159
# asin(0.4 / 0.954) + 0.5 x 0.03
TARGET = 0.43266 + 0.015


def test_stance_commands():
    for elapsed in (0.01, 0.1, 0.3):
        np.testing.assert_allclose(told(elapsed)[0], [STANCE_HIP, 0.0, 0.0], atol=1e-4)


def test_toe_off_commands():
    # Hip and knee held still, the ankle pushes: plantarflexion is negative.
    np.testing.assert_allclose(told(0.02)[1], [0.0, 0.0, -90.0])


def test_a_foot_that_has_left_the_floor_pushes_no_further():
    joints = JOINTS.copy()
    joints[1, 2] = -0.49
    assert told(0.02, joints=joints)[1, 2] == -90.0
    # Beyond 0.5 rad of plantarflexion nothing resists any more; the servo brings the sole back to level:
    # 77 (0.48 + 0.51) - 0.5 = 75.73 N m.
    joints[1, 2] = -0.51
    np.testing.assert_allclose(told(0.02, joints=joints)[1, 2], 75.73, atol=1e-3)


def test_early_swing_commands():
    # 0.05 s into early swing, 0.15 s are left; knee bent; ankle 77 (0.25 - 0.2) - 0.5 = 3.35 N m.
    np.testing.assert_allclose(told(0.10)[1], [(TARGET - 0.15) / 0.15, 1.2, 3.35], atol=1e-4)
    # 0.13 s into it, 65 % of 0.2 s: past the share of 60 %, the knee straightens already.
    np.testing.assert_allclose(told(0.18)[1], [(TARGET - 0.15) / 0.07, 0.0, 3.35], atol=1e-3)


def test_terminal_swing_commands():
    # The shank hangs at 0.15 - 0.03 - 0.6 = -0.48 rad; a level sole takes +0.48 rad at the ankle:
    # 77 (0.48 - 0.2) - 0.5 = 21.06 N m.
    np.testing.assert_allclose(told(0.30)[1], [5 * (TARGET - 0.15), 0.0, 21.06], atol=1e-3)


@pytest.mark.parametrize("elapsed", [0.02, 0.10, 0.18, 0.30])
def test_left_and_right_are_mirror_images(elapsed):
    mirrored = told(elapsed, stance=1, joints=JOINTS[::-1], rates=RATES[::-1])
    np.testing.assert_array_equal(mirrored[::-1], told(elapsed))


@pytest.mark.parametrize("form", ["linear", "paper", "one-leg"])
def test_similar_bodies_are_told_similar_things(form):
    """Lengths by h, times by sqrt h, torques by m h: the commands of the tall are those of the small."""
    numbers = dataclasses.replace(NUMBERS, toe_off_form=form)

    def commands(height_ratio, mass_ratio, elapsed):
        ratio = Similarity(f(height_ratio), f(mass_ratio))
        # The desired speed is the user's and is not scaled by itself.
        own = scaling.scaled(dataclasses.replace(numbers, speed_desired=1.0 * ratio.speed), ratio)
        bones = kinematics.skeleton(anthropometry.build(BodyConfig()), ratio.length)
        inertias = controllers.Inertias(
            torso=12.0 * ratio.inertia, leg_mass=6.0 * ratio.mass, damping=1.0 * ratio.rotational_damping
        )
        torque = controllers.toe_off_torque(
            own, inertias, bones.leg, 0.9 * ratio.speed, f(-0.3), f(0.3), f(0.1)
        )
        torque, seconds = controllers.push_off(own, 60.0 * ratio.torque, torque)
        clock = StepClock(
            stance=jnp.int32(0), elapsed=elapsed * ratio.time, length=0.8 * ratio.length,
            duration=0.2 * ratio.time, toe_off=torque, toe_off_seconds=seconds,
        )  # fmt: skip
        seen = sensors.Estimate(
            speed=0.9 * ratio.speed, acceleration=f(0.3), pitch=f(0.03), pitch_rate=0.4 * ratio.rate,
            joints=jnp.asarray(JOINTS), joint_rates=RATES * ratio.rate, touch=jnp.zeros(2),
        )  # fmt: skip
        hip, knee, ankle = controllers.command(own, bones, clock, seen).reshape(2, 3).T
        return np.array([hip / ratio.rate, knee, ankle / ratio.torque])

    for elapsed in (0.02, 0.12, 0.2, 0.4):
        expected = commands(1.0, 1.0, elapsed)
        np.testing.assert_allclose(commands(1.3, 2.0, elapsed), expected, rtol=1e-5, atol=1e-5)
        assert np.abs(expected).max() > 0.1


def test_commands_are_the_same_in_a_batch():
    elapsed = jnp.array([0.02, 0.10, 0.18, 0.30])
    clock = jax.vmap(lambda t: StepClock(jnp.int32(0), t, f(0.8), f(0.2), f(90.0), f(0.05)))(elapsed)
    seen = sensors.Estimate(
        speed=f(1.0), acceleration=f(0.0), pitch=f(0.03), pitch_rate=f(0.4), joints=jnp.asarray(JOINTS),
        joint_rates=jnp.asarray(RATES), touch=jnp.array([700.0, 0.0]),
    )  # fmt: skip
    batch = jax.vmap(lambda c: controllers.command(NUMBERS, BONES, c, seen))(clock)
    for row, t in enumerate(elapsed):
        np.testing.assert_allclose(batch[row].reshape(2, 3), told(float(t)), rtol=1e-6)
