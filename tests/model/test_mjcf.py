"""The MJCF says what its conventions say, and the files in models/ are it."""

import importlib.util
from pathlib import Path

import mujoco
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import anthropometry, mjcf

ROOT = Path(__file__).resolve().parents[2]


def make_models():
    spec = importlib.util.spec_from_file_location("make_models", ROOT / "scripts" / "make_models.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def model():
    return mjcf.build(anthropometry.build(BodyConfig()), PhysicsConfig()).compile()


def pose(model, **angles):
    """The body hanging from a hip at 1 m, its joints at ``angles``."""
    data = mujoco.MjData(model)
    data.joint("root_z").qpos = 1.0
    for name, angle in angles.items():
        data.joint(name).qpos = angle
    mujoco.mj_forward(model, data)
    return data


@pytest.mark.parametrize("name", ["planar.xml", "planar_box.xml", "biped_walls.xml"])
def test_committed_models_are_the_generated_ones(name):
    making = make_models()
    fresh = making.text(making.FILES[name])
    assert (ROOT / "models" / name).read_text() == fresh, "run `make models` and commit models/"


def test_no_other_model_is_committed():
    assert {path.name for path in (ROOT / "models").glob("*.xml")} == set(make_models().FILES)


def test_a_committed_model_loads_as_the_one_in_use(model):
    loaded = mujoco.MjModel.from_xml_path(str(ROOT / "models" / "planar.xml"))
    # Six digits are what MuJoCo writes into XML.
    for field in ("body_mass", "body_inertia", "body_ipos", "geom_size", "pair_solref", "actuator_biasprm"):
        np.testing.assert_allclose(getattr(loaded, field), getattr(model, field), rtol=1e-5, atol=1e-9)
    assert loaded.opt.timestep == model.opt.timestep
    assert (loaded.opt.jacobian, loaded.opt.integrator) == (model.opt.jacobian, model.opt.integrator)


def test_nine_degrees_of_freedom_in_order(model):
    assert (model.nq, model.nv) == (9, 9)
    assert [model.joint(i).name for i in range(9)] == list(mjcf.PLANAR.joints)
    assert mjcf.PLANAR.joints == (
        "root_x", "root_z", "root_pitch",
        "hip_left", "knee_left", "ankle_left", "hip_right", "knee_right", "ankle_right",
    )  # fmt: skip


def test_six_actuators_in_order_each_on_its_own_joint(model):
    assert [model.actuator(i).name for i in range(model.nu)] == list(mjcf.PLANAR.joints[3:])
    for i in range(model.nu):
        assert model.joint(model.actuator(i).trnid[0]).name == model.actuator(i).name


def test_sensors_lie_where_the_plant_slices_them(model):
    slices = {model.sensor(i).name: (model.sensor_adr[i], model.sensor_dim[i]) for i in range(model.nsensor)}
    assert slices == {
        "imu_velocity": (0, 3),
        "imu_up": (3, 3),
        "imu_gyro": (6, 3),
        "touch_left": (9, 1),
        "touch_right": (10, 1),
    }


def test_a_positive_pitch_leans_forward(model):
    data = pose(model, root_pitch=0.3)
    top = data.site("imu").xpos - data.body("torso").xpos
    assert top == pytest.approx([0.32452 * np.sin(0.3), 0, 0.32452 * np.cos(0.3)], abs=1e-4)
    assert data.sensor("imu_up").data == pytest.approx([np.sin(0.3), 0, np.cos(0.3)])


def test_a_positive_pitch_rate_reads_as_a_positive_gyro(model):
    data = mujoco.MjData(model)
    data.joint("root_pitch").qvel = 0.7
    mujoco.mj_forward(model, data)
    assert data.sensor("imu_gyro").data == pytest.approx([0, 0.7, 0])
    assert data.sensor("imu_velocity").data == pytest.approx([0.7 * 0.32452, 0, 0], abs=1e-4)


@pytest.mark.parametrize("side", mjcf.SIDES)
def test_flexions_are_positive_and_turn_only_their_own_leg(model, side):
    other = mjcf.SIDES[1 - mjcf.SIDES.index(side)]
    straight = pose(model)

    def moved(name):
        data = pose(model, **{f"{name}_{side}": 0.4})
        for what in ("foot", "shank"):
            assert data.body(f"{what}_{other}").xpos == pytest.approx(straight.body(f"{what}_{other}").xpos)
        return data, data.body(f"foot_{side}").xpos - straight.body(f"foot_{side}").xpos

    # Thigh 0.441 m and shank 0.4428 m turn together about the hip: forward and up.
    _, ankle = moved("hip")
    assert ankle == pytest.approx([0.8838 * np.sin(0.4), 0, 0.8838 * (1 - np.cos(0.4))], abs=1e-9)
    # The shank alone turns about the knee: back and up.
    _, ankle = moved("knee")
    assert ankle == pytest.approx([-0.4428 * np.sin(0.4), 0, 0.4428 * (1 - np.cos(0.4))], abs=1e-9)
    # Dorsiflexion raises the toe over the heel and leaves the ankle where it is.
    data, ankle = moved("ankle")
    assert ankle == pytest.approx([0, 0, 0], abs=1e-12)
    rise = data.geom(f"toe_{side}").xpos[2] - data.geom(f"heel_{side}").xpos[2]
    assert rise == pytest.approx((0.132 + 0.042) * np.sin(0.4), abs=1e-9)


def test_the_spheres_end_where_the_sole_ends(model):
    built = anthropometry.build(BodyConfig())
    data = pose(model)
    for side in mjcf.SIDES:
        ankle = data.body(f"foot_{side}").xpos
        heel, toe = model.geom(f"heel_{side}"), model.geom(f"toe_{side}")
        assert data.geom(heel.id).xpos[0] - heel.size[0] - ankle[0] == pytest.approx(built.heel)
        assert data.geom(toe.id).xpos[0] + toe.size[0] - ankle[0] == pytest.approx(built.toe)
        for end in (heel, toe):
            assert data.geom(end.id).xpos[2] - end.size[0] == pytest.approx(1.0 - built.hip_height)


def test_only_the_four_spheres_touch_only_the_floor(model):
    geoms = np.stack([model.pair_geom1, model.pair_geom2], axis=1)
    pairs = [{model.geom(geom).name for geom in pair} for pair in geoms]
    ends = [f"{end}_{side}" for side in mjcf.SIDES for end in ("heel", "toe")]
    assert sorted(pairs, key=sorted) == sorted([{"floor", end} for end in ends], key=sorted)
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()


def test_physics_settings_reach_the_model():
    physics = PhysicsConfig(
        timestep=0.001, iterations=7, ls_iterations=9, tolerance=1e-7, contact_timeconst=0.011,
        heel_timeconst=0.013, friction=0.6, drives="servo",
        hip_gain=100.0, hip_limit=101.0, knee_stiffness=102.0, knee_damping=103.0, knee_limit=104.0,
        ankle_limit=105.0, ankle_damping=2.0,
    )  # fmt: skip
    model = mjcf.build(anthropometry.build(BodyConfig()), physics).compile()
    opt = model.opt
    assert (opt.timestep, opt.iterations, opt.ls_iterations, opt.tolerance) == (0.001, 7, 9, 1e-7)
    assert model.pair_solref[:, 0] == pytest.approx([0.013, 0.011] * 2)  # heel, toe
    assert model.pair_friction[:, 0] == pytest.approx(0.6)
    hip, knee, ankle = (model.actuator(f"{joint}_right") for joint in ("hip", "knee", "ankle"))
    # Velocity servo: torque = gain (command - rate). Position servo: k (command - angle) - c rate.
    assert (hip.gainprm[0], *hip.biasprm[:3]) == (100, 0, 0, -100)
    assert (knee.gainprm[0], *knee.biasprm[:3]) == (102, 0, -102, -103)
    assert (ankle.gainprm[0], *ankle.biasprm[:3]) == (1, 0, 0, 0)
    assert [a.forcerange[1] for a in (hip, knee, ankle)] == [101, 104, 105]
    assert all(a.forcelimited[0] for a in (hip, knee, ankle))
    assert model.joint("ankle_left").damping[0] == 2.0
    assert model.joint("hip_left").damping[0] == model.joint("knee_left").damping[0] == 0.0


@pytest.mark.parametrize("drives", ["servo", "torque"])
def test_similar_bodies_move_alike(drives):
    """Two bodies of one shape, lengths 1 : 2 and times 1 : sqrt 2, follow one path (Froude)."""
    paths = []
    for height, mass in ((1.5, 40.0), (3.0, 200.0)):
        ratio, time = height / 1.5, (height / 1.5) ** 0.5
        physics = PhysicsConfig(
            timestep=0.001 * time, iterations=100, tolerance=1e-12, contact_timeconst=0.006 * time,
            heel_timeconst=0.012 * time, drives=drives,
        )  # fmt: skip
        built = anthropometry.build(BodyConfig(height, mass))
        model = mjcf.build(built, physics).compile()
        # The one length of MuJoCo's own that the configuration leaves alone: the depth over which
        # contacts stiffen (solimp's width, 1 mm).
        model.pair_solimp[:, 2] *= ratio
        data = mujoco.MjData(model)
        data.qpos[:] = [0, 1.01 * built.hip_height, 0.05, 0.3, 0.2, -0.05, -0.3, 0.1, 0.25]
        data.qvel[0] = 1.0 * time  # speed scales like time
        torque = mass * height / (40 * 1.5)
        data.ctrl[:] = (
            [-1.5 / time, 0.1, 0, 1.0 / time, 0.8, -5.0 * torque]
            if drives == "servo"
            else torque * np.array([-20.0, -40.0, -10.0, -10.0, -30.0, -5.0])
        )
        path = []
        for _ in range(300):
            mujoco.mj_step(model, data)
            path.append([data.qpos[0] / ratio, data.qpos[1] / ratio, *data.qpos[2:]])
        paths.append(path)
    # The feet land at once; the solver's convergence (1e-12) is what is left of differences.
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-6)
    assert np.ptp(np.array(paths[0])[:, 0]) > 0.1
