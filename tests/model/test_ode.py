"""The walker in ODE: the body of the MJCF, moved as C MuJoCo moves it, on a floor that is as soft."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.control.person import Person
from jaxwalk.model import burdens, c_mujoco, engine, ode, physics, pushes
from jaxwalk.model.engine import Setup
from jaxwalk.ode import World, library

try:
    library.load()
except UserError as missing:
    pytest.skip(str(missing), allow_module_level=True)

CONFIG = Config()
FORMS = {"compliant": CONFIG, "rigid": PRESETS["rigid"]}
DT = CONFIG.physics.timestep
STILL = np.zeros((7, 2))


def compiled(config=CONFIG, timestep=DT, *sizes):
    told = dataclasses.replace(c_mujoco.converged(config.physics), timestep=timestep)
    return c_mujoco.compiled(config.body, told, *(sizes or (1.0, 1.0)))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("sizes", [(1.0, 1.0), (0.9, 0.8), (1.0, 1.0, 20.0, -0.18, 0.1, 0.5)], ids=str)
def test_in_the_air_it_accelerates_as_in_mujoco(form, sizes):
    """Masses, inertias, centres, joints, actuators and loads are MuJoCo's. A microsecond of it: what ODE's
    step is off by is of the first order."""
    model = compiled(FORMS[form], 1e-6, *sizes)
    data, world, rng = mujoco.MjData(model), World(ode.tree(model)), np.random.default_rng(0)
    for _ in range(4):
        qpos, qvel = rng.normal(0, 0.5, 9), rng.normal(0, 3, 9)
        qpos[1] = 5.0
        control, push = rng.normal(0, 30 if form == "compliant" else 0.5, 6), rng.normal(0, 100, (7, 2))
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, control
        data.xfrc_applied[1:, 0], data.xfrc_applied[1:, 4] = push.T
        mujoco.mj_step(model, data)
        _, rates, sensed = world.tick(qpos, qvel, control, push)
        expected = (data.qvel - qvel) / 1e-6
        assert (rates - qvel) / 1e-6 == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
        assert sensed == pytest.approx(data.sensordata, abs=1e-9)


def motion(world, qpos, qvel, ticks, push=STILL):
    """The motions of all bodies, tick by tick, and the touch."""
    moved, touch = [world.tree.motion(qpos, qvel)], []
    for _ in range(ticks):
        qpos, qvel, sensed = world.tick(qpos, qvel, np.zeros(6), push)
        moved.append(world.tree.motion(qpos, qvel))
        touch.append(sensed[9:])
    return moved, np.array(touch)


def test_a_push_in_flight_gives_the_momentum_that_is_asked():
    world = World(ode.tree(compiled()))
    push = STILL.copy()
    push[0], push[5, 0] = (400.0, 20.0), -50.0
    qpos, qvel = np.array([0, 5.0, 0.1, 0.4, 0.6, 0, -0.2, 0.3, 0.1]), np.full(9, 0.3)
    moved, _ = motion(world, qpos, qvel, 50, push)
    mass = world.tree.mass
    gained = mass @ (moved[-1].speed - moved[0].speed)
    assert gained == pytest.approx([35.0, -mass.sum() * 9.81 * 0.1], abs=1e-6)  # N s


def test_a_passive_walker_gains_no_energy():
    """It is thrown onto the floor and collapses; what springs of the floor hold counts as well."""
    world = World(ode.tree(compiled()))
    tree = world.tree
    qpos, qvel = np.array([0, 1.2, 0.2, 0.4, 0.6, 0, -0.2, 0.3, 0.1]), np.zeros(9)
    qvel[0], qvel[2] = 1.0, -1.0
    moved, touch = motion(world, qpos, qvel, 250)
    assert touch.max() > 500  # it lands

    def energy(one):
        kinetic = 0.5 * (tree.mass @ (one.speed**2).sum(1) + tree.inertia @ one.spin**2)
        springs = 0.5 * tree.stiffness @ np.maximum(tree.balls(one)[1], 0) ** 2
        return kinetic + 9.81 * tree.mass @ one.place[:, 1] + springs

    # A ball that was above the floor may be in it a tick later, its spring bent unpaid: no more than that.
    depths = np.array([tree.balls(one)[1] for one in moved])
    entered = (depths[:-1] <= 0) & (depths[1:] > 0)
    unpaid = (0.5 * tree.stiffness * depths[1:] ** 2 * entered).sum(1)
    told = np.array([energy(one) for one in moved])
    assert (np.diff(told) < unpaid + 0.01).all()  # J, of 990
    assert entered.any() and told[-1] < told[0] - 50


def stand(step, seconds=3.0):
    """Hip heights (m) and touch (N) of a walker that is held upright, of the last second."""
    qpos, qvel = np.zeros(9), np.zeros(9)
    qpos[1] = 0.53 * 1.8
    rows = []
    for _ in range(round(seconds / DT)):
        control = -1500.0 * qpos[3:] - 60.0 * qvel[3:]
        lean = qpos[0] - 0.02 + 0.3 * qpos[2]  # about the centre of all masses; ankles bring it over the foot
        control[[2, 5]] = -(600.0 * lean + 150.0 * qvel[0])
        qpos, qvel, touch = step(qpos, qvel, control)
        rows.append([qpos[1], touch.sum()])
    return np.array(rows)[-round(1.0 / DT) :].T


def test_who_stands_weighs_what_he_weighs_and_stands_as_deep_as_in_mujoco():
    model = compiled()
    data, world = mujoco.MjData(model), World(ode.tree(model))

    def by_mujoco(qpos, qvel, control):
        data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, control
        mujoco.mj_step(model, data)
        return data.qpos.copy(), data.qvel.copy(), data.sensordata[9:].copy()

    def by_ode(qpos, qvel, control):
        after, rates, sensed = world.tick(qpos, qvel, control, STILL)
        return after, rates, sensed[9:]

    high, touch = stand(by_ode)
    higher, felt = stand(by_mujoco)
    assert touch.mean() == pytest.approx(75.0 * 9.81, rel=2e-3)
    assert felt.mean() == pytest.approx(75.0 * 9.81, rel=2e-3)
    assert high.mean() == pytest.approx(higher.mean(), abs=2e-4)


def test_quick_steps_are_near_world_steps():
    tree = ode.tree(compiled())
    qpos, qvel = np.array([0, 0.94, 0.05, 0.1, 0.1, 0, -0.1, 0.1, 0]), np.full(9, 0.2)
    one, other = (
        World(tree, method).tick(qpos, qvel, np.full(6, 5.0), STILL)[1] for method in ("world", "quick")
    )
    assert one == pytest.approx(other, abs=0.02)
    assert (one != other).any()


def test_the_loop_calls_it_for_each_walker_of_a_batch():
    """Own sizes, own burden, float32 in and out; one that is lost stays so."""
    setup = Setup.of(CONFIG, "ode")
    heights, masses = (np.array(x, np.float32) for x in ([1.8, 1.6, 1.8], [75, 60, 75]))
    burden = burdens.Burden(*(jnp.float32([x] * 3) for x in (0.0, 0.0, 0.0, 0.0, 0.9, 0.0, 1.0, 0.0)))

    def one(height, mass, burden, plant, control, push):
        who = Person.of(CONFIG.gait, height, mass)
        return engine.move(setup, None, who.ratio, burden, plant, control, push)

    rng = np.random.default_rng(3)
    scales = (0.1, (3, 9)), (0.5, (3, 9)), (20.0, (3, 6)), (20.0, (3, 7, 2))
    moving: list[Any] = [rng.normal(0, scale, shape).astype(np.float32) for scale, shape in scales]
    qpos, qvel, control, push = moving
    qpos[:, 1] += np.float32(0.93)
    qpos[2, 4] = np.nan
    plant = physics.Plant(qpos, qvel, jnp.zeros((3, 9)))
    after, readings = jax.jit(jax.vmap(one))(heights, masses, burden, plant, control, push)
    for row, sizes in enumerate([(1.0, 1.0), (np.float32(1.6 / 1.8), np.float32(0.8))]):
        world = World(ode.tree(compiled(CONFIG, DT, *map(float, sizes))))
        told = (np.asarray(x[row], float) for x in moving)
        places, rates, sensed = world.tick(*told)
        assert np.asarray(after.qpos[row]) == pytest.approx(places, abs=1e-5)
        assert np.asarray(after.qvel[row]) == pytest.approx(rates, abs=1e-4)
        assert np.asarray(readings.touch[row]) == pytest.approx(sensed[9:], rel=1e-3, abs=0.1)
    assert np.isnan(after.qpos[2]).all() and np.isnan(readings.velocity[2]).all()


def test_pushes_land_where_the_loop_says():
    """The push of `pushes.loads`, whose pitching moment is positive forward as everywhere."""
    now = jnp.int32(0)
    told = jnp.float32(40), now, 0.1, DT, jnp.float32(0.2)
    push = np.asarray(pushes.loads(pushes.of_impulse(*told), now, jnp.float32(0)))
    world = World(ode.tree(compiled()))
    moved, _ = motion(world, np.array([0, 5.0, *[0] * 7], float), np.zeros(9), 1, push)
    assert world.tree.mass @ moved[1].speed[:, 0] == pytest.approx(400.0 * DT, rel=1e-5)
    assert moved[1].spin[0] > 0
