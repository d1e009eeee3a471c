"""A recorded walk is the walk itself."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk.config import Config
from jaxwalk.control.person import Person, model_of
from jaxwalk.measure.gait import record
from jaxwalk.model import physics
from jaxwalk.task import footstep, rollout, stepper
from jaxwalk.task.stepper import Task

CONFIG = Config()
TASK = Task.of(CONFIG).endless()


def start():
    numbers = (jnp.float32(1.8), jnp.float32(75.0), jnp.float32(1.0))
    return stepper.start(TASK, CONFIG.gait, *numbers, jax.random.key(5))


def act(params, observation):
    return footstep.nominal_action(Person.of(CONFIG.gait, jnp.float32(1.8), jnp.float32(75.0)))


def test_a_recorded_tick_moves_the_plant_once(monkeypatch):
    moves = []

    def counted(*args):
        moves.append(1)
        return advance(*args)

    advance = physics.advance
    monkeypatch.setattr(physics, "advance", counted)
    state = start()
    jax.eval_shape(partial(record.tick, TASK), model_of(TASK.setup, state.walker.person), state)
    assert len(moves) == 1


def test_a_recorded_walk_is_the_one_that_is_not_recorded():
    windows = 50  # a second, two steps
    watch = rollout.watched(lambda _, after: (after.walker.plant.qpos, after.walker.estimate.touch))
    walked, (qpos, touch) = jax.jit(partial(rollout.segment, TASK, act, windows, watch, None))(start())
    told, ticks = jax.jit(partial(rollout.segment, TASK, act, windows, record.tick, None))(start())

    # Programs that hand on other numbers are fused, and round, otherwise.
    for a, b in zip(*map(plain, (walked, told)), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-3 * max(1.0, np.abs(b).max()))
    # What is written down is of each tick's start.
    np.testing.assert_allclose(ticks.joints[1:].reshape(-1, 6), qpos[:-1, 3:], atol=1e-3)
    np.testing.assert_allclose(ticks.pitch[1:], qpos[:-1, 2], atol=1e-3)
    # Both soles bore weight; the touch sensors, noise aside, say what the forces say.
    upward = np.asarray(ticks.forces.ground)[..., 1]
    assert (upward.max(0) > 0.8 * 75 * 9.81).all()
    assert np.corrcoef(upward.ravel(), np.asarray(touch).ravel())[0, 1] > 0.99


def plain(state):
    """Its leaves as arrays, keys included."""

    def keys(x):
        return jax.random.key_data(x) if jnp.issubdtype(x.dtype, jax.dtypes.prng_key) else x

    return jax.tree.leaves(jax.tree.map(keys, state))
