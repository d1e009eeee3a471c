"""The paper's own body: what it is made of, that its walls only guide it, and that it walks.

In C MuJoCo throughout; that MJX moves it alike is told in test_walls_physics.py.
"""

import mujoco
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, Config, PhysicsConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.model import anthropometry, c_mujoco, mjcf, physics
from jaxwalk.show.web import figure

CONFIG = Config(body=BodyConfig(model="walls"))
GAP = 0.01  # m, at 1.8 m
FREE = 0.008  # m of it, before the walls begin to give way
SHOULDER = 0.288 * 1.8  # m, over the hip


@pytest.fixture(scope="module")
def model():
    return physics.compile_mujoco(CONFIG.body, CONFIG.physics)


def pose(model, **joints):
    """The body hanging from a hip at 1.5 m, its joints at ``joints``."""
    data = mujoco.MjData(model)
    data.joint("root_z").qpos = 1.5
    for name, angle in joints.items():
        data.joint(name).qpos = angle
    mujoco.mj_forward(model, data)
    return data


def touching(model, data):
    """Names of the pairs that touch."""
    names = [{model.geom(geom).name for geom in data.contact[i].geom} for i in range(data.ncon)]
    return sorted("-".join(sorted(pair)) for pair in names)


def test_sixteen_degrees_of_freedom_ten_of_them_in_the_legs(model):
    assert (model.nq, model.nv, model.nu) == (16, 16, 8)
    assert [model.joint(i).name for i in range(16)] == list(mjcf.WALLS.joints)
    assert mjcf.WALLS.joints[:6] == (
        "root_x", "root_z", "root_pitch", "root_y", "root_roll", "root_yaw",
    )  # fmt: skip
    assert mjcf.WALLS.joints[6:11] == (
        "abduction_left", "hip_left", "knee_left", "ankle_left", "inversion_left",
    )  # fmt: skip
    assert [model.body(i + 1).name for i in range(model.nbody - 1)] == list(mjcf.SEGMENTS)


def test_the_planar_actuators_come_first_and_nothing_drives_the_foot_s_inversion(model):
    driven = [model.joint(model.actuator(i).trnid[0]).name for i in range(model.nu)]
    planar = ["hip_left", "knee_left", "ankle_left", "hip_right", "knee_right", "ankle_right"]
    assert driven == [*planar, "abduction_left", "abduction_right"]
    assert driven == [mjcf.WALLS.joints[i] for i in mjcf.WALLS.actuated(np.arange(16.0)).astype(int)]
    for side in mjcf.SIDES:
        assert model.joint(f"inversion_{side}").damping[0] == CONFIG.physics.ankle_damping
        assert not model.joint(f"inversion_{side}").stiffness.any()


def test_abduction_is_held_by_a_pid_of_velocity(model):
    settings = PhysicsConfig(abduction_gain=70.0, abduction_integral=900.0, abduction_limit=80.0)
    held = physics.compile_mujoco(CONFIG.body, settings).actuator("abduction_right")
    # Told to stand still: torque = -gain rate - integral (the rate summed up, which is the angle).
    assert (held.gainprm[0], *held.biasprm[:3], held.forcerange[1]) == (900, 0, -900, -70, 80)


def test_only_soles_touch_the_floor_and_only_the_trunk_the_walls_without_friction(model):
    geoms = np.stack([model.pair_geom1, model.pair_geom2], axis=1)
    pairs = {
        frozenset(model.geom(geom).name for geom in pair): dim
        for pair, dim in zip(geoms, model.pair_dim, strict=True)
    }
    corners = [
        f"{end}_{row}_{side}" for side in mjcf.SIDES for row in ("inner", "outer") for end in ("heel", "toe")
    ]
    flanks = [(f"wall_{side}", f"{part}_{side}") for side in mjcf.SIDES for part in ("hip", "shoulder")]
    expected = {frozenset(("floor", corner)): 3 for corner in corners}
    assert pairs == expected | {frozenset(flank): 1 for flank in flanks}
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()


@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])
def test_the_trunk_is_free_on_either_side_as_far_as_the_walls_lining(model, side, sign):
    flank = model.geom(f"shoulder_{side}")
    assert abs(model.geom(f"wall_{side}").pos[1] - flank.pos[1]) - flank.size[0] == pytest.approx(GAP)
    assert touching(model, pose(model, root_y=0.99 * sign * FREE)) == []
    hip, shoulder = f"hip_{side}-wall_{side}", f"shoulder_{side}-wall_{side}"
    assert touching(model, pose(model, root_y=1.01 * sign * FREE)) == [hip, hip, shoulder]
    # Tilted about the hip, the shoulder alone touches; the pitch does not change that.
    tilt = -sign * np.arcsin(1.1 * FREE / SHOULDER)
    assert touching(model, pose(model, root_roll=tilt, root_pitch=0.3)) == [shoulder]
    # Turned, one end of the hip does, on either side.
    ends = touching(model, pose(model, root_yaw=0.2))
    assert ends == ["hip_left-wall_left", "hip_right-wall_right"]


def test_pitch_is_what_the_instruments_say_however_it_tilts(model):
    data = pose(model, root_pitch=0.3, root_roll=0.04, root_yaw=-0.1)
    up = data.sensor("imu_up").data
    assert np.arctan2(up[0], up[2]) == pytest.approx(0.3, abs=1e-12)


@pytest.mark.parametrize(("side", "out"), [("left", 1.0), ("right", -1.0)])
def test_abduction_goes_outward_and_inversion_lifts_the_inner_edge(model, side, out):
    straight, data = pose(model), pose(model, **{f"abduction_{side}": 0.1})
    moved = data.body(f"foot_{side}").xpos - straight.body(f"foot_{side}").xpos
    assert moved[1] == pytest.approx(out * 0.8838 * np.sin(0.1), abs=1e-9)
    data = pose(model, **{f"inversion_{side}": 0.1})
    inner, outer = (data.geom(f"toe_{row}_{side}").xpos[2] for row in ("inner", "outer"))
    assert inner - outer == pytest.approx(2 * 0.027 * np.sin(0.1), abs=1e-9)


def test_the_boxes_of_the_box_table_have_a_box_s_inertia():
    model = physics.compile_mujoco(BodyConfig(table="box", model="walls"), PhysicsConfig())
    for name in ("thigh_left", "shank_right"):
        x, y, z = model.geom(name).size
        part = model.body(name)
        about = part.mass[0] / 3 * np.array([y**2 + z**2, x**2 + z**2, x**2 + y**2])
        # The table's pitching inertia is a rod's, which lacks the box's thickness: x^2 / z^2, up to 6 %.
        np.testing.assert_allclose(part.inertia, about, rtol=0.06)
    # All in all the mass is the person's.
    assert model.body_subtreemass[0] == pytest.approx(75.0)


def test_the_mirrored_walker_mirrors_the_walk(model):
    """Left for right, every sideways joint's sign turned: the same walk."""
    other = np.r_[:6, 11:16, 6:11]
    turned = np.where(np.isin(np.arange(16), [3, 4, 5]), -1.0, 1.0)
    rng = np.random.default_rng(0)
    qpos = rng.uniform(-0.02, 0.02, 16)
    qpos[1] = 0.95
    control = np.array([1.0, 0.3, 5.0, -1.0, 0.1, -5.0, 0.0, 0.0])
    ends = []
    for start, told in ((qpos, control), (turned * qpos[other], control[[3, 4, 5, 0, 1, 2, 7, 6]])):
        settings = c_mujoco.converged(PRESETS["rigid"].physics)  # servos hold the legs
        data = mujoco.MjData(physics.compile_mujoco(CONFIG.body, settings))
        data.qpos[:], data.ctrl[:] = start, told
        for _ in range(200):
            mujoco.mj_step(data.model, data)
        ends.append(data.qpos.copy())
    # Rounding (1e-16), through contacts that multiply it by some 1e6.
    np.testing.assert_allclose(turned * ends[0][other], ends[1], atol=1e-8)
    assert abs(ends[0][3]) > 1e-4 and abs(ends[0][0]) > 1e-2


def limp(spec_change=None):
    """The body with nothing that drives or dampens it, in a world without weight, off the floor."""
    spec = mjcf.build(anthropometry.build(CONFIG.body), c_mujoco.converged(CONFIG.physics), "walls")
    spec.option.gravity = [0, 0, 0]
    spec.option.timestep = 0.001
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    if spec_change is not None:
        spec_change(spec)
    model = spec.compile()
    model.dof_damping[:] = 0
    data = mujoco.MjData(model)
    data.joint("root_z").qpos = 2.0
    return model, data


def rub(spec):
    for pair in spec.pairs:
        pair.condim, pair.friction = 3, [0.1, 0.1, 0, 0, 0]


def pressed(change=None):
    """Half a second's slide along the left wall at 1 m/s, pressed on by 60 N.

    Returns:
      Energy lost (J), momentum forward lost (N s), mean force on the wall (N).
    """
    model, data = limp(change)
    data.qvel[0] = 1.0
    data.xfrc_applied[1, 1] = 60.0
    told = []
    for _ in range(2):
        force = 0.0
        for _ in range(500):
            mujoco.mj_step(model, data)
            force += data.sensor("wall_left").data[0] / 500
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        told.append((data.energy.sum(), data.subtree_linvel[0][0] * 75.0))
    return *(np.array(told[0]) - told[1]), force


def test_sliding_along_a_wall_costs_no_energy():
    lost, slowed, force = pressed()
    # The torso alone is pushed, the limbs swing after it a little, so that the force is not all of the 60 N.
    assert force == pytest.approx(60.0, rel=0.2)
    assert abs(slowed) < 1e-6
    # Against the 3 J that a friction of 0.1 takes on half a metre, as a rough wall shows.
    assert abs(lost) < 0.05
    lost, slowed, _ = pressed(rub)
    assert lost > 1.5 and slowed > 1.5


def test_seen_from_the_side_it_is_the_planar_walker():
    """The page that replays walks draws both alike: the same figure, from the same nine coordinates."""
    config = CONFIG.body
    flat, free = (
        figure.figure(physics.compile_mujoco(BodyConfig(model=name), CONFIG.physics))
        for name in ("planar", config.model)
    )
    assert free == flat
    joints = mjcf.WALLS.planar(np.arange(16.0)[None])[0]
    assert [mjcf.WALLS.joints[int(i)] for i in joints] == list(mjcf.PLANAR.joints)
