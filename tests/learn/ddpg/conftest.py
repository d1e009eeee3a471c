"""What the learner's tests share: strict promotion, one small configuration, one compiled update."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import DDPGConfig
from jaxwalk.learn.ddpg import learner
from jaxwalk.task.transition import Transition

OBSERVATION, ACTION = 2, 1


@pytest.fixture(autouse=True)
def _strict():
    with jax.numpy_rank_promotion("raise"), jax.numpy_dtype_promotion("strict"):
        yield


@pytest.fixture(params=[False, True], ids=["ddpg", "td3"])
def config(request):
    return small(twin=request.param)


def small(**changes):
    base: dict[str, Any] = dict(
        hidden=(48,), actor_lr=3e-3, critic_lr=3e-3, tau=0.05, batch_size=64, weight_decay=0.0,
        critic_head_start=0, action_weight=0.0,
        target_noise=0.05,
    )  # fmt: skip
    return DDPGConfig(**(base | changes))


@pytest.fixture
def transitions():
    """Makes n random transitions."""

    def make(n, seed=0):
        rng = np.random.default_rng(seed)
        arrays = Transition(
            observation=rng.normal(size=(n, OBSERVATION)),
            action=rng.uniform(-1, 1, size=(n, ACTION)),
            reward=rng.normal(size=n),
            discount=np.full(n, 0.9),
            next_observation=rng.normal(size=(n, OBSERVATION)),
        )
        return jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), arrays)

    return make


_init = jax.jit(learner.init, static_argnums=(0, 2, 3))


@pytest.fixture
def state(config):
    return _init(config, jax.random.key(0), OBSERVATION, (0.25,))


class CountingUpdate:
    """``learner.update``, compiled; ``traces`` counts how often it had to be traced."""

    def __init__(self):
        self.traces = 0
        self._update = jax.jit(self._counted, static_argnums=0)

    def _counted(self, config, state, batch, key):
        self.traces += 1
        return learner.update(config, state, batch, jax.random.split(key, config.batch_size))

    def __call__(self, config, state, batch, key=None):
        return self._update(config, state, batch, jax.random.key(1) if key is None else key)


_UPDATE = CountingUpdate()


@pytest.fixture
def update():
    return _UPDATE
