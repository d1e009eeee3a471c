"""What a critic is told besides: the numbers, and that no policy is told them."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import Config
from jaxwalk.model import pushes
from jaxwalk.model.burdens import Burden
from jaxwalk.task import privileged, stepper
from jaxwalk.task.stepper import Task

CONFIG = Config()
TASK = Task.of(CONFIG)
DT = CONFIG.physics.timestep


def f(value):
    return jnp.float32(value)


@pytest.fixture(scope="module")
def begun():
    """A walker of 2 m and 120 kg with a pack, and its program for both tasks."""
    burden = Burden(f(20.0), f(-0.2), f(0.1), f(0.0), f(0.5), f(0.05), f(0.8), f(0.02))
    person = f(2.0), f(120.0), f(3.0)

    def both(key):
        tasks = TASK, dataclasses.replace(TASK, privileged=True)
        return [stepper.start(task, CONFIG.gait, *person, key, burden) for task in tasks]

    return jax.jit(both)(jax.random.key(0))


def test_it_is_told_of_the_body_its_burden_and_the_push(begun):
    state = begun[0].walker.replace(tick=jnp.int32(1_000))
    length, mass = 2.0 / 1.8, 120.0 / 75.0
    impulse = state.person.ratio.impulse
    push = pushes.none().replace(
        start=jnp.int32(1_250), ticks=jnp.int32(50), force=f(600.0) * impulse, height=f(0.1 * length)
    )
    told = privileged.told(TASK.setup, state.replace(push=push))
    assert told.shape == (privileged.COUNT,)
    expected = [
        length, mass / length**3, 3.0, 20.0 / mass, -4.0 / (mass * length), 0.05, 0.5, 0.8, 0.02,
        250 * DT, 600.0 * 50 * DT, 0.1,
    ]  # fmt: skip
    np.testing.assert_allclose(told, expected, rtol=1e-5)


@pytest.mark.parametrize("start, until", [(0, -1.0), (1_000, 0.0), (10**9, 2.0)])
def test_pushes_of_long_ago_or_far_ahead_are_only_told_to_be(begun, start, until):
    state = begun[0].walker.replace(tick=jnp.int32(1_000))
    told = privileged.told(TASK.setup, state.replace(push=pushes.none().replace(start=jnp.int32(start))))
    assert told[9] == pytest.approx(until)


def test_it_comes_after_all_that_a_policy_is_told(begun):
    plain, full = (np.asarray(one.observation) for one in begun)
    assert full.shape == (plain.size + privileged.COUNT,)
    np.testing.assert_array_equal(full[: plain.size], plain)


def test_who_bears_nothing_is_told_as_nothing():
    bare = jax.jit(lambda key: stepper.start(TASK, CONFIG.gait, f(1.8), f(75.0), f(1.0), key))(
        jax.random.key(0)
    )
    told = privileged.told(TASK.setup, bare.walker)
    np.testing.assert_allclose(told[:9], [1, 1, 1, 0, 0, 0, CONFIG.physics.friction, 1, 0], rtol=1e-6)
