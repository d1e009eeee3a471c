"""Between walls too, MJX moves the walker as C MuJoCo does, and it walks there with the step of the plane."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import BodyConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import Person, model_of, skeleton
from jaxwalk.control.rigid import controllers
from jaxwalk.learn.policies import named
from jaxwalk.measure.evaluate.evaluation import evaluate
from jaxwalk.measure.protocol import PushTest
from jaxwalk.model import engine, mjcf
from jaxwalk.model.engine import Setup
from jaxwalk.task import sway

CONFIG = dataclasses.replace(PRESETS["rigid"], body=BodyConfig(model="walls"))  # the paper's is rigid
IN_C, IN_MJX = Setup.of(CONFIG, "mujoco"), Setup.of(CONFIG)
DT = CONFIG.physics.timestep
ROWS, TICKS, SETTLED, REPLAYED = 16, 2000, 500, 50
# Half are the reference body.
HEIGHT = np.where(np.arange(ROWS) < 8, 1.8, np.linspace(1.5, 2.2, ROWS)).astype(np.float32)
MASS = (75.0 * (HEIGHT / 1.8) ** 3).astype(np.float32)


@pytest.fixture(scope="module")
def walked():
    """[ROWS, TICKS] plants, commands, wall forces and falls of the nominal step in C MuJoCo; and the sway."""

    def one(key, height, mass):
        who = Person.of(CONFIG.gait, height, mass)
        model, bones = model_of(IN_C, who), skeleton(IN_C, who)

        def tick(carry, index):
            state, counted = carry
            command = controllers.command(who.gait, bones, state.gait, state.estimate)
            after, event = walker.tick(IN_C, model, state)
            counted = sway.count(counted, height, after, jnp.where(index >= SETTLED, DT, 0.0))
            return (after, counted), (after.plant, command, after.walls, event.fell)

        begun = walker.start(IN_C, who, key, jnp.float32(1)), sway.start()
        (_, counted), rows = jax.lax.scan(tick, begun, jnp.arange(TICKS))
        return *rows, counted

    keys = jax.random.split(jax.random.key(0), ROWS)
    return jax.device_get(jax.jit(jax.vmap(one))(keys, HEIGHT, MASS))


@pytest.fixture(scope="module")
def replayed(walked):
    """(C's, MJX's) plants [ROWS, REPLAYED] from points spread over the step on, and MJX's readings."""
    plants, commands, _, _, _ = walked
    rows = np.arange(ROWS)
    at = SETTLED + rows * 31  # over more than a step of about 280 ticks

    def one(height, mass, plant, commands):
        who = Person.of(CONFIG.gait, height, mass)
        model = model_of(IN_MJX, who)

        def tick(plant, command):
            command = mjcf.WALLS.control(command)
            told = engine.move(IN_MJX, model, who.ratio, None, plant, command, jnp.zeros((7, 2)))
            return told[0], told

        return jax.lax.scan(tick, plant, commands)[1]

    start = jax.tree.map(lambda x: x[rows, at], plants)
    told = np.stack([commands[row, at[row] + 1 : at[row] + 1 + REPLAYED] for row in rows])
    ours, readings = jax.device_get(jax.jit(jax.vmap(one))(HEIGHT, MASS, start, told))
    theirs = jax.tree.map(
        lambda x: np.stack([x[row, at[row] + 1 : at[row] + 1 + REPLAYED] for row in rows]), plants
    )
    walls = np.stack([walked[2][row, at[row] + 1 : at[row] + 1 + REPLAYED] for row in rows])
    return theirs, walls, ours, readings


def test_it_walks_with_the_nominal_step(walked):
    plants, _, _, fell, _ = walked
    assert not fell[:8].any()
    travelled = plants.qpos[:8, -1, 0] - plants.qpos[:8, SETTLED, 0]
    np.testing.assert_allclose(travelled / ((TICKS - 1 - SETTLED) * DT), 1.0, atol=0.1)
    # Nobody pushes the swinging foot's edge: the sole is flat when it stands, within what the trunk tilts by.
    inversion = plants.qpos[:8, SETTLED:, [mjcf.WALLS.joints.index(f"inversion_{s}") for s in mjcf.SIDES]]
    assert np.abs(inversion).max() < 0.15


def test_its_play_is_the_gap(walked):
    _, _, walls, _, counted = walked
    gap, seconds = 0.01 / 1.8 * HEIGHT, np.full(ROWS, (TICKS - SETTLED) * DT)
    # It leans on its walls, whose last 2 mm give way.
    assert (counted.play > gap - 0.002).all() and (counted.play < gap).all()
    told = sway.report(jax.tree.map(lambda x: x[:8], counted), seconds[:8], 1.8)
    assert told.gap == pytest.approx(0.01) and told.play == counted.play[:8].max()
    # Hip and shoulder, 0.5184 m apart, each have the gap on either side. The hip's ends, 0.081 m from its
    # middle, reach it at 0.143 rad, the trunk being narrower by then.
    assert 0.01 < told.roll_amplitude < 0.02 / 0.5184
    assert told.yaw_amplitude < 0.143
    late = slice(SETTLED, None)
    np.testing.assert_allclose(told.force_mean, walls[:8, late].sum(2).mean(), rtol=1e-4)
    np.testing.assert_allclose(told.force_largest, walls[:8, late].max(), rtol=1e-6)
    assert 20 < told.force_mean < 200  # 75 kg beside a foot 0.09 m aside: 66 N m, over 0.95 to 1.4 m


@pytest.mark.slow
def test_mjx_moves_it_as_c_does(replayed):
    theirs, walls, ours, readings = replayed
    # A tick: where no foot lands, float32 alone, as in the plane (test_physics.py). Where one does, three
    # iterations may stop short, and the foot (1 kg, some 0.001 kg m^2 about its long axis) shows it first.
    tick = np.abs(ours.qvel[:, 0] - theirs.qvel[:, 0]).max(1)
    assert np.quantile(tick, 0.75) < 1e-3 and tick.max() < 0.5
    # Positions enter rounded to 1e-7 m; against 1 MN/m of contact stiffness that is 0.1 N.
    np.testing.assert_allclose(readings.walls[:, 0], walls[:, 0], atol=2.0)
    assert (walls[:, 0] > 20).any()
    # A tenth of a second: the plane's bounds hold.
    off = np.abs(ours.qpos - theirs.qpos)[:, :, :3].max((1, 2))
    assert np.median(off) < 2e-5
    assert np.quantile(off, 0.8) < 2e-3
    assert off.max() < 6e-3


@pytest.mark.slow
def test_an_evaluation_tells_of_the_walls():
    test = PushTest(4, 8.0, (-20.0,), phases=2, replicas=2, engine="mujoco")
    result = evaluate(named.load("shipped-rigid", model="walls"), test)
    assert result["walking"]["survival"] == 1.0
    assert result["walking"]["speed_mean"] == pytest.approx(1.0, abs=0.1)
    assert np.mean(result["pushes"]["survival"]) == 1.0
    for told in result["walls"].values():
        assert told["gap"] - 0.002 < told["play"] < told["gap"] == pytest.approx(0.01)
        assert told["force_mean"] < told["force_largest"]
