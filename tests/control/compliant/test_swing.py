"""The leg in the air: its path, its knee, when it has landed."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import CompliantConfig, GaitConfig
from jaxwalk.control import posture, scaling
from jaxwalk.control.compliant import swing
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import Path, StepClock
from jaxwalk.model.kinematics import Skeleton
from jaxwalk.model.similarity import Similarity

LEGS = CompliantConfig(
    toe_off_seconds=0.1, push_off_ankle=0.3, push_off_torque=100.0, push_off_gain=0.0, swing_stiffness=200.0,
    swing_damping=10.0, swing_pitch_gain=1.0, swing_rate_max=9.0, swing_knee=1.0, swing_knee_stiffness=10.0,
    swing_knee_damping=2.0, toe_off_knee_share=0.5, landing_knee=0.2, landing_knee_stiffness=100.0,
    landing_knee_damping=5.0, landing_seconds=0.1, swing_sole=-0.1, swing_ankle_most=0.3,
    swing_ankle_stiffness=50.0, swing_ankle_damping=1.0, landing_share=0.5, passing_seconds=0.05,
    back_ahead=0.05, back_force=120.0, back_toe_off=0.0, back_knee=1.1, back_knee_stiffness=150.0,
    back_knee_damping=5.0, back_pitch_gain=0.25, landing_behind=0.05,
)  # fmt: skip
NUMBERS = GaitConfig(compliant=LEGS, touchdown_ahead=0.02, touchdown_force=20.0)
BODY = Skeleton(
    thigh=jnp.float32(0.45), shank=jnp.float32(0.45), foot=jnp.float32(0.1), torso=jnp.float32(0.3)
)
DT = 0.002


def f(value):
    return jnp.float32(value)


def clock(elapsed=0.3, length=0.6, duration=0.6, angle=0.0, rate=0.0):
    return StepClock(
        stance=jnp.int32(0), elapsed=f(elapsed), length=f(length), duration=f(duration), toe_off=f(0),
        toe_off_seconds=f(0.1), path=Path(f(angle), f(rate)), lag=f(0),
    )  # fmt: skip


def estimate(
    swinging=(0.0, 0.0, 0.0), standing=(0.0, 0.0, 0.0), rates=(0.0, 0.0, 0.0), pitch=0.0, touch=0.0, speed=1.0
):
    """The left leg stands, the right one swings."""
    return Estimate(
        speed=f(speed), acceleration=f(0), pitch=f(pitch), pitch_rate=f(0),
        joints=jnp.array([standing, swinging], jnp.float32),
        joint_rates=jnp.array([(0, 0, 0), rates], jnp.float32),
        touch=jnp.array([700.0, touch]),
    )  # fmt: skip


def followed(start, plan, numbers=NUMBERS):
    """Angles and rates of a path tick by tick from 0.1 s on; ``plan`` gives length and duration by time."""

    def tick(now, elapsed):
        length, duration = plan(elapsed)
        now = now.replace(elapsed=elapsed, length=f(length), duration=f(duration))
        seen = estimate()
        path = swing.proceed(numbers, BODY, now, posture.of(BODY, seen), seen, DT)
        return now.replace(path=path), (path.angle, path.rate)

    times = jnp.arange(0.1, 0.7, DT)
    return times, *jax.lax.scan(tick, clock(angle=start), times)[1]


def test_the_path_comes_to_rest_half_a_step_ahead_of_the_hip_when_the_steps_time_is_over():
    goal = np.arcsin(0.3 / 0.9)
    times, angle, rate = followed(-0.3, lambda t: (0.6, 0.6))
    late = np.asarray(times) > 0.6
    np.testing.assert_allclose(np.asarray(angle)[late], goal, atol=0.02)
    assert np.abs(np.asarray(rate)[late]).max() < 0.3
    # A cubic's greatest rate is 1.5 times its mean.
    assert np.max(rate) == pytest.approx(1.5 * (goal + 0.3) / 0.5, rel=0.05)


def test_a_step_that_is_changed_under_way_lands_at_its_new_place_and_time_without_a_jump():
    goal = np.arcsin(0.4 / 0.9)
    times, angle, rate = followed(
        -0.3, lambda t: (jnp.where(t < 0.25, 0.4, 0.8), jnp.where(t < 0.25, 0.7, 0.45))
    )
    at = np.searchsorted(np.asarray(times), 0.46)
    assert float(angle[at]) == pytest.approx(goal, abs=0.03)
    assert np.abs(np.diff(rate)).max() <= 400 * DT + 1e-3


def test_the_path_is_no_faster_than_the_hip_may_turn():
    slow = dataclasses.replace(NUMBERS, compliant=dataclasses.replace(LEGS, swing_rate_max=1.0))
    _, _, rate = followed(-0.3, lambda t: (0.8, 0.3), slow)
    assert np.max(np.asarray(rate)[:80]) <= 1.0 + 1e-6


def test_a_leaning_torso_is_allowed_for_less_in_a_step_back():
    seen = estimate(pitch=-0.2)
    for length, goal in ((0.6, np.arcsin(0.3 / 0.9) - 0.2), (-0.6, np.arcsin(-0.3 / 0.9) - 0.25 * 0.2)):
        told = swing.goal(NUMBERS, BODY, clock(length=length), posture.of(BODY, seen), seen)
        assert float(told) == pytest.approx(goal, abs=1e-6)


@pytest.mark.parametrize("elapsed", [0.3, 0.59])
def test_the_path_of_a_larger_body_is_the_same_on_a_slower_clock(elapsed):
    """Four times as long: times are twice, rates half; late its greatest acceleration holds."""
    size = Similarity(4.0, 10.0)
    seen, now = estimate(pitch=0.1), clock(elapsed, angle=-0.2, rate=1.0)
    path = swing.proceed(NUMBERS, BODY, now, posture.of(BODY, seen), seen, DT)
    large = jax.tree.map(lambda x: 4 * x, BODY)
    slow = now.replace(
        elapsed=2 * now.elapsed, duration=2 * now.duration, length=4 * now.length, path=Path(f(-0.2), f(0.5))
    )
    numbers = scaling.scaled(NUMBERS, size)
    like = swing.proceed(numbers, large, slow, posture.of(large, seen), seen, 2 * DT)
    np.testing.assert_allclose([like.angle, 2 * like.rate], [path.angle, path.rate], rtol=1e-5)


def test_the_path_waits_at_the_leg_that_still_pushes():
    seen = estimate(swinging=(-0.4, 0.1, 0.0), rates=(-0.5, 0.0, 0.0))
    path = swing.proceed(NUMBERS, BODY, clock(0.05), posture.of(BODY, seen), seen, DT)
    assert (float(path.angle), float(path.rate)) == pytest.approx((-0.4, -0.5))


@pytest.mark.parametrize(
    "elapsed, swinging, torques",
    [
        # Pushing: hip limp, the knee pulled to half of its flexion, the ankle's whole push.
        (0.05, (-0.4, 0.1, 0.0), (0.0, 10 * (0.5 - 0.1), -100.0)),
        # Its time is over, or the ankle is at its end, or the leg before the vertical.
        (0.3, (-0.4, 0.1, 0.0), (200 * 0.5, 10 * 0.9, 50 * 0.3)),
        (0.05, (-0.4, 0.1, -0.31), (200 * 0.5, 10 * 0.9, 50 * 0.61)),
        # The sole is laid at -0.1: shank at 0.2 - 0.1 = 0.1 rad, so the ankle at -0.2.
        (0.3, (0.2, 0.1, 0.0), (200 * -0.1, 10 * 0.9, 50 * -0.2)),
        # It straightens before the landing.
        (0.55, (0.2, 0.6, 0.0), (200 * -0.1, 100 * (0.2 - 0.6), 50 * 0.3)),
    ],
)
def test_torques_of_the_leg_in_the_air(elapsed, swinging, torques):
    seen = estimate(swinging)
    now = clock(elapsed, angle=0.1)
    told = swing.torques(NUMBERS, now, posture.of(BODY, seen), seen)
    np.testing.assert_allclose(told, torques, atol=1e-3)


@pytest.mark.parametrize("speed, pushes", [(1.1, True), (1.4, True), (1.7, False)])
def test_who_is_too_fast_to_push_swings_at_once(speed, pushes):
    """100 N m at the speed desired, 100 less for each m/s more: at 1.4 m/s 60, at 1.7 less than 0.4 of it."""
    legs = dataclasses.replace(LEGS, push_off_gain=100.0, push_off_share=1.0, toe_off_least=0.4)
    seen = estimate((-0.4, 0.1, 0.0), speed=speed)
    numbers = dataclasses.replace(NUMBERS, compliant=legs)
    assert bool(swing.toe_off(numbers, clock(0.05), posture.of(BODY, seen), seen)) == pushes


def test_a_leg_that_steps_back_lifts_its_foot_and_pushes_off_no_more():
    """The same leg as above, that would push or pass: its knee is bent by a spring of its own."""
    seen = estimate((-0.4, 0.1, 0.0))
    for elapsed in (0.05, 0.3):
        now = clock(elapsed, length=-0.5, angle=0.1)
        told = swing.torques(NUMBERS, now, posture.of(BODY, seen), seen)
        np.testing.assert_allclose(told, (200 * 0.5, 150 * (1.1 - 0.1), 50 * 0.3), atol=1e-3)
        assert not swing.toe_off(NUMBERS, now, posture.of(BODY, seen), seen)


def test_no_ankle_in_the_air_turns_beyond_its_end():
    kept = dataclasses.replace(NUMBERS, compliant=dataclasses.replace(LEGS, ankle_stop=300.0, ankle_end=0.5))
    free = dataclasses.replace(NUMBERS, compliant=dataclasses.replace(LEGS, ankle_stop=0.0))
    for angle, more in ((-0.7, 300 * 0.2), (-0.5, 0.0), (0.5, 0.0)):
        seen, now = estimate((0.1, 0.3, angle)), clock()
        with_stop, without = (swing.torques(n, now, posture.of(BODY, seen), seen) for n in (kept, free))
        np.testing.assert_allclose(with_stop - without, [0, 0, more], atol=1e-3)


AHEAD = dict(swinging=(0.3, 0.0, 0.0), standing=(-0.3, 0.0, 0.0), touch=30.0)
BEHIND = dict(swinging=(-0.3, 0.0, 0.0), standing=(0.2, 0.0, 0.0), touch=130.0)


def test_the_knee_is_kept_from_bending_forward():
    free, stopped = (
        dataclasses.replace(NUMBERS, compliant=dataclasses.replace(LEGS, knee_stop=x)) for x in (0.0, 250.0)
    )
    for elapsed, knee in ((0.3, -0.2), (0.58, -0.2), (0.3, 0.2)):
        seen, now = estimate((0.1, knee, 0.0)), clock(elapsed)
        without, with_stop = (swing.torques(n, now, posture.of(BODY, seen), seen) for n in (free, stopped))
        np.testing.assert_allclose(with_stop - without, [0, 50.0 if knee < 0 else 0, 0], atol=1e-4)


@pytest.mark.parametrize(
    "landed, now, seen",
    [
        (True, clock(0.5), AHEAD),
        (False, clock(0.2), AHEAD),  # before half of the step's time
        (False, clock(0.5), AHEAD | {"touch": 10.0}),
        (False, clock(0.5), AHEAD | {"swinging": (-0.3, 0.0, 0.0)}),  # not ahead of the other
        # The foot is 0.9 sin 0.3 = 0.266 m ahead, the capture point v / w0 = 0.319 v.
        (True, clock(0.5), AHEAD | {"speed": 0.7}),
        (False, clock(0.5), AHEAD | {"speed": 0.65}),  # from there it would fall back
        (False, clock(0.14, duration=0.15), AHEAD),  # toe-off is hardly over
        (True, clock(0.2, length=-0.4), BEHIND),
        (True, clock(0.2, length=0.1), BEHIND),  # ahead of the hip, yet behind the foot it stands on
        (False, clock(0.2, length=0.6), BEHIND),  # it was not sent there
        (False, clock(0.2, length=-0.4), BEHIND | {"touch": 100.0}),
        (True, clock(0.06, length=-0.4), BEHIND),  # it does not push off first
        (False, clock(0.04, length=-0.4), BEHIND),
        (False, clock(0.5, length=-0.8), AHEAD),  # sent behind, it scuffs the floor ahead
    ],
)
def test_a_foot_has_landed_where_it_was_sent(landed, now, seen):
    told = estimate(**seen)
    assert bool(swing.touched_down(NUMBERS, now, posture.of(BODY, told), told)) == landed
