"""MJX moves the walker as C MuJoCo does, whoever walks and whoever pushes.

C MuJoCo is the reference: a model compiled afresh for each body, doubles, 100 solver
iterations. MJX runs the package's defaults: one program for all bodies, floats, few iterations.
"""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest
from mujoco import mjx

from jaxwalk.config import BodyConfig, Config, Engine
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import Person, model_of
from jaxwalk.model import c_mujoco, engine, mjcf, physics, pushes
from jaxwalk.model.engine import Setup
from jaxwalk.model.push_points import PLACES
from jaxwalk.model.similarity import Similarity
from jaxwalk.task import footstep, rules, stepper
from jaxwalk.task.stepper import Task

CONFIG = Config()
FORMS = {"compliant": CONFIG, "rigid": PRESETS["rigid"]}
REFERENCE = {form: c_mujoco.converged(config.physics) for form, config in FORMS.items()}
DT = CONFIG.physics.timestep
ROWS, TICKS = 64, 50
# The first half is the reference body; the others differ in stature and build.
HEIGHT = np.full(ROWS, 1.8, np.float32)
MASS = np.full(ROWS, 75.0, np.float32)
HEIGHT[32:] = np.linspace(1.5, 2.2, 32)
MASS[32:] = 75 * (HEIGHT[32:] / 1.8) ** 3 * np.tile([0.85, 1.0, 1.3, 1.1], 8)
SCALE = (HEIGHT / 1.8)[:, None]


@dataclasses.dataclass
class OpenLoop:
    """[ROWS] starts, and the commands and pushes to replay from there."""

    start: physics.Plant
    commands: np.ndarray
    push: pushes.Push


def plant(*parts: Any) -> physics.Plant:
    """Of NumPy's arrays, which either engine takes."""
    return physics.Plant(*parts)


def no_push():
    return jax.tree.map(lambda x: np.full(ROWS, x), pushes.none())


def replay(config, engine_name: Engine = "mjx"):
    """Compiled once: [ROWS] bodies, starts, commands and pushes -> (plants, readings), [ROWS, TICKS]."""
    setup, traces = Setup.of(config, engine_name), []

    def one(height, mass, start, commands, push):
        traces.append(1)
        who = Person.of(config.gait, height, mass)
        model = model_of(setup, who)

        def tick(plant, told):
            command, now = told
            force = pushes.loads(push, now, plant.qpos[2])
            plant, readings = engine.move(setup, model, who.ratio, None, plant, command, force)
            return plant, (plant, readings)

        return jax.lax.scan(tick, start, (commands, jnp.arange(TICKS)))[1]

    program = jax.jit(jax.vmap(one))

    def run(case: OpenLoop, height=HEIGHT, mass=MASS):
        return jax.device_get(program(height, mass, case.start, case.commands, case.push))

    run.traces = traces
    return run


@pytest.fixture(scope="module", params=FORMS)
def form(request):
    """Legs that are moved by torques, or by servos."""
    return request.param


servos_only = pytest.mark.parametrize("form", ["rigid"], indirect=True, scope="module")


@pytest.fixture(scope="module")
def open_loop(form):
    return replay(FORMS[form])


@pytest.fixture(scope="module")
def open_loop_c(form):
    return replay(FORMS[form], "mujoco")


@pytest.fixture(scope="module")
def walking(form):
    """Real walking at points spread over the step, with the commands that followed; half are pushed. By C,
    since XLA would need half a minute to compile a whole walker."""
    config = FORMS[form]
    task = Task.of(config, "mujoco")
    rule = rules.strong(rules.Replan()), rules.reference(config.gait)

    def answer(state):
        rigid = form == "rigid"
        return footstep.nominal_action(state.walker.person) if rigid else rules.act(rule, state.observation)

    def one(key, height, mass):
        state = stepper.start(task, config.gait, height, mass, jnp.float32(1), key)
        model = model_of(task.setup, state.walker.person)

        def tick(state, _):
            state = stepper.decide(state, answer(state))
            command = walker.command(task.setup, state.walker)
            after = stepper.tick(task, model, state)
            return after, (state.walker.plant, command, after.terminated)

        return jax.lax.scan(tick, state, length=600)[1]

    keys = jax.random.split(jax.random.key(0), ROWS)
    plants, commands, fell = jax.device_get(jax.jit(jax.vmap(one))(keys, HEIGHT, MASS))
    rows = np.arange(ROWS)
    at = 200 + rows % 32 * 11  # over more than a step of about 280 ticks
    up = np.array([not fell[i, : at[i] + TICKS].any() for i in rows])
    assert up[:32].all() and up[32:].sum() > 20  # far from the reference body not all need walk
    start = physics.Plant(*(getattr(plants, name)[rows, at] for name in ("qpos", "qvel", "warmstart")))
    force = np.where(rows % 2 == 0, 0.0, np.linspace(-400, 400, ROWS)).astype(np.float32)
    height = np.linspace(-0.2, 0.3, ROWS).astype(np.float32)
    place = (rows // 2 % len(PLACES)).astype(np.int32)
    push = no_push().replace(
        start=np.full(ROWS, 5),
        ticks=np.full(ROWS, 20),
        force=np.where(place == pushes.TORSO, force, force / 4),  # a leg is that much lighter
        height=height,
        place=place,
        stance=rows // 10 % 2,
    )
    return OpenLoop(start, np.stack([commands[i, at[i] : at[i] + TICKS] for i in rows]), push), up


def pushed(data: mujoco.MjData, push: pushes.Push):
    """(body, [3] world point) that one push acts on; a torso's is on its long axis."""
    place = PLACES[push.place]
    if place == "torso":
        body = data.body("torso")
        return body, data.site("imu").xpos + push.height * body.xmat.reshape(3, 3)[:, 2]
    leg, segment = place.split("-")
    side = push.stance if leg == "stance" else 1 - push.stance
    body = data.body(f"{segment}_{mjcf.SIDES[side]}")
    return body, body.xipos


def in_c(case: OpenLoop, row: int, form: str):
    """(qpos [TICKS, 9], qvel [TICKS, 9], sensors [TICKS, 11]) of one row, by C MuJoCo."""
    model = physics.compile_mujoco(BodyConfig(float(HEIGHT[row]), float(MASS[row])), REFERENCE[form])
    data = mujoco.MjData(model)
    data.qpos, data.qvel = case.start.qpos[row], case.start.qvel[row]
    push = jax.tree.map(lambda x: x[row], case.push)
    path = []
    for tick in range(TICKS):
        data.ctrl = case.commands[row, tick]
        mujoco.mj_forward(model, data)
        data.qfrc_applied = 0
        if push.start <= tick < push.start + push.ticks:
            # A force at a point, no moment of our own reckoning.
            body, point = pushed(data, push)
            force = np.array([push.force, 0.0, 0.0], np.float64)
            mujoco.mj_applyFT(model, data, force, np.zeros(3), point, body.id, data.qfrc_applied)
        mujoco.mj_step(model, data)
        path.append((data.qpos.copy(), data.qvel.copy(), data.sensordata.copy()))
    return tuple(np.array(x) for x in zip(*path, strict=True))


@pytest.fixture(scope="module")
def both(form, open_loop, walking):
    """(MJX's plants and readings, C MuJoCo's qpos, qvel and sensors) of the walking rows."""
    case, up = walking
    plants, readings = jax.tree.map(lambda x: x[up], open_loop(case))
    paths = [in_c(case, int(row), form) for row in np.flatnonzero(up)]
    return plants, readings, *(np.stack(x) for x in zip(*paths, strict=True))


def test_one_tick_of_walking_agrees_with_c(both):
    plants, readings, qpos, qvel, sensed = both
    # A landing foot's acceleration reaches 1e4 rad/s^2, whose float32 rounding (6e-8, times a
    # few hundred operations) over 2 ms is some 1e-4 rad/s.
    np.testing.assert_allclose(plants.qvel[:, 0], qvel[:, 0], atol=1e-3)
    np.testing.assert_allclose(plants.qpos[:, 0], qpos[:, 0], atol=1e-3 * DT * 2)
    # Positions enter rounded to 1e-7 m; against 1 MN/m of contact stiffness that is 0.1 N.
    np.testing.assert_allclose(readings.touch[:, 0], sensed[:, 0, 9:11], atol=2.0)
    np.testing.assert_allclose(readings.velocity[:, 0], sensed[:, 0, 0:3], atol=1e-5)
    np.testing.assert_allclose(readings.up[:, 0], sensed[:, 0, 3:6], atol=1e-6)
    np.testing.assert_allclose(readings.gyro[:, 0], sensed[:, 0, 6:9], atol=1e-5)


@pytest.mark.parametrize("rows", [slice(0, 32), slice(32, None)], ids=["reference", "other bodies"])
def test_a_tenth_of_a_second_of_walking_agrees_with_c(both, rows):
    plants, _, qpos, _, _ = both
    off = np.abs(plants.qpos[rows] - qpos[rows])[:, :, :3].max((1, 2))  # hip x, z (m) and pitch (rad)
    # Most rows differ by float32 alone (1e-7 a tick, 50 ticks). Where a foot lands or lifts, three
    # Newton iterations may stop short of the solution for a tick, and a contact may begin a tick early or
    # late: 2 ms of a foot that moves at 2 m/s, through the leg, are under 2 mm and some 2 mrad at the hip,
    # twice that where one foot lifts and the other lands within the tenth of a second.
    assert np.median(off) < 2e-5
    assert np.quantile(off, 0.8) < 2e-3
    assert off.max() < 6e-3


def test_the_engine_of_c_is_c(open_loop_c, walking, both):
    """Other bodies in one batch, pushes, saturated servos, landings: only rounding between ticks differs."""
    case, up = walking
    plants, readings = jax.tree.map(lambda x: x[up], open_loop_c(case))
    _, _, qpos, qvel, sensed = both
    # Bodies and forces reach the engine as float32 (6e-8 of 400 N or of 1 MN/m of contact times 1 m: tenths
    # of a N), which over 2 ms on a foot of 1 kg is some 1e-4 m/s; positions leave it rounded to 1e-7 m.
    np.testing.assert_allclose(plants.qvel[:, 0], qvel[:, 0], atol=3e-4)
    np.testing.assert_allclose(plants.qpos[:, 0], qpos[:, 0], atol=1e-6)
    np.testing.assert_allclose(readings.touch[:, 0], sensed[:, 0, 9:11], atol=1.0)
    np.testing.assert_allclose(readings.velocity[:, 0], sensed[:, 0, 0:3], atol=1e-5)
    np.testing.assert_allclose(readings.gyro[:, 0], sensed[:, 0, 6:9], atol=1e-5)
    # A tenth of a second: states rounded to 1e-7 fifty times, and where that makes a contact begin a tick
    # early or late, 2 ms of a foot that moves at 2 m/s, through the leg.
    off = np.abs(plants.qpos - qpos)[:, :, :3].max((1, 2))
    assert np.median(off) < 2e-6
    assert np.quantile(off, 0.9) < 2e-5
    assert off.max() < 2e-3
    # It is no other than MJX's plant: the same ticks, to the tolerance of MJX.
    np.testing.assert_allclose(plants.qvel[:, 0], both[0].qvel[:, 0], atol=1e-3)


def test_the_engine_of_c_keeps_nothing_from_one_call_to_the_next(open_loop_c, walking):
    case, row = walking[0], 50
    first, _ = open_loop_c(case)
    alike = [row] * ROWS
    alone = OpenLoop(*(jax.tree.map(lambda x: x[alike], part) for part in vars(case).values()))
    among, _ = open_loop_c(alone, HEIGHT[alike], MASS[alike])
    np.testing.assert_array_equal(among.qpos[0], first.qpos[row])
    np.testing.assert_array_equal(open_loop_c(case)[0].qpos, first.qpos)


def test_the_engine_of_c_tells_a_broken_plant_from_a_sound_one(open_loop_c, walking):
    case = walking[0]
    broken = case.start.qvel.copy()
    broken[3, 4] = np.nan
    plants, _ = open_loop_c(dataclasses.replace(case, start=case.start.replace(qvel=broken)))
    finite = np.isfinite(plants.qpos).all((1, 2))
    assert not finite[3] and np.isnan(plants.qpos[3]).all()
    assert finite[[2, 4]].all()


def test_readings_come_from_the_plant(both):
    plants, readings, _, _, _ = both
    np.testing.assert_array_equal(readings.joints.reshape(-1, TICKS, 6), plants.qpos[:, :, 3:])
    np.testing.assert_array_equal(readings.joint_rates.reshape(-1, TICKS, 6), plants.qvel[:, :, 3:])


def test_a_body_moves_the_same_whoever_else_is_in_the_batch(open_loop, walking):
    case, row = walking[0], 50
    among, _ = open_loop(case)
    alike = [row] * ROWS
    case = OpenLoop(*(jax.tree.map(lambda x: x[alike], part) for part in vars(case).values()))
    alone, _ = open_loop(case, HEIGHT[alike], MASS[alike])
    # Bit for bit: a row's arithmetic does not know of the others.
    for index in (0, row):
        np.testing.assert_array_equal(alone.qpos[index], among.qpos[row])
    assert len(open_loop.traces) == 1  # other bodies need no other program


# What MJX takes from a compiled model but does not use here, or cannot vary within a batch.
_UNUSED = {
    "site_size": "static in MJX: only says which contacts a sole feels; checked by the weight test",
    "dof_M0": "not read by MJX's step",
    "actuator_acc0": "not read by MJX's step: of muscles",
    "geom_rbound_hfield": "of height fields",
    "light_poscom0": "drawing only",
}


@pytest.mark.parametrize(("height", "mass"), [(1.4, 90.0), (2.3, 60.0), (1.8, 75.0)])
@pytest.mark.parametrize(
    "base",
    [BodyConfig(), BodyConfig(1.6, 66.0, "box"), BodyConfig(1.7, 70.0, model="walls")],
    ids=["default", "box", "walls"],
)
def test_a_scaled_model_is_the_one_compiled_for_that_body(base, height, mass):
    scaled = physics.model_of(base, CONFIG.physics, Similarity.of(height, mass))
    compiled = physics.compile_mujoco(dataclasses.replace(base, height=height, mass=mass), CONFIG.physics)
    fresh = mjx.put_model(compiled, impl="jax")
    wrong, compared = [], 0
    for field in dataclasses.fields(fresh):
        ours, theirs = getattr(scaled, field.name), getattr(fresh, field.name)
        if field.name in _UNUSED or not isinstance(theirs, np.ndarray | jax.Array) or theirs.size == 0:
            continue
        compared += 1
        # The scale of float32; zeros that MuJoCo computes are zero to 1e-9.
        if not np.allclose(ours, theirs, rtol=2e-6, atol=1e-7 * np.abs(theirs).max() + 1e-9):
            wrong.append(field.name)
    assert wrong == []
    assert compared > 100


def airborne(push: pushes.Push) -> OpenLoop:
    """All rows 3 m up in a walking pose, soles far from the floor, joints left to their servos."""
    qpos = np.tile(np.array([0, 3, 0.1, 0.4, 0.3, 0.1, -0.3, 0.1, 0.2], np.float32), (ROWS, 1))
    zeros = np.zeros((ROWS, 9), np.float32)
    return OpenLoop(plant(qpos, zeros, zeros), np.zeros((ROWS, TICKS, 6), np.float32), push)


@pytest.mark.parametrize("engine", ["mjx", "mujoco"])
def test_a_push_gives_the_body_the_impulse_asked_for(form, engine, request):
    run = request.getfixturevalue("open_loop" if engine == "mjx" else "open_loop_c")
    rows = np.arange(ROWS)
    place = rows % len(PLACES)
    impulse = np.linspace(-60, 60, ROWS).astype(np.float32)
    if form == "compliant":  # no servo holds a leg, which is that much lighter
        impulse = np.where(place == pushes.TORSO, impulse, impulse / 4)
    height = np.tile(np.array([0.0, 0.25, -0.2, 0.1], np.float32), ROWS // 4)
    begin, seconds = 5, 0.08
    push = jax.vmap(lambda i, h: pushes.of_impulse(i, jnp.int32(begin), seconds, DT, h))(impulse, height)
    push = jax.device_get(push).replace(place=place, stance=rows // len(PLACES) % 2)
    plants, _ = run(airborne(push))
    for row in range(0, ROWS, 4):
        one = jax.tree.map(lambda x, row=row: x[row], push)
        model = physics.compile_mujoco(BodyConfig(float(HEIGHT[row]), float(MASS[row])), REFERENCE[form])
        data = mujoco.MjData(model)

        def state(tick, row=row, model=model, data=data):
            data.qpos, data.qvel = plants.qpos[row, tick], plants.qvel[row, tick]
            mujoco.mj_forward(model, data)
            mujoco.mj_subtreeVel(model, data)
            return data

        force, turned = impulse[row] / seconds, 0.0
        for tick in range(begin, begin + round(seconds / DT)):
            before = state(tick - 1)
            _, point = pushed(before, one)
            turned += force * (point[2] - before.subtree_com[0][2]) * DT
        end = state(TICKS - 1)
        forward = MASS[row] * end.subtree_linvel[0][0]
        # The integrator is of first order: momentum that limbs exchange within a tick is off by
        # about tick / swing time = 0.002 / 0.2, of the share that turns, hence 1 %.
        assert forward == pytest.approx(impulse[row], rel=0.01)
        assert end.subtree_angmom[0][1] == pytest.approx(turned, rel=0.03, abs=0.05)


def test_without_a_push_nothing_pushes(open_loop):
    plants, readings = open_loop(airborne(no_push()))
    assert not readings.touch.any()
    # Free fall for 0.1 s: the hip's fall is the body's, but for what the servos shift within it.
    np.testing.assert_allclose(plants.qpos[:, -1, 1], 3 - 0.5 * 9.81 * (TICKS * DT) ** 2, atol=0.01)


@servos_only
def test_soles_carry_the_weight_of_a_body_that_stands(open_loop):
    stands = np.zeros((ROWS, 9), np.float32)
    stands[:, 1] = (0.039 + 0.246 + 0.245) * HEIGHT
    case = OpenLoop(
        plant(stands, np.zeros_like(stands), np.zeros_like(stands)),
        np.zeros((ROWS, TICKS, 6), np.float32),
        no_push(),
    )
    _, readings = open_loop(case)
    carried = readings.touch.sum(2)[:, -20:].mean(1)
    # 60 ms are ten time constants of the contact, so the settling is over; the falling-over of
    # an inverted pendulum that nobody holds has by then lifted nothing: 1 %.
    np.testing.assert_allclose(carried, MASS * 9.81, rtol=0.01)
    np.testing.assert_allclose(readings.touch[:, :, 0], readings.touch[:, :, 1], rtol=0.02, atol=1.0)


@servos_only
def test_servos_hold_what_they_are_told(open_loop):
    case = airborne(no_push())
    case.commands[:, :, 0], case.commands[:, :, 1] = -2.0, 0.5  # left hip rad/s, left knee rad
    plants, _ = open_loop(case)
    # Velocity servo: 290 N m s/rad against about 1.5 kg m^2 of leg settles in some 10 ms, position servo:
    # 100 / 1200 = 83 ms time constant from 0.3 to 0.5 rad, so exp(-100/83) of 0.2 rad is left.
    np.testing.assert_allclose(plants.qvel[:32, -1, 3], -2.0, atol=0.1)
    np.testing.assert_allclose(plants.qpos[:32, -1, 4], 0.5 - 0.2 * np.exp(-100 / 83), atol=0.02)
