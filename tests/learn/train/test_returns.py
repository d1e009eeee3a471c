"""The critic's word beside what came: of lives whose returns are known in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config, DDPGConfig
from jaxwalk.learn.ddpg import learner, replay_buffer
from jaxwalk.learn.train import device_loop
from jaxwalk.task.transition import Transition

CONFIG = Config(ddpg=DDPGConfig(hidden=(4,)))
WALKERS, CAPACITY, GAMMA, WORD = 2, 600, 0.9, 3.0


def told(lives: int, fall: int | None = None, capacity: int = CAPACITY) -> list[float]:
    """(believed, came) of walkers that earned 1 by each of ``lives`` decisions, and fell after ``fall``."""
    place = jnp.arange(capacity, dtype=jnp.float32)
    seen = jnp.tile(place[:, None], (1, 2))
    end = place == (-1 if fall is None else fall)
    life = Transition(seen, jnp.zeros((capacity, 2)), place * 0 + 1, jnp.where(end, 0.0, GAMMA), seen + 1)
    rows = jax.tree.map(lambda x: jnp.broadcast_to(x, (WALKERS, *x.shape)), life)
    many = jnp.full(WALKERS, lives, jnp.int32)
    replay = replay_buffer.Replay(rows, many % capacity, many)
    known = learner.init(CONFIG.ddpg, jax.random.key(0), 2, (0.0, 0.0))
    output = jax.tree.map(jnp.zeros_like, known.critic["output"])
    says = {**known.critic, "output": {**output, "bias": output["bias"] + WORD}}
    nothing: Any = None
    state = device_loop.TrainState(
        steppers=nothing, replay=replay, learner=replace(known, critic=says),
        counts=nothing, course=nothing, footsteps=nothing, owed=nothing, key=nothing,
        exploration=nothing,
    )  # fmt: skip
    return np.asarray(device_loop.returns(CONFIG, devices.mesh(1))(state)).tolist()


def test_what_came_is_the_discounted_reward_and_then_the_critics_word():
    left = GAMMA**device_loop.RETURN_STEPS
    believed, came = told(CAPACITY)
    assert believed == pytest.approx(WORD)
    assert came == pytest.approx((1 - left) / (1 - GAMMA) + left * WORD, rel=1e-4)


def test_nothing_comes_after_a_fall():
    # All that is told of began before it, and ended with it: decisions 380 and 360 and so on, of 500.
    _, came = told(500, fall=399)
    ages = device_loop.RETURN_STEPS + device_loop.RETURN_SPACING * np.arange(1, device_loop.RETURNS + 1)
    begun = 500 - ages[ages <= 500]
    steps = np.minimum(np.where(begun <= 399, 400 - begun, 100), 100)
    word = np.where((begun <= 399) & (begun > 299), 0.0, WORD)
    expected = (1 - GAMMA**steps) / (1 - GAMMA) + GAMMA**steps * word
    assert came == pytest.approx(expected.mean(), rel=1e-4)


def test_without_decisions_there_is_no_number():
    assert np.isnan(told(0)).all()


def test_a_memory_of_one_decision_has_returns_of_one():
    _, came = told(1, capacity=1)
    assert came == pytest.approx(1 + GAMMA * WORD)
