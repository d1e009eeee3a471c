"""A push acts for its ticks, no more, and carries the impulse asked for."""

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import physics, pushes
from jaxwalk.model.mjcf import SEGMENTS, SIDES
from jaxwalk.model.push_points import PLACES


def forces(push, ticks=200, pitch=0.0):
    """[ticks, 2] force and moment on the torso."""
    return np.asarray(jax.vmap(lambda t: pushes.loads(push, t, jnp.float32(pitch))[0])(jnp.arange(ticks)))


def push(impulse=30.0, start=20, duration=0.1, timestep=0.002, height=0.0):
    return pushes.of_impulse(jnp.float32(impulse), jnp.int32(start), duration, timestep, jnp.float32(height))


def test_a_push_acts_in_its_own_ticks_only():
    told = forces(push(start=20, duration=0.1, timestep=0.002))
    assert np.flatnonzero(told[:, 0]).tolist() == list(range(20, 70))  # 0.1 s are 50 ticks
    np.testing.assert_allclose(told[20:70, 0], 300.0)  # 30 N s in 0.1 s


@pytest.mark.parametrize("duration", [0.1, 0.05, 0.0513, 0.001, 0.0])
@pytest.mark.parametrize("impulse", [30.0, -40.0])
def test_the_impulse_is_delivered_whatever_ticks_the_duration_comes_to(impulse, duration):
    told = forces(push(impulse=impulse, duration=duration, timestep=0.003))
    assert told[:, 0].sum() * 0.003 == pytest.approx(impulse, rel=1e-5)  # float32 sums
    assert (told[:, 0] != 0).sum() == max(1, round(duration / 0.003))


def test_a_push_above_the_centre_tips_forward():
    # 300 N, 0.2 m up an upright torso: 60 N m forward; on one that leans 0.5 rad, 60 cos 0.5 = 52.65.
    assert forces(push(height=0.2))[20].tolist() == pytest.approx([300.0, 60.0])
    assert forces(push(height=0.2), pitch=0.5)[20].tolist() == pytest.approx([300.0, 52.65], abs=1e-2)
    assert forces(push(impulse=-30.0, height=0.2))[20].tolist() == pytest.approx([-300.0, -60.0])
    assert forces(push(height=-0.1))[20].tolist() == pytest.approx([300.0, -30.0])
    assert forces(push(height=0.0))[20, 1] == 0.0


@pytest.mark.parametrize("stance", [0, 1])
@pytest.mark.parametrize("place", PLACES)
def test_a_push_acts_on_its_segment_alone(place, stance):
    one = push(height=0.2).replace(place=jnp.int32(PLACES.index(place)), stance=jnp.int32(stance))
    told = np.asarray(pushes.loads(one, jnp.int32(20), jnp.float32(0.0)))
    if place == "torso":
        expected = {"torso": [300.0, 60.0]}
    else:
        leg, segment = place.split("-")
        side = SIDES[stance if leg == "stance" else 1 - stance]
        expected = {f"{segment}_{side}": [300.0, 0.0]}  # at its own centre, whatever the height says
    found = {SEGMENTS[row]: told[row].tolist() for row in np.flatnonzero(told.any(1))}
    assert found == {name: pytest.approx(values) for name, values in expected.items()}


def test_a_push_settles_on_a_leg_as_it_begins_and_keeps_to_it():
    one, sides = push(start=20), []
    for tick in range(18, 24):  # the right leg is in stance at tick 20, the left one after
        one = pushes.met(one, jnp.int32(tick), jnp.int32(tick <= 20))
        sides.append(int(one.stance))
    assert sides[2:] == [1, 1, 1, 1]


# Legs hang straight below the hip: a force F at depth d bends the root's pitch axis back by F d, and
# swings the hip forward by as much; below the knee, it straightens that. Winter's thigh is 0.441 m and
# his shank 0.4428 m long at 1.8 m, the centres of mass at 0.433 of each: d = 0.19095 and 0.63273 m.
@pytest.mark.parametrize(
    ("place", "leg", "hip", "knee"),
    [
        ("stance-thigh", 0, 19.095, 0.0),
        ("stance-shank", 0, 63.273, -19.173),
        ("swing-thigh", 1, 19.095, 0.0),
        ("swing-shank", 1, 63.273, -19.173),
    ],
)
def test_a_force_on_a_hanging_leg_is_what_its_levers_make_it(place, leg, hip, knee):
    one = push(impulse=10.0).replace(place=jnp.int32(PLACES.index(place)))  # 100 N, left leg in stance
    loads = np.asarray(pushes.loads(one, jnp.int32(20), jnp.float32(0.0)))
    model = physics.compile_mujoco(BodyConfig(), PhysicsConfig())
    data, expected = mujoco.MjData(model), np.zeros(9)
    expected[[0, 2, 3 + 3 * leg, 4 + 3 * leg]] = 100.0, -hip, hip, knee
    mujoco.mj_forward(model, data)
    free = data.qfrc_smooth.copy()
    data.xfrc_applied[1:, [0, 4]] = loads
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.qfrc_smooth - free, expected, atol=2e-3)


def test_no_push_never_acts():
    nothing = pushes.none()
    for tick in (0, 1, 10**6, pushes.NEVER - 1):
        assert not pushes.active(nothing, jnp.int32(tick))
    assert pushes.active(nothing.replace(start=jnp.int32(0)), jnp.int32(0))
