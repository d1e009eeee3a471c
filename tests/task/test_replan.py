"""Steps that are decided anew: windowed collection against a plain loop over ticks."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import ticks

from jaxwalk.config import Config, PushConfig, TaskConfig, TrainConfig
from jaxwalk.control import posture, walker
from jaxwalk.control.compliant import stance, step_plan
from jaxwalk.control.person import skeleton
from jaxwalk.task import collect, footstep, spawn, stepper
from jaxwalk.task.stepper import Task

WALKERS, WINDOWS, AGAIN = 4, 200, 3
CONFIG = Config(
    pushes=PushConfig(rate=1.5, rest=0.0, impulse_forward=450.0, impulse_backward=450.0),
    train=TrainConfig(walkers=WALKERS, episode_seconds=1.5),
    task=TaskConfig(replan=AGAIN),
)
TASK = Task.of(CONFIG)


def answer(observation):
    """Something else in every window."""
    return 0.9 * jnp.sin(9.0 * observation[3:5])


@pytest.fixture(scope="module")
def collected():
    """[(states before, what the window brought)], for each window, on the host."""
    keys = jax.random.split(jax.random.key(5), WALKERS)
    states = jax.jit(jax.vmap(lambda key: spawn.walker(CONFIG, TASK, key)))(keys)
    window = jax.jit(
        lambda s, k: collect.window(
            CONFIG, TASK, s, lambda o, _: jax.vmap(answer)(o), jax.random.split(k, WALKERS)
        )
    )
    record = []
    for key in jax.random.split(jax.random.key(6), WINDOWS):
        after, brought = window(states, key)
        record.append((states, jax.device_get(brought)))
        states = after
    return record


@pytest.fixture(scope="module")
def plain(collected):
    """[{walker: (transition or None, fell, truncated, landed)}] of a loop that knows of windows only when
    to ask."""
    setup = TASK.setup
    tick = ticks.many(setup)
    observe = jax.jit(jax.vmap(lambda s, length: footstep.observe(TASK.observation, setup, s, length)))
    landed_length = jax.jit(jax.vmap(lambda s: walker.landed_length(setup, s)))
    reward = jax.jit(jax.vmap(lambda *told: footstep.reward(CONFIG.reward, setup, *told)))

    @jax.jit
    def answered(states, who, observation):
        actions = jax.vmap(answer)(observation)
        told = jax.vmap(lambda s, a: walker.decide(s, footstep.to_command(s.person, a)))(states, actions)
        return jax.vmap(stepper.select)(who, told, states), actions

    nominal = CONFIG.gait.duration_nominal * np.sqrt(collected[0][0].walker.person.ratio.length)
    states, found = collected[0][0].walker, []
    born = np.ones(WALKERS, bool)
    length, windows, landed = np.zeros(WALKERS, np.float32), np.zeros(WALKERS, int), np.zeros(WALKERS, bool)
    pace, seen = np.zeros(WALKERS, np.float32), np.zeros((WALKERS, len(TASK.observation)), np.float32)
    actions = np.zeros((WALKERS, 2), np.float32)
    asks = np.zeros(WALKERS, bool)
    for before, _ in collected:
        # Each window is walked from where the other's began, so that rounding does not add up; it ends there.
        # A foot that lands bounces as rounding has it; torso and hips do not.
        kept, theirs = (np.asarray(x.plant.qpos)[~born][:, [0, 1, 2, 3, 6]] for x in (states, before.walker))
        np.testing.assert_allclose(kept, theirs, atol=5e-3)
        states = before.walker
        nominal = CONFIG.gait.duration_nominal * np.sqrt(np.asarray(states.person.ratio.length))
        length = np.where(born, landed_length(states), length)
        pace = np.where(born, states.estimate.speed, pace)
        asks |= born
        now = np.asarray(observe(states, jnp.asarray(length)))
        states, told = answered(states, jnp.asarray(asks), jnp.asarray(now))
        seen, actions = np.where(asks[:, None], now, seen), np.where(asks[:, None], told, actions)
        for one in np.flatnonzero(asks):
            windows[one], landed[one] = 0, False
        states = states.replace(push=before.walker.push)
        fallen, ended = np.zeros(WALKERS, bool), {}
        for _ in range(setup.window_ticks):
            states, event = tick(states)
            touchdown, fell, speed, far = jax.device_get(
                (event.touchdown, event.fell, states.estimate.speed, event.step_length)
            )
            pace = np.where(fallen, pace, pace + setup.timestep / nominal * (speed - pace))
            length = np.where(touchdown & ~fallen, far, length)
            landed |= touchdown & ~fallen
            if (new := fell & ~fallen).any():
                after, rewards = _told(observe, reward, states, pace, length, event.fell)
                for one in np.flatnonzero(new):
                    ended[one] = (seen[one], actions[one], rewards[one], 0.0, after[one]), True, False, True
            fallen |= fell
        windows += 1
        asks = (landed | (windows >= AGAIN)) & ~fallen
        over = asks & (np.asarray(states.tick) >= TASK.episode_ticks)
        if asks.any():
            after, rewards = _told(observe, reward, states, pace, length, jnp.zeros(WALKERS, bool))
            share = windows * setup.window_ticks * setup.timestep / nominal
            for one in np.flatnonzero(asks):
                discount = CONFIG.ddpg.gamma ** share[one]
                told = seen[one], actions[one], rewards[one] * share[one], discount, after[one]
                ended[one] = told, False, bool(over[one]), bool(landed[one])
        born = fallen | over
        found.append(ended)
    return found


def _told(observe, reward, states, pace, length, fell):
    after = np.asarray(observe(states, jnp.asarray(length)))
    return after, np.asarray(reward(states, jnp.asarray(pace, jnp.float32), jnp.asarray(length), fell))


def test_windows_bring_the_transitions_of_a_plain_loop(collected, plain):
    counts = {"decisions": 0, "fell": 0, "truncated": 0, "within a step": 0, "landed": 0}
    names = ("observation", "action", "reward", "discount", "next_observation")
    for index, ((_, brought), expected) in enumerate(zip(collected, plain, strict=True)):
        for one in range(WALKERS):
            transition, fell, truncated, landed = expected.get(one, (None, False, False, False))
            got, where = jax.tree.map(lambda x, one=one: x[one], brought), f"walker {one}, window {index}"
            assert (bool(got.fell), bool(got.truncated)) == (fell, truncated), where
            assert bool(got.footsteps.closed) == (transition is not None), where
            assert bool(got.landed) == landed, where
            for name, value in zip(names, transition or (), strict=False):
                # Programs order float32 sums differently; landings enlarge that.
                found = getattr(got.footsteps.transition, name)
                np.testing.assert_allclose(found, value, rtol=5e-3, atol=5e-3, err_msg=f"{where}: {name}")
            counts["decisions"] += transition is not None
            counts["fell"] += fell
            counts["truncated"] += truncated
            counts["landed"] += landed
            elapsed = TASK.observation.index("elapsed")
            counts["within a step"] += transition is not None and transition[0][elapsed] > 0.1
    assert counts["decisions"] > 150 and counts["within a step"] > 80, counts
    assert counts["fell"] >= 2 and counts["truncated"] >= 2 and counts["landed"] > 20, counts


@pytest.fixture(scope="module")
def born():
    return jax.jit(lambda key: spawn.walker(CONFIG, TASK, key))(jax.random.key(0))


@pytest.fixture(scope="module")
def on():
    """Walks on for a window, of an episode without end."""
    task = TASK.endless()
    return jax.jit(lambda s: collect.run_ticks(task, s, task.setup.window_ticks))


LONG, SHORT = jnp.array([1.0, 0.0]), jnp.array([-1.0, 0.0])


def test_what_is_decided_anew_changes_the_step_under_way(born, on):
    """A walker whose answer changes between two windows of one step swings elsewhere."""
    goals = []
    for later in (LONG, SHORT):
        walked = born
        for window in range(16):
            walked = on(stepper.decide(walked, LONG if window < 6 else later))
        goals.append(float(walked.walker.gait.path.angle))
    assert goals[0] > goals[1] + 0.1


def test_what_a_policy_changes_holds_until_it_is_asked_again_and_is_bounded(born, on):
    @jax.jit
    def plan(state):
        numbers, bones, clock = state.person.gait, skeleton(TASK.setup, state.person), state.gait
        where = posture.of(bones, state.estimate)
        error = stance.capture_error(numbers, bones, clock, where)
        return step_plan.planned(numbers, clock, where, state.estimate, error)

    ratio, own = born.walker.person.ratio, CONFIG.gait.step_plan
    low, high = (
        np.array([getattr(born.walker.person.gait, f"{name}_{end}") for name in ("length", "duration")])
        for end in ("min", "max")
    )
    stances = set()
    for action, share in (([-7.0, -0.5], (-1.0, -0.5)), ([-0.2, 0.4], (-0.2, 0.4))):
        change = share * np.array([own.change_length * ratio.length, own.change_duration * ratio.time])
        born = stepper.decide(born, jnp.array(action))
        for _ in range(32):  # it asks meanwhile, and nobody answers
            born = on(born)
            found = np.stack([born.walker.gait.length, born.walker.gait.duration])
            wanted = np.clip(plan(born.walker) + change, low, high)
            np.testing.assert_allclose(found, wanted, atol=1e-4)
            stances.add(int(born.walker.gait.stance))
        assert bool(born.asked)
    assert stances == {0, 1}
