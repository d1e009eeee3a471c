"""Trials: who is pushed when, by how much, and what is made of it."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common.parallel import devices
from jaxwalk.config.presets import PRESETS
from jaxwalk.control.person import Person
from jaxwalk.model import pushes
from jaxwalk.task import backend, footstep
from jaxwalk.task.scenarios import Scenario
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import BINS, PUSH_STEP, Profile, Runner, begin, survived

CONFIG = PRESETS["rigid"]
TASK = Task.of(CONFIG)
DT = CONFIG.physics.timestep
SECONDS = 7.0
STEP = 0.6  # s; what the trials are told a step lasts
PUSH_TICKS = 50


# (impulse N s, phase, push height m, key): the same walk pushed at several phases, and other walks.
CASES = [
    (0.0, 0.0, 0.0, 0),
    (12.0, 0.0, 0.0, 0),
    (12.0, 0.5, 0.0, 0),
    (-8.0, 0.25, 0.1, 0),
    (1.0, 0.0, 0.0, 1),
    (-400.0, 0.0, 0.0, 1),
    (0.0, 0.5, 0.0, 2),
    (10.0, 0.25, 0.0, 0),
]
NONE, AT_ONCE, HALF_WAY, QUARTER, TINY, HUGE, OTHER, TWICE = range(len(CASES))
AGAIN = 0.6  # s


def scenarios():
    impulse, phase, height, key = (np.array(column) for column in zip(*CASES, strict=True))
    many = len(CASES)
    return Scenario(
        height=jnp.full(many, 1.8, jnp.float32),
        mass=jnp.full(many, 75.0, jnp.float32),
        noise=jnp.full(many, 1.0, jnp.float32),
        impulse=jnp.float32(impulse),
        push_ticks=jnp.full(many, PUSH_TICKS, jnp.int32),
        push_height=jnp.float32(height),
        push_place=jnp.full(many, pushes.TORSO, jnp.int32),
        phase=jnp.float32(phase),
        again=jnp.zeros(many, jnp.int32).at[TWICE].set(round(AGAIN / DT)),
        key=jax.vmap(jax.random.key)(key),
    )


class Counted:
    """The policy: the step that is never adapted; counts how often a program was made of it."""

    def __init__(self):
        self.traces = 0

    def __call__(self, action, observation):
        self.traces += 1
        return action


def run(runner, profile):
    """The trials' ends, and the shares told on the way."""
    who = Person.of(CONFIG.gait, jnp.float32(1.8), jnp.float32(75))
    shares = []
    step = footstep.nominal_action(who)
    ended = runner.run(step, CONFIG.gait, profile, scenarios(), SECONDS, shares.append)
    return ended, shares


@pytest.fixture(scope="module", autouse=True)
def small_blocks():
    """So that few trials make several blocks."""
    with pytest.MonkeyPatch.context() as patch:
        for one in (devices, backend):
            patch.setattr(one, "BLOCK", 2)
        yield


@pytest.fixture(scope="module")
def profile():
    return Profile(jnp.full(BINS, 1.1, jnp.float32), jnp.float32(STEP))


@pytest.fixture(scope="module")
def policy():
    return Counted()


@pytest.fixture(scope="module")
def runner(policy):
    return Runner(TASK, policy, 10)


@pytest.fixture(scope="module")
def eight(runner, profile):
    return run(runner, profile)


@pytest.fixture(scope="module")
def trials(eight):
    return eight[0]


def test_progress_rises_to_one(eight):
    _, shares = eight
    assert shares == sorted(shares) and shares[-1] == 1.0 and len(shares) > 2


def test_trials_do_not_depend_on_the_batch_they_are_run_in(trials, profile):
    # Eight trials as 10, and as 6 and 6: each part is filled up with trials that nobody reads.
    six, _ = run(Runner(TASK, lambda action, observation: action, 6), profile)
    assert six.tally.seconds.shape == trials.tally.seconds.shape == (len(CASES),)
    jax.tree.map(np.testing.assert_array_equal, six, trials)


def test_the_impulse_asked_for_is_the_impulse_delivered(trials):
    asked = np.array([case[0] for case in CASES]) * np.where(np.arange(len(CASES)) == TWICE, 2, 1)
    stood = asked != -400
    np.testing.assert_allclose(trials.tally.impulse[stood], asked[stood], rtol=1e-4, atol=1e-6)
    # Whoever falls under the push gets what came before.
    assert -400 <= trials.tally.impulse[HUGE] < 0


def test_a_push_that_comes_again_does_so_once_and_both_have_to_be_survived(trials):
    push = trials.state.walker.push
    first = trials.state.walker.push.start[QUARTER]  # the same walk up to there
    assert push.start[TWICE] - first == round(AGAIN / DT)
    assert survived(trials)[TWICE]
    only_one = trials.replace(tally=trials.tally.replace(impulse=trials.tally.impulse / 2))
    assert not survived(only_one)[TWICE]


@pytest.mark.parametrize("share, goes_on", [(1.0, True), (0.51, True), (0.49, False), (-1.0, False)])
def test_who_stays_up_but_does_not_walk_on_has_not_survived(trials, share, goes_on):
    """Who rocks on the spot, or walks backward for ever."""
    asked = np.full(len(CASES), CONFIG.gait.speed_desired, np.float32)
    last = trials.state.last.replace(speed=share * asked)
    slower = trials.replace(state=trials.state.replace(last=last))
    up = ~trials.state.terminated
    np.testing.assert_array_equal(survived(slower)[up], goes_on)
    assert not survived(slower)[~up].any()


def test_a_push_begins_at_its_phase_of_the_step(trials):
    start = trials.state.walker.push.start
    mean = float(trials.tally.step_seconds[NONE] / trials.tally.steps[NONE])
    for case, phase in ((HALF_WAY, 0.5), (QUARTER, 0.25)):
        # The same walk up to the push: of a step as long as the last, which is about as long as the mean.
        assert (start[case] - start[AT_ONCE]) * DT == pytest.approx(phase * mean, rel=0.1)
    assert (start[[NONE, OTHER]] > 10**9).all()
    # That step is the PUSH_STEP-th: so many mean steps from the start, the first ones being a little uneven.
    assert start[AT_ONCE] * DT == pytest.approx(PUSH_STEP * mean, abs=0.5 * mean)


def test_pushes_act_on_the_walk(trials):
    tally = trials.tally
    assert tally.distance[AT_ONCE] != tally.distance[NONE]
    assert trials.state.terminated[HUGE] and not trials.state.terminated[[NONE, AT_ONCE, TINY, OTHER]].any()
    pushed = trials.state.walker.push.start[HUGE] * DT
    assert pushed < tally.fall_seconds[HUGE] < pushed + 2.0  # 400 N s are 5 m/s
    assert np.isinf(tally.fall_seconds[[NONE, TINY]]).all()


def test_the_tally_of_a_walk_adds_up(trials):
    tally, one = trials.tally, NONE
    # Counted from 3 s on.
    assert tally.seconds[one] == pytest.approx(SECONDS - 3.0, abs=0.01)
    speed = tally.distance[one] / tally.seconds[one]
    assert 0.8 < speed < 1.3
    # Steps tell the same speed as the clock, up to the unfinished ones at both ends.
    assert tally.step_length[one] / tally.step_seconds[one] == pytest.approx(speed, rel=0.1)
    assert tally.steps[one] * 0.3 < tally.step_seconds[one] <= tally.seconds[one] + 1.0
    assert tally.speed_count[one].sum() * DT == pytest.approx(tally.seconds[one], abs=0.01)
    assert tally.speed_sum[one].sum() / tally.speed_count[one].sum() == pytest.approx(speed, rel=0.05)
    assert 0.0 < tally.pitch_swing[one] / tally.steps[one] < 0.5


def test_recovery_is_told_of_the_pushed_only(trials, profile):
    recovery = trials.tally.recovery
    assert np.isinf(recovery[[NONE, OTHER]]).all()
    assert np.isinf(recovery[HUGE])


def test_a_walk_that_a_push_hardly_touches_is_steady_at_once(trials, runner, policy):
    """Held against its own unpushed walk (the same trials' profile), 1 N s is no disturbance."""
    tally = trials.tally
    calm = [NONE, OTHER]
    speed = tally.speed_sum[calm].sum(0) / np.maximum(tally.speed_count[calm].sum(0), 1)
    seconds = tally.step_seconds[calm].sum() / tally.steps[calm].sum()
    before = policy.traces
    told, _ = run(runner, Profile(jnp.float32(speed), jnp.float32(seconds)))
    assert policy.traces == before  # one program serves every profile
    recovery = told.tally.recovery
    # Noise, and a step that lands some ticks early, may hold it off the profile once.
    assert recovery[TINY] < 2.0
    assert recovery[TINY] <= recovery[AT_ONCE]
    assert recovery[AT_ONCE] < 3.5


def test_a_longer_push_of_the_same_impulse_is_a_weaker_one():
    one = jax.tree.map(lambda x: x[AT_ONCE], scenarios())
    long = dataclasses.replace(one, push_ticks=jnp.int32(4 * PUSH_TICKS))
    forces = [float(begin(TASK, CONFIG.gait, s).state.walker.push.force) for s in (one, long)]
    assert forces == pytest.approx([12 / 0.1, 12 / 0.4])
