"""Packs, steady forces and floors: what the plant feels of them, by plain mechanics and by C MuJoCo."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from jaxwalk.config.presets import PRESETS
from jaxwalk.control.person import Person, model_of
from jaxwalk.model import anthropometry, burdens, c_mujoco, engine, mjcf, physics
from jaxwalk.model.burdens import Burden
from jaxwalk.model.engine import Setup

CONFIG = PRESETS["rigid"]  # whose servos hold the legs in the air and on the floor
SETUP = Setup.of(CONFIG)
DT = CONFIG.physics.timestep
TICKS = 40
HEIGHT, MASS = 1.7, 80.0
NOTHING = Burden(0.0, 0.0, 0.0, 0.0, CONFIG.physics.friction)
FRONT = dataclasses.replace(NOTHING, mass=25.0, ahead=0.2, up=0.05)
BACK = dataclasses.replace(NOTHING, mass=10.0, ahead=-0.18, up=0.1)
PULLED = dataclasses.replace(BACK, force=-30.0)
SLIPPERY = dataclasses.replace(NOTHING, friction=0.1)
ALL = {"nothing": NOTHING, "front": FRONT, "back": BACK, "pulled": PULLED, "slippery": SLIPPERY}
# In the air, and standing on both feet with the hip moving so that soles would slide.
AIR = np.array([0, 3, 0.3, 0.4, 0.3, 0.1, -0.3, 0.1, 0.2], np.float32)
FLOOR = np.array([0, 0.53 * HEIGHT, 0.1, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0], np.float32)


@pytest.fixture(scope="module", params=["mjx", "mujoco"])
def follow(request):
    """(burdens, or None for who has none; starts) -> [N, TICKS, 9] positions, by either engine."""
    setup = dataclasses.replace(SETUP, engine=request.param)

    def one(burden, qpos, qvel):
        who = Person.of(CONFIG.gait, jnp.float32(HEIGHT), jnp.float32(MASS), burden)
        model = model_of(setup, who)
        torso = anthropometry.build(CONFIG.body).torso.mass * who.ratio.mass

        def tick(plant, _):
            push = jnp.zeros(2)
            if burden is not None:
                push = burdens.felt(burden, torso, push, plant.qpos[2])
            loads = jnp.zeros((7, 2)).at[0].set(push)  # the torso's
            plant, _ = engine.move(setup, model, who.ratio, burden, plant, jnp.zeros(6), loads)
            return plant, (plant.qpos, plant.qvel)

        return jax.lax.scan(tick, physics.Plant(qpos, qvel, jnp.zeros(9)), length=TICKS)[1]

    program = jax.jit(jax.vmap(one))

    def run(borne, qpos, qvel=None):
        starts = np.tile(qpos, (len(borne), 1))
        rates = np.zeros_like(starts) if qvel is None else np.tile(qvel, (len(borne), 1))
        each = None if borne[0] is None else jax.tree.map(lambda *x: np.array(x, np.float32), *borne)
        return jax.device_get(program(each, starts, rates))

    return run


def laden(burden: Burden | None):
    """MJX's, on the host."""
    who = Person.of(CONFIG.gait, jnp.float32(HEIGHT), jnp.float32(MASS), burden)
    return jax.device_get(model_of(SETUP, who))


def differing(one, other) -> set[str]:
    """Names of the leaves in which two models differ by a bit."""
    leaves = zip(jax.tree.leaves_with_path(one), jax.tree.leaves(other), strict=True)
    return {path[-1].name for (path, ours), theirs in leaves if not np.array_equal(ours, theirs)}


SLIDES = np.array([1.0, 0, 0, 0, 0, 0, 0, 0, 0], np.float32)


@pytest.fixture(scope="module")
def moved(follow):
    """By start and burden: (qpos, qvel), [TICKS, 9] each."""
    found = {}
    for start, qpos, qvel in (("air", AIR, 0 * SLIDES), ("floor", FLOOR, SLIDES)):
        paths = follow(list(ALL.values()), qpos, qvel)
        found |= {(start, name): tuple(x[i] for x in paths) for i, name in enumerate(ALL)}
    return found


def welded(burden: Burden) -> mujoco.MjModel:
    """The walker in C MuJoCo with a box welded to its torso."""
    config = dataclasses.replace(CONFIG.body, height=HEIGHT, mass=MASS)
    settings = dataclasses.replace(c_mujoco.converged(CONFIG.physics), friction=burden.friction)
    segments = anthropometry.build(config)
    spec = mjcf.build(segments, settings)
    if burden.mass:
        place = [burden.ahead, 0, segments.torso.com[1] + burden.up]
        spec.body("torso").add_body(name="pack", pos=place).add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.15, 0.225], mass=burden.mass,
            contype=0, conaffinity=0,
        )  # fmt: skip
    return spec.compile()


def in_c(burden: Burden, qpos, qvel):
    """[TICKS, 9] positions and rates of the welded walker, its own torso's centre being pulled."""
    model = welded(burden)
    data = mujoco.MjData(model)
    data.qpos, data.qvel = qpos, qvel
    path = []
    for _ in range(TICKS):
        mujoco.mj_forward(model, data)
        data.qfrc_applied = 0
        force, torso = np.array([burden.force, 0.0, 0.0]), model.body("torso").id
        mujoco.mj_applyFT(model, data, force, np.zeros(3), data.site("imu").xpos, torso, data.qfrc_applied)
        mujoco.mj_step(model, data)
        path.append((data.qpos.copy(), data.qvel.copy()))
    return tuple(np.array(x) for x in zip(*path, strict=True))


@pytest.mark.parametrize("name", ALL)
def test_a_burden_moves_the_walker_as_a_welded_box_does_in_c(moved, name):
    ours, rates = moved["air", name]
    theirs, speeds = in_c(ALL[name], AIR, 0 * SLIDES)
    # No contact: float32, forty times. MJX's servos are C's but for rounding (see test_physics).
    np.testing.assert_allclose(ours, theirs, atol=2e-5)
    np.testing.assert_allclose(rates, speeds, atol=2e-3)
    ours, theirs = moved["floor", name][0], in_c(ALL[name], FLOOR, SLIDES)[0]
    # With it: inverse weights of the feet differ by 0.4 % under 25 kg, and so does the contacts'
    # softness; MJX stops after three iterations.
    assert np.abs(ours - theirs)[:, :3].max() < 3e-3


def test_what_is_borne_is_felt(moved):
    """By far more than the engines differ."""
    for start, name, least in (
        ("air", "front", 1e-3), ("air", "back", 1e-3), ("air", "pulled", 1e-3), ("floor", "slippery", 1e-2),
    ):  # fmt: skip
        off = np.abs(moved[start, name][0] - moved[start, "nothing"][0])[-1, :3].max()
        assert off > least


def test_bearing_nothing_changes_no_number(follow, moved):
    bare, burdened = laden(None), laden(NOTHING)
    assert differing(bare, burdened) == set()
    push = jnp.float32([-40.0, 3.7])
    np.testing.assert_array_equal(burdens.felt(NOTHING, jnp.float32(50.0), push, jnp.float32(0.3)), push)
    # The program of walkers who bear something is another one, whose float32 sums are ordered otherwise.
    for start, qpos, qvel in (("air", AIR, 0 * SLIDES), ("floor", FLOOR, SLIDES)):
        alone = follow([None] * len(ALL), qpos, qvel)[0][0]
        np.testing.assert_allclose(moved[start, "nothing"][0], alone, atol=2e-6)


def test_a_steady_force_moves_the_body_s_centre_as_newton_says(moved):
    """A pull of 30 N on 90 kg in free fall, whatever joints do: x = F t^2 / 2 m."""
    model = welded(BACK)
    data = mujoco.MjData(model)
    centres = []
    for qpos in (AIR, moved["air", "pulled"][0][-1], moved["air", "back"][0][-1]):
        data.qpos = qpos
        mujoco.mj_forward(model, data)
        centres.append(data.subtree_com[0][0])
    start, pulled, free = centres
    # Semi-implicit Euler puts n (n + 1) / 2 in place of n^2 / 2.
    expected = PULLED.force / (MASS + BACK.mass) * DT**2 * TICKS * (TICKS + 1) / 2
    assert pulled - start == pytest.approx(expected, rel=0.02)
    assert free - start == pytest.approx(0.0, abs=0.02 * abs(expected))


@pytest.mark.parametrize("burden", [FRONT, BACK], ids=["front", "back"])
def test_a_laden_torso_is_the_torso_and_a_box(burden):
    model, pack = laden(burden), welded(burden)
    data = mujoco.MjData(pack)
    mujoco.mj_forward(pack, data)  # upright, the hip at the origin
    torso, box = pack.body("torso").id, pack.body("pack").id
    parts = [(pack.body_mass[i], data.xipos[i], pack.body_inertia[i]) for i in (torso, box)]
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * x for m, x, _ in parts) / mass
    box_rows = parts[1][2]
    # The box's own moment about y, by its sides: it is rotated into no other axes.
    spin = burden.mass * (0.45**2 + 0.2**2) / 12
    assert np.isclose(box_rows, spin, rtol=1e-6).any()
    inertia = parts[0][2][1] + spin + sum(m * ((x - centre) ** 2).sum() for m, x, _ in parts)
    np.testing.assert_allclose(model.body_mass[1], mass, rtol=1e-6)
    np.testing.assert_allclose(model.body_ipos[1], centre, atol=1e-6)
    np.testing.assert_allclose(model.body_inertia[1, 1], inertia, rtol=1e-6)
    np.testing.assert_allclose(model.body_subtreemass[:2], MASS + burden.mass, rtol=1e-6)
    assert len(model.body_mass) == pack.nbody - 1


def test_only_what_a_burden_changes_is_changed():
    bare, burdened = laden(None), laden(dataclasses.replace(FRONT, friction=0.5))
    changed = {"body_mass", "body_subtreemass", "body_ipos", "body_inertia", "pair_friction"}
    assert differing(bare, burdened) == changed


def test_gravity_pulls_a_walker_and_its_pack_down_the_slope():
    segments = anthropometry.masses(anthropometry.build(dataclasses.replace(CONFIG.body, mass=75.0)))
    for degrees, way in ((3.0, -1), (-3.0, 1), (0.0, 0)):
        borne = dataclasses.replace(FRONT, slope=np.radians(degrees))
        pulled = burdens.downhill(jnp.asarray(segments), borne)
        expected = way * 9.81 * np.sin(np.radians(3.0)) * (75.0 + FRONT.mass)
        assert float(pulled.sum()) == pytest.approx(expected, rel=1e-5)
        # Who stands at right angles to the floor leans back by the slope.
        up = burdens.upright(jnp.array([0.0, 0.0, 1.0]), borne)
        assert np.degrees(np.arctan2(up[0], up[2])) == pytest.approx(-degrees, abs=1e-4)
