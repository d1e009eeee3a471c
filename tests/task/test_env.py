"""The Brax environment: its contract, Brax's own wrappers, and the same transitions as the windows."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from brax import envs

from jaxwalk.common.errors import UserError
from jaxwalk.config import PushConfig, TrainConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.task import collect, footstep, stepper
from jaxwalk.task.env import FootstepEnv

BATCH = 4
FOOTSTEPS = 6
EPISODE = 2  # footsteps, in Brax's wrapper
CONFIG = replace(
    PRESETS["rigid"],
    pushes=PushConfig(rate=0.0),
    train=TrainConfig(walkers=BATCH, episode_seconds=2.0, height_spread=0.1, mass_spread=0.1),
    observation=("speed", "pitch", "zmp", "step_length"),
)
KEYS = jax.random.split(jax.random.PRNGKey(3), BATCH)  # raw, as Brax's trainers make them


class Counted:
    """A jitted function that counts how often it was traced."""

    def __init__(self, function):
        self.traces = 0

        def traced(*args):
            self.traces += 1
            return function(*args)

        self._jitted = jax.jit(traced)

    def __call__(self, *args):
        return self._jitted(*args)


@pytest.fixture(scope="module")
def env():
    return envs.get_environment("jaxwalk_footstep", config=CONFIG)


def test_brax_s_callers_are_told_what_there_is():
    env = envs.get_environment("jaxwalk_footstep", config=CONFIG, backend="mjx")
    assert isinstance(env, FootstepEnv)
    assert (env.backend, env.dt) == ("mjx", CONFIG.gait.duration_nominal)
    assert FootstepEnv().dt == pytest.approx(0.1)  # asked every 100 ms
    with pytest.raises(UserError, match="backend 'spring': give mjx"):
        envs.get_environment("jaxwalk_footstep", backend="spring")
    assert not hasattr(env, "sys")
    randomised = envs.training.wrap
    with pytest.raises(AttributeError, match=r"no randomization_fn: give config\.train"):
        randomised(env, randomization_fn=lambda sys: (sys, sys))


@pytest.fixture(scope="module")
def start(env):
    return jax.jit(jax.vmap(env.reset))(KEYS)


@pytest.fixture(scope="module")
def step(env):
    return Counted(jax.vmap(env.step))


@pytest.fixture(scope="module")
def actions(start):
    """[FOOTSTEPS, BATCH, 2], near the nominal step."""
    nominal = np.asarray(jax.vmap(footstep.nominal_action)(start.pipeline_state.walker.person))
    table = nominal + np.random.default_rng(0).uniform(-0.05, 0.05, (FOOTSTEPS, BATCH, 2))
    return jnp.asarray(table, jnp.float32)


@pytest.fixture(scope="module")
def walk(start, step, actions):
    """The states after each footstep; the last walker is struck down in its second or third."""
    states = [start, _struck(step(start, actions[0]))]
    for action in actions[1:]:
        states.append(step(states[-1], action))
    return states


def _struck(state):
    """With 300 N s within 0.1 s, 0.8 s after its start, on the last walker."""
    walker = state.pipeline_state.walker
    last = jnp.arange(BATCH) == BATCH - 1
    push = walker.push.replace(
        start=jnp.where(last, 400, walker.push.start), force=jnp.where(last, 3e3, walker.push.force)
    )
    return state.replace(pipeline_state=state.pipeline_state.replace(walker=walker.replace(push=push)))


@pytest.fixture(scope="module")
def wrapped(env):
    return envs.training.wrap(env, episode_length=EPISODE)


@pytest.fixture(scope="module")
def wrapped_step(wrapped):
    return Counted(wrapped.step)


@pytest.fixture(scope="module")
def wrapped_start(wrapped):
    return jax.jit(wrapped.reset)(KEYS)


def _types(tree):
    return jax.tree.map(lambda x: (x.shape, x.dtype, x.weak_type), jax.eval_shape(lambda: tree))


def test_brax_finds_it_by_name(env):
    assert isinstance(env, FootstepEnv)
    assert env.config is CONFIG
    assert (env.observation_size, env.action_size, env.backend) == (4, 2, "mjx")


def test_reset_is_a_walker_whose_first_decision_is_due(start):
    assert start.obs.shape == (BATCH, 4) and bool(jnp.isfinite(start.obs).all())
    assert start.pipeline_state.asked.all() and not start.done.any()
    assert len(set(start.pipeline_state.walker.person.ratio.mass.tolist())) == BATCH, "all of one mass"


def test_a_key_and_its_raw_numbers_are_the_same_walker(env, start):
    typed = jax.jit(jax.vmap(env.reset))(jax.random.wrap_key_data(KEYS))
    np.testing.assert_array_equal(typed.obs, start.obs)


def test_steps_keep_the_types_of_reset_and_are_traced_once(walk, step):
    assert step.traces == 1
    assert _types(walk[-1]) == _types(walk[0])


def test_a_fall_ends_the_episode_and_costs_its_price_once(walk):
    done = np.stack([state.done for state in walk])
    assert done.shape == (FOOTSTEPS + 1, BATCH) and set(done.ravel()) == {0.0, 1.0}
    assert not done[1].any() and done[-1, -1] == 1, "the walker that was struck down stands"
    for w in np.flatnonzero(done.any(0)):
        first = int(done[:, w].argmax())
        assert walk[first].reward[w] == CONFIG.reward.fall and walk[first].metrics["fell"][w] == 1
        for later in walk[first + 1 :]:
            assert later.done[w] == 1 and later.reward[w] == 0
            np.testing.assert_array_equal(later.obs[w], walk[first].obs[w])


def test_time_that_is_over_is_truncation_and_no_end(walk):
    seconds = np.stack([s.pipeline_state.walker.tick for s in walk]) * CONFIG.physics.timestep
    late = (seconds >= CONFIG.train.episode_seconds) & (np.stack([s.done for s in walk]) == 0)
    assert late.any(), "no walker came so far"
    np.testing.assert_array_equal(np.stack([state.info["truncation"] for state in walk]), late)


def test_transitions_are_those_of_the_windowed_collection(walk, actions):
    """Footstep by footstep; two programs of one tick differ by rounding, which landings enlarge."""
    task = stepper.Task.of(CONFIG)
    window = jax.jit(
        lambda s, a, k: collect.window(CONFIG, task, s, lambda *_: a, jax.random.split(k, BATCH))
    )
    # The environment draws noise and push anew as an episode begins: start from what it drew.
    first, second = walk[0].pipeline_state, walk[1].pipeline_state.walker
    states = first.replace(walker=first.walker.replace(key=second.key, push=second.push))
    answered, ended = np.zeros(BATCH, int), np.zeros(BATCH, bool)
    collected = [[] for _ in range(BATCH)]
    for turn in range(200):
        if (ended | (answered >= FOOTSTEPS)).all():
            break
        action = actions[np.minimum(answered, FOOTSTEPS - 1), np.arange(BATCH)]
        answered += np.asarray(states.asked)
        states, brought = window(states, action, jax.random.key(turn))
        for w in np.flatnonzero(np.asarray(brought.footsteps.closed) & ~ended):
            collected[w].append(jax.tree.map(lambda x, w=w: np.asarray(x[w]), brought.footsteps.transition))
        ended |= np.asarray(brought.fell | brought.truncated)

    assert ended.all(), "each ends: by time, or by its fall"
    for w, transitions in enumerate(collected):
        assert len(transitions) >= 2
        for i, there in enumerate(transitions):
            before, after = walk[i], walk[i + 1]
            where = f"walker {w}, footstep {i}"
            np.testing.assert_allclose(there.observation, before.obs[w], atol=2e-3, err_msg=where)
            np.testing.assert_array_equal(there.action, np.clip(actions[i, w], -1, 1), err_msg=where)
            np.testing.assert_allclose(there.reward, after.reward[w], atol=2e-3, err_msg=where)
            assert there.discount == np.float32(CONFIG.ddpg.gamma * (1 - after.done[w])), where
            np.testing.assert_allclose(there.next_observation, after.obs[w], atol=2e-3, err_msg=where)
    assert collected[-1][-1].discount == 0


def test_what_is_not_finite_ends_as_a_fall(start, step, actions):
    plant = start.pipeline_state.walker.plant
    sick = plant.replace(qpos=plant.qpos.at[0, 3].set(jnp.nan))
    body = start.pipeline_state.walker.replace(plant=sick)
    after = step(start.replace(pipeline_state=start.pipeline_state.replace(walker=body)), actions[0])
    assert after.done.tolist() == [1, 0, 0, 0] and after.metrics["broken"].tolist() == [1, 0, 0, 0]
    assert after.reward[0] == CONFIG.reward.fall
    for part in (after.obs, after.info["final_observation"], *after.metrics.values()):
        assert bool(jnp.isfinite(part).all())


def test_pushes_come_and_are_renewed(start):
    config = replace(CONFIG, pushes=PushConfig(rate=1e3, rest=0.0, soon=0.0, duration=0.1))
    env = FootstepEnv(config)
    state = jax.tree.map(lambda x: x[0], start)
    body = state.pipeline_state.walker
    key = jax.random.key(0)

    def renewed(tick):
        push = body.push.replace(start=jnp.int32(400), ticks=jnp.int32(50))
        moved = state.pipeline_state.replace(walker=body.replace(tick=jnp.int32(tick), push=push))
        return env._renew(moved, key).walker

    # At a phase of the step under way: no later than a step's time.
    assert 0 <= renewed(0).push.start < 300, "an episode begins with a push of its own"
    assert renewed(449).push.start == 400, "a push under way stays"
    assert 450 <= renewed(450).push.start < 750, "one that is over makes room for the next"


def test_brax_wrappers(wrapped_start, wrapped_step, actions):
    state = wrapped_start
    fresh = np.asarray(state.obs)
    for i in range(EPISODE):
        state = wrapped_step(state, actions[0])
        assert state.obs.shape == (BATCH, 4) and state.reward.shape == (BATCH,)
        assert state.done.tolist() == [float(i == EPISODE - 1)] * BATCH
    assert state.info["truncation"].tolist() == [1.0] * BATCH, "time out, not a fall"
    np.testing.assert_array_equal(state.obs, fresh)
    final = state.info["final_observation"]
    assert bool(jnp.isfinite(final).all()) and (np.abs(final - fresh) > 1e-4).any(1).all()
    assert state.info["episode_metrics"]["length"].tolist() == [EPISODE] * BATCH

    keys = state.pipeline_state.walker.key
    after = wrapped_step(state, actions[0])
    assert not after.done.any() and (after.info["steps"] == 1).all()
    assert (jax.random.key_data(after.pipeline_state.walker.key) != jax.random.key_data(keys)).any(), (
        "the second episode repeats the first one's noise"
    )
    assert wrapped_step.traces == 1
