"""The NumPy runtime: tick by tick what the JAX walker does, and without JAX."""

import dataclasses
import subprocess
import sys
from functools import partial
from typing import get_args

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import deploy
from jaxwalk.common import resources
from jaxwalk.common.errors import UserError
from jaxwalk.config import Observable
from jaxwalk.control import walker
from jaxwalk.export import c, c_runtime, manifest, tensors
from jaxwalk.learn.ddpg import networks
from jaxwalk.learn.policies import named, policy
from jaxwalk.model.physics import Readings
from jaxwalk.options import checks
from jaxwalk.task import deployed, footstep, rules, scenarios, stepper
from jaxwalk.task.deployed import Shove
from jaxwalk.task.stepper import Task

TRAINED = {name: policy.load(resources.model_path(f"{name}.safetensors")) for name in checks.TRAINED}
SHIPPED = TRAINED["shipped"]
SUBJECT, RIGID = map(named.load, checks.TRAINED)


# The accelerometer of `sensors` is made of the velocity: one without noise, so that it can be told.
def quiet(config):
    own = dict(
        velocity_std=0.0, velocity_bias=0.0, acceleration_std=0.0, acceleration_bias=0.0, pitch_bias=0.0
    )
    return dataclasses.replace(config, sensors=dataclasses.replace(config.sensors, **own))


COMPLIANT, QUIET = quiet(SUBJECT.config), quiet(RIGID.config)
# The paper's toe-off and no step back; told of everything that there is to tell.
PAPER = dataclasses.replace(
    QUIET,
    gait=dataclasses.replace(QUIET.gait, toe_off_form="paper", toe_off_latched=True, back_step=False),
    observation=get_args(Observable),
)
SMALL = dataclasses.replace(QUIET, body=dataclasses.replace(QUIET.body, height=1.45, mass=60.0))
TALL = dataclasses.replace(
    COMPLIANT,
    body=dataclasses.replace(COMPLIANT.body, height=1.95, mass=90.0),
    physics=dataclasses.replace(COMPLIANT.physics, actuators="exoskeleton"),
)
# Told the whole step in every fourth window, by an answer that hardly changes; without limits.
SELDOM = dataclasses.replace(
    COMPLIANT,
    gait=dataclasses.replace(COMPLIANT.gait, steps="told"),
    physics=dataclasses.replace(COMPLIANT.physics, actuators="unlimited"),
    task=dataclasses.replace(COMPLIANT.task, replan=4),
    observation=get_args(Observable),
)
# The same where a step is planned: what is changed of it is asked at touch-downs alone.
AT_LANDINGS = dataclasses.replace(
    COMPLIANT,
    body=dataclasses.replace(COMPLIANT.body, height=1.6, mass=80.0),
    task=dataclasses.replace(COMPLIANT.task, replan=0),
)
TICKS = 2500
# What reaches every branch of the controllers.
WALKS = {
    "unpushed": (QUIET, None),
    "from behind": (QUIET, Shove(60.0, 0.2)),
    "stepping back": (QUIET, Shove(-80.0, 0.1)),
    "standing": (QUIET, Shove(-42.0, 0.1)),
    "small": (SMALL, Shove(-40.0, 0.3)),
    "paper": (PAPER, None),
    "compliant": (COMPLIANT, Shove(60.0, 0.2)),
    "compliant, stepping back": (COMPLIANT, Shove(-60.0, 0.2)),
    "compliant, tall": (TALL, Shove(30.0, 0.1)),
    "compliant, seldom asked": (SELDOM, None),
    "changed at random": (COMPLIANT, Shove(60.0, 0.2)),
    "changed at random, stepping back": (COMPLIANT, Shove(-70.0, 0.1)),
    "changed at random, asked at landings": (AT_LANDINGS, Shove(40.0, 0.1)),
}


def _trained(name):
    """A policy told what the walk's configuration says: the shipped one, or one that answers little; or
    whatever."""
    config, random = WALKS[name][0], name.startswith("changed at random")
    for one, trained in zip((SUBJECT, RIGID), TRAINED.values(), strict=True):
        if not random and config.observation == one.config.observation:
            return trained
    return _untrained(config, random)


def _untrained(config, random=False):
    """One that answers little; or whatever."""
    size = len(config.observation)
    actor = networks.init_actor(
        config.ddpg.hidden, jax.random.key(1), size, np.asarray(rules.nominal(config)).tolist()
    )
    if random:
        kernel = 0.3 * jax.random.normal(jax.random.key(2), actor["output"]["kernel"].shape)
        actor = {**actor, "output": {**actor["output"], "kernel": kernel}}
    return policy.of_parts(
        config, actor, jnp.zeros(size), jnp.ones(size), clip=10.0,
        seed=0, command="", footsteps=0, score=None,
    )  # fmt: skip


@partial(jax.jit, static_argnums=0)
def _replayed(task, numbers, params, body, start, readings):
    """[T, 6] commands, [T] touch-downs and [T, O] observations of the JAX walker that senses ``readings``."""
    height, mass = body
    first = stepper.start(task, numbers, height, mass, jnp.float32(0), jax.random.key(0))
    state = first.replace(walker=start)
    length = walker.landed_length(task.setup, start)
    observation = footstep.observe(task.observation, task.setup, start, length)
    state = state.replace(observation=observation, last=state.last.replace(length=length))

    def tick(state, row):
        index, sensed = row
        answered = stepper.decide(state, policy.act(params, state.observation))
        # As in the windows of training, a touch-down waits for its answer. Runtimes answer it at once: the
        # same as long as the trailing leg pushes. In a planned step it may not, so there it is answered at
        # once here, too.
        waits = task.replan > 0 or numbers.steps != "planned"
        state = stepper.select((index % task.setup.window_ticks == 0) | (not waits), answered, state)
        body = state.walker
        command = walker.command(task.setup, body)
        moved = walker.advance(task.setup, body, body.plant, sensed, jnp.zeros(18))
        after = stepper.advance(task, state, *moved)
        asked = after.asked & ~state.asked
        return after, (command, moved[1].touchdown, asked, after.observation)

    return jax.lax.scan(tick, state, (jnp.arange(readings.touch.shape[0]), readings))[1]


def _readings(said):
    pitch = np.array([s.pitch for s in said], np.float32)
    zero = np.zeros_like(pitch)
    velocity = np.array([s.velocity for s in said], np.float32)
    rate = np.array([s.pitch_rate for s in said], np.float32)
    return Readings(
        velocity=jnp.stack([velocity, zero, zero], 1),
        up=jnp.stack([np.sin(pitch), zero, np.cos(pitch)], 1),
        gyro=jnp.stack([zero, rate, zero], 1),
        touch=jnp.asarray(np.array([s.touch for s in said], np.float32)),
        joints=jnp.asarray(np.array([s.joints for s in said], np.float32)),
        joint_rates=jnp.asarray(np.array([s.joint_rates for s in said], np.float32)),
    )


class Told:
    """A runtime of which is kept what it gives, all but the last: (commands [T, 6], touch-downs [T],
    observations [T, O])."""

    def __init__(self, runtime, observed):
        self._runtime, self._observed, self._rows = runtime, observed, []

    def start(self, said, stance):
        command = self._runtime.start(said, stance)
        self._rows.append((command, False, self._observed(self._runtime)))
        return command

    def tick(self, said):
        command = self._runtime.tick(said)
        self._rows.append((command, self.touchdown, self._observed(self._runtime)))
        return command

    @property
    def touchdown(self):
        return self._runtime.touchdown

    def columns(self):
        return tuple(np.array(column) for column in zip(*self._rows[:-1], strict=True))


class Recorded:
    """A walk under the NumPy runtime; what the C runtime and the JAX walker make of its sensors."""

    def __init__(self, name, folder):
        config, shove = WALKS[name]
        trained = _trained(name)
        told = manifest.build(trained, config)
        path = folder / f"{name}.npz"
        path.write_bytes(tensors.to_npz(trained, told))
        runtime = deploy.Controller.load(path)
        seconds = TICKS * config.physics.timestep
        in_numpy = Told(runtime, lambda c: c.observation)
        self.walk = deployed.walk(config, in_numpy, seconds, 3, shove, keep=True)
        size = len(config.observation)
        start = deployed.start(config, scenarios.root(3, scenarios.DEPLOYED))
        said, stance = self.walk.said, int(start.gait.stance)
        self.numpy = in_numpy.columns()

        header = folder / "policy.h"
        header.write_bytes(c.header(trained, told))
        (folder / name).mkdir()
        library = c_runtime.build(header, folder / name)
        body = config.body.height, config.body.mass, config.gait.speed_desired
        walker_in_c = c_runtime.Controller(library, *body)
        in_c = Told(walker_in_c, lambda c: c.observation(size))
        in_c.start(said[0], stance)
        for one in said[1:]:
            in_c.tick(one)
        self.c = in_c.columns()

        params = policy.without_origin(trained)
        self.actions = np.asarray(policy.act(params, jnp.asarray(self.numpy[2])))
        sizes = jnp.float32(config.body.height), jnp.float32(config.body.mass)
        replayed = _replayed(Task.of(config), config.gait, params, sizes, start, _readings(said[1:]))
        commands, landed, asked, observed = jax.device_get(replayed)
        # JAX's command is that of the tick to come, the runtimes' that of the one just made.
        self.jax = commands, np.concatenate([[False], landed[:-1]]), observed
        self.asked = np.flatnonzero(np.concatenate([[False], asked[:-1]]))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walks")
    return {name: Recorded(name, folder) for name in WALKS}


@pytest.mark.parametrize("name", WALKS)
@pytest.mark.parametrize("runtime", ["numpy", "c"])
def test_ticks_are_those_of_the_jax_walker(recorded, name, runtime):
    commands, landed, observed = getattr(recorded[name], runtime)
    jax_commands, jax_landed, jax_observed = recorded[name].jax
    assert landed.sum() > (5 if name != "compliant, seldom asked" else 1)
    np.testing.assert_array_equal(landed, jax_landed)
    # Torques of up to 216 N m, a stiffness or a damping times what float32 rounds: a ten-thousandth of that.
    atol = 0.02 if WALKS[name][0].gait.form == "compliant" else 1e-3
    np.testing.assert_allclose(commands, jax_commands, atol=atol, rtol=1e-5)
    asked = recorded[name].asked
    assert len(asked) > {0: 5, SELDOM.task.replan: 15}.get(WALKS[name][0].task.replan, 40)
    np.testing.assert_allclose(observed[asked], jax_observed[asked - 1], atol=1e-4)


def test_the_walks_reach_what_they_are_for(recorded):
    def steps(name):  # lengths of the steps told at touch-downs, m
        _, landed, observed = recorded[name].numpy
        return observed[landed][:, WALKS[name][0].observation.index("step_length")]

    assert steps("unpushed").min() > 0.2
    assert steps("stepping back").min() < -0.1
    ankle = recorded["standing"].numpy[0][:, [2, 5]]
    assert np.isclose(ankle, RIGID.config.gait.restart_torque).any(), "it never stood"
    assert not recorded["unpushed"].walk.fell and not recorded["stepping back"].walk.fell
    for name in (name for name in WALKS if "at random" in name):
        assert np.ptp(recorded[name].actions, axis=0).min() > 0.02, f"{name}: it answers the same"
        assert np.abs(recorded[name].actions).max(axis=0).min() > 0.1, f"{name}: it changes little"
    assert min(far for *_, far in recorded["changed at random, stepping back"].walk.landings) < -0.1


@pytest.fixture
def exported(tmp_path):
    path = tmp_path / "policy.safetensors"
    path.write_bytes(
        tensors.to_safetensors(TRAINED["shipped"], manifest.build(TRAINED["shipped"], SUBJECT.config))
    )
    return path


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The shipped policy's controller in C."""
    folder = tmp_path_factory.mktemp("library")
    header = folder / "policy.h"
    header.write_bytes(c.header(SHIPPED, manifest.build(SHIPPED, SUBJECT.config)))
    return c_runtime.build(header, folder)


BAD = [
    dict(height=0.2), dict(height=float("nan")), dict(mass=1000.0), dict(speed=0.0), dict(delay=0.05),
    dict(delay=float("nan")),
]  # fmt: skip


@pytest.mark.parametrize("wrong", BAD, ids=str)
def test_bad_bodies_are_refused(exported, wrong):
    with pytest.raises(UserError, match=next(iter(wrong))):
        deploy.Controller.load(exported, **wrong)


def test_c_refuses_bad_bodies_too(library):
    assert not c_runtime.Controller(library, 1.8, 75.0, 1.0).refused
    for body in ((0.2, 75.0, 1.0), (float("nan"), 75.0, 1.0), (1.8, 1000.0, 1.0), (1.8, 75.0, 0.0)):
        assert c_runtime.Controller(library, *body).refused


def test_late_instruments_are_told(tmp_path):
    """As JAX tells: on a body 1.44 times as long, times are those of the reference over 1.2."""
    config = dataclasses.replace(SUBJECT.config, observation=("speed", "delay"))
    told = manifest.build(_untrained(config), config)
    header, path = tmp_path / "policy.h", tmp_path / "policy.npz"
    header.write_bytes(c.header(_untrained(config), told))
    path.write_bytes(tensors.to_npz(_untrained(config), told))
    in_c = c_runtime.Controller(c_runtime.build(header, tmp_path), 2.592, 75.0, 1.0)
    in_numpy = deploy.Controller.load(path, height=2.592)
    # Trained with 20 ms at most.
    for late, trained in ((0.02, True), (0.024, False)):
        assert (in_c.late(late), in_numpy.late(late)) == (trained, trained)
    assert (in_c.late(0.05), in_c.late(float("nan"))) == (-1, -1)
    said = deploy.Sensors(1.0, 0.0, 0.0, 0.0, np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2))
    for runtime in (in_c, in_numpy):
        runtime.start(said, 0)
    for seen in (in_c.observation(2), in_numpy.observation):
        assert seen[1] == pytest.approx(0.02)


@pytest.mark.parametrize("speed, known", [(0.6, True), (1.4, True), (0.59, False), (1.45, False)])
def test_another_speed_may_be_asked_for_at_any_time(exported, library, speed, known):
    """Policies are trained around 1 m/s, by 0.4 m/s either way; beyond they say so, and try."""
    runtime = deploy.Controller.load(exported)
    assert runtime.ask(speed) == known
    assert runtime.person.gait.speed_desired == np.float32(speed)
    with pytest.raises(UserError, match="speed"):
        runtime.ask(5.0)
    walker = c_runtime.Controller(library, 1.8, 75.0, 1.0)
    assert (walker.ask(speed), walker.ask(float("nan"))) == (int(known), -1)


def test_a_fall_is_told(exported, library):
    body = 1.8, 75.0, 1.0
    runtimes = [deploy.Controller.load(exported, *body), c_runtime.Controller(library, *body)]
    for runtime in runtimes:
        for pitch, knee, fallen in ((0.1, 0.0, False), (1.2, 0.0, True), (-1.2, 0.0, True), (0.1, 2.2, True)):
            joints = np.tile([pitch + knee / 2, knee, knee / 2], (2, 1))
            said = deploy.Sensors(1.0, 0.0, pitch, 0.0, joints, np.zeros((2, 3)), np.zeros(2))
            runtime.start(said, 0)
            assert runtime.fallen == fallen, (pitch, knee)
        for speed, pitch in ((np.nan, 0.1), (1.0, np.nan)):  # broken instruments
            joints = np.tile([0.1, 0.0, 0.0], (2, 1))
            runtime.start(deploy.Sensors(speed, 0.0, pitch, 0.0, joints, np.zeros((2, 3)), np.zeros(2)), 0)
            assert runtime.fallen, (speed, pitch)


def test_needs_a_start(exported):
    said = deploy.Sensors(1.0, 0.0, 0.0, 0.0, np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2))
    with pytest.raises(RuntimeError, match="start"):
        deploy.Controller.load(exported).tick(said)
    with pytest.raises(UserError, match="stance"):
        deploy.Controller.load(exported).start(said, 2)


def test_without_jax_and_mujoco(exported):
    code = f"""
import sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("jax", "jaxlib", "flax", "mujoco", "safetensors"):
            raise ImportError(name)
sys.meta_path.insert(0, Blocked())
import numpy as np
from jaxwalk import deploy
c = deploy.Controller.load({str(exported)!r})
s = deploy.Sensors(1.0, 0.0, 0.05, 0.0, np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2))
c.start(s, 0)
assert c.tick(s).shape == (6,) and np.isfinite(c.tick(s)).all()
"""
    subprocess.run([sys.executable, "-c", code], check=True)
