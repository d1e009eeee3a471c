"""A push acts for its ticks, no more, and carries the impulse asked for."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import pushes


def forces(push, ticks=200, pitch=0.0):
    """[ticks, 2] force and moment."""
    return np.asarray(jax.vmap(lambda t: pushes.wrench(push, t, jnp.float32(pitch)))(jnp.arange(ticks)))


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


def test_no_push_never_acts():
    nothing = pushes.none()
    for tick in (0, 1, 10**6, pushes.NEVER - 1):
        assert not pushes.active(nothing, jnp.int32(tick))
    assert pushes.active(nothing.replace(start=jnp.int32(0)), jnp.int32(0))
