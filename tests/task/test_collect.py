"""Windowed collection gives the transitions of a plain loop that decides at the very touch-down."""

import dataclasses
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import ticks

from jaxwalk.common.errors import UserError
from jaxwalk.config import PushConfig, TrainConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import Person
from jaxwalk.task import collect, footstep, spawn, stepper
from jaxwalk.task.stepper import Task

WALKERS, WINDOWS = 8, 130
CONFIG = dataclasses.replace(
    PRESETS["rigid"],  # one decision a step; steps decided anew have tests of their own
    # Hard pushes and short lives, so that both ends of an episode occur often.
    pushes=PushConfig(rate=1.5, rest=0.0, soon=0.0, impulse_forward=140.0, impulse_backward=140.0),
    train=TrainConfig(
        walkers=WALKERS, window_ticks=8, episode_seconds=1.3, height_spread=0.1, mass_spread=0.1
    ),
    observation=("speed", "pitch", "zmp", "step_length"),
)
TASK = Task.of(CONFIG)
USUAL = np.array([1.1, 0.08, 0.2, 0.6], np.float32)
GAIN = np.array([[0.4, 1.0, 0.3, -0.3], [-0.2, 0.5, 0.1, 0.2]], np.float32)


def policy(observation):
    """[..., O] -> [..., 2]: a step near the nominal one, that depends on everything observed."""
    nominal = footstep.nominal_action(Person.of(CONFIG.gait, jnp.float32(1.8), jnp.float32(75)))
    return jnp.clip(nominal + (observation - USUAL) @ GAIN.T, -1.0, 1.0)


@pytest.fixture(scope="module")
def window():
    """One window of all walkers, compiled once; counts its traces."""
    traces = []

    def one(states, key):
        traces.append(1)
        keys = jax.random.split(key, WALKERS)
        return collect.window(CONFIG, TASK, states, lambda observation, _: policy(observation), keys)

    program = jax.jit(one)

    def run(states, key):
        return program(states, key)

    run.traces = traces
    return run


@pytest.fixture(scope="module")
def spawned():
    keys = jax.random.split(jax.random.key(11), WALKERS)
    return jax.jit(jax.vmap(lambda key: spawn.walker(CONFIG, TASK, key)))(keys)


@pytest.fixture(scope="module")
def collected(window, spawned):
    """[(states before, what the window brought)], for each window."""
    states, record = spawned, []
    for key in jax.random.split(jax.random.key(17), WINDOWS):
        after, brought = window(states, key)
        record.append((states, jax.device_get(brought)))
        states = after
    return record


def row(tree, index):
    return jax.tree.map(lambda x: x[index], tree)


@dataclasses.dataclass
class Life:
    """What the plain loop remembers of one walker."""

    alive: bool = False
    speeds: list = dataclasses.field(default_factory=list)
    observation: np.ndarray | None = None
    action: np.ndarray | None = None
    landed_in: int = -1  # the window of its last touch-down


@pytest.fixture(scope="module")
def plain(collected):
    """The reference: a Python loop over ticks, where each touch-down is answered at its own tick.

    It is given what chance brought to the walkers of `collected` (newborns, pushes), and knows of
    windows only when those came. Yields [{walker: (transition or None, fell, truncated)}], for each window.
    """
    setup, everybody = TASK.setup, range(WALKERS)

    def each(function):
        return jax.jit(jax.vmap(function))

    tick = ticks.many(setup)
    observe = each(lambda state, length: footstep.observe(TASK.observation, setup, state, length))
    landed_length = each(lambda state: walker.landed_length(setup, state))
    reward = each(lambda *told: footstep.reward(CONFIG.reward, setup, *told))

    @jax.jit
    def answered(states, who, observation):
        """``states`` with ``who`` [B] having decided, and the actions."""
        actions = policy(observation)
        decided = jax.vmap(lambda s, a: walker.decide(s, footstep.to_command(s.person, a)))(states, actions)
        return jax.vmap(stepper.select)(who, decided, states), actions

    lives, found = [Life() for _ in everybody], []
    states = collected[0][0].walker
    for index, (before, _) in enumerate(collected):
        ended = {}
        newborn = np.array([not life.alive for life in lives])
        states = jax.vmap(stepper.select)(jnp.asarray(newborn), before.walker, states)
        seen = observe(states, landed_length(states))
        states, actions = answered(states, newborn, seen)
        for one in np.flatnonzero(newborn):
            lives[one] = Life(True, [], np.asarray(seen[one]), np.asarray(actions[one]))
        states = states.replace(push=before.walker.push)
        for _ in range(CONFIG.train.window_ticks):
            states, event = tick(states)
            touchdown, fell, now, speed = jax.device_get(
                (event.touchdown, event.fell, states.tick, states.estimate.speed)
            )
            for one in everybody:
                lives[one].speeds.append(speed[one])
            done = np.array([life.alive for life in lives]) & (touchdown | fell)
            if not done.any():
                continue
            seen = observe(states, event.step_length)
            means = jnp.array([np.mean(life.speeds or [0.0]) for life in lives])
            rewards = reward(states, means, event.step_length, event.fell)
            states, actions = answered(states, jnp.asarray(done), seen)
            for one in np.flatnonzero(done):
                life, truncated = lives[one], bool(touchdown[one] and now[one] >= TASK.episode_ticks)
                transition = {
                    "observation": life.observation,
                    "action": life.action,
                    "reward": rewards[one],
                    "discount": 0.0 if fell[one] else CONFIG.ddpg.gamma,
                    "next_observation": seen[one],
                }
                if not (fell[one] and life.landed_in == index):
                    ended[one] = transition, bool(fell[one]), truncated
                else:  # fell before its window's end asked for a decision: the step before is to blame
                    ended[one] = ended[one][0] | {"reward": rewards[one], "discount": 0.0}, True, False
                alive = not (fell[one] or truncated)
                lives[one] = Life(alive, [], np.asarray(seen[one]), np.asarray(actions[one]), index)
        found.append(ended)
    return found


def test_windows_bring_the_transitions_of_a_plain_loop(collected, plain):
    counts = {"footsteps": 0, "fell": 0, "truncated": 0}
    for index, ((_, brought), expected) in enumerate(zip(collected, plain, strict=True)):
        for one in range(WALKERS):
            transition, fell, truncated = expected.get(one, (None, False, False))
            got, where = row(brought, one), f"walker {one}, window {index}"
            assert (got.fell, got.truncated) == (fell, truncated), where
            assert got.landed == got.footsteps.closed == (transition is not None), where
            for name, value in (transition or {}).items():
                # Two programs order float32 sums differently; within an episode of at most three
                # steps that grows to some 1e-4 of units of order 1.
                found = getattr(got.footsteps.transition, name)
                np.testing.assert_allclose(found, value, rtol=2e-3, atol=2e-3, err_msg=f"{where}: {name}")
            counts["footsteps"] += transition is not None
            counts["fell"] += fell
            counts["truncated"] += truncated
    # Enough of each kind was compared.
    assert counts["footsteps"] > 25 and counts["fell"] >= 3 and counts["truncated"] >= 3, counts


def test_discounts_tell_falls_from_truncations(collected):
    gathered = [got for _, got in collected]
    closed = np.stack([g.footsteps.closed for g in gathered])
    discount = np.stack([g.footsteps.transition.discount for g in gathered])
    fell, truncated = np.stack([g.fell for g in gathered]), np.stack([g.truncated for g in gathered])
    assert (closed & fell).any() and (discount[closed & fell] == 0).all()
    assert (discount[closed & ~fell] == np.float32(CONFIG.ddpg.gamma)).all()
    assert closed[truncated].all() and truncated.any()
    assert not (fell & truncated).any()


def test_a_footsteps_end_is_the_beginning_of_the_next(collected):
    chained = 0
    for one in range(WALKERS):
        last = None
        for _, brought in collected:
            got = row(brought, one)
            if got.footsteps.closed:
                if last is not None:
                    np.testing.assert_array_equal(got.footsteps.transition.observation, last)
                    chained += 1
                last = got.footsteps.transition.next_observation
            if got.fell or got.truncated:
                last = None
    assert chained > 10


def test_walkers_that_are_done_start_anew(collected):
    renewed = 0
    for (_, got), (after, _) in itertools.pairwise(collected):
        done = got.fell | got.truncated
        ticks = np.asarray(after.walker.tick)
        assert (ticks[done] == 0).all() and (ticks[~done] > 0).all()
        assert np.asarray(after.asked)[done].all()
        assert not np.asarray(after.terminated | after.truncated | after.broken).any()
        renewed += done.sum()
    assert renewed >= 6


def test_nothing_was_recompiled(collected, window):
    assert len(window.traces) == 1


def test_a_broken_walker_is_counted_and_renewed_and_harms_nobody(collected, window):
    at, sick = 20, 3  # a window before which nobody is new
    states, expected = collected[at]
    key = jax.random.split(jax.random.key(17), WINDOWS)[at]
    plant = states.walker.plant
    qvel = plant.qvel.at[sick, 5].set(jnp.nan)
    poisoned = states.replace(walker=states.walker.replace(plant=plant.replace(qvel=qvel)))
    after, got = jax.device_get(window(poisoned, key))
    assert got.broken.tolist() == [one == sick for one in range(WALKERS)]
    assert got.fell[sick] and not got.truncated[sick] and not got.footsteps.closed[sick]
    assert after.walker.tick[sick] == 0
    for leaf in jax.tree.leaves(after.replace(walker=after.walker.replace(key=None))):
        assert np.isfinite(leaf[sick]).all()
    healthy = [one for one in range(WALKERS) if one != sick]
    for with_it, without in zip(jax.tree.leaves(got), jax.tree.leaves(expected), strict=True):
        np.testing.assert_array_equal(with_it[healthy], without[healthy])


def test_a_walker_that_breaks_ends_with_finite_numbers_in_its_slot(collected, window):
    """Whoever reads the slot by mistake, behind a mask, finds no NaN to spread."""
    states, _ = collected[20]
    everybody = states.walker.plant.replace(qvel=jnp.full_like(states.walker.plant.qvel, jnp.nan))
    _, got = window(states.replace(walker=states.walker.replace(plant=everybody)), jax.random.key(0))
    assert got.broken.all()
    for leaf in jax.tree.leaves(got.footsteps):
        assert np.isfinite(leaf).all()


def test_a_stepper_that_did_not_ask_is_not_answered(spawned):
    state = row(spawned, 0)
    answered = stepper.decide(state, jnp.array([0.5, -0.5]))
    again = stepper.decide(answered, jnp.array([-1.0, 1.0]))
    assert answered.decided and not answered.asked
    np.testing.assert_array_equal(answered.action, [0.5, -0.5])
    np.testing.assert_array_equal(again.action, answered.action)
    assert again.walker.gait.length == answered.walker.gait.length


def test_too_long_windows_are_refused():
    toe_off = CONFIG.gait.toe_off_duration_min
    for spread, shortest in ((0.0, 1.0), (0.19, 0.9)):  # sqrt(1 - 0.19): times scale with sqrt(height)
        limit = int(toe_off * shortest / CONFIG.physics.timestep)
        for allowed in (limit, limit + 1):
            train = dataclasses.replace(CONFIG.train, window_ticks=allowed, height_spread=spread)
            config = dataclasses.replace(CONFIG, train=train)
            if allowed == limit:
                collect.check(config)
            else:
                with pytest.raises(UserError, match=f"train.window_ticks {allowed} .* give at most {limit}"):
                    collect.check(config)


def test_newborns_differ_within_their_ranges():
    keys = jax.random.split(jax.random.key(13), 2000)
    born = jax.jit(jax.vmap(lambda key: spawn.walker(CONFIG, TASK, key)))(keys)
    ratio, push = jax.device_get((born.walker.person.ratio, born.walker.push))

    def spans(sample, low, high):
        # 2,000 uniform draws leave less than 0.5 % of the range empty at either end (chance e^-10).
        margin = 0.005 * (high - low)
        assert low - 1e-6 <= sample.min() < low + margin
        assert high - margin < sample.max() <= high + 1e-6

    spans(ratio.length, 0.9, 1.1)
    spans(ratio.mass / ratio.length**3, 0.9, 1.1)  # at given stature
    impulse = push.force * push.ticks * CONFIG.physics.timestep
    spans(
        impulse / (ratio.mass * np.sqrt(ratio.length)),
        -CONFIG.pushes.impulse_backward,
        CONFIG.pushes.impulse_forward,
    )
    spread = CONFIG.pushes.height_spread
    spans(push.height / ratio.length, -spread, spread)
    wait = push.start * CONFIG.physics.timestep
    # Exponential waiting time: its mean of 1 / rate is known to 1 / sqrt(2,000) = 2.2 %; four of those.
    assert wait.mean() == pytest.approx(1 / CONFIG.pushes.rate, rel=0.09)
    assert np.std(wait) == pytest.approx(1 / CONFIG.pushes.rate, rel=0.15)
    assert len(np.unique(jax.random.key_data(born.walker.key), axis=0)) == 2000
    assert 0.4 < np.mean(born.walker.gait.stance) < 0.6
