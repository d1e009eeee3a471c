"""Forces against mechanics: what they do to the body in sum is what the body does.

C MuJoCo, in doubles, tells momentum and energy at the start and the end of an open-loop flight of commands.
"""

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from jaxwalk.config import GRAVITY, BodyConfig, Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import Person, model_of, skeleton
from jaxwalk.measure.gait import forces
from jaxwalk.model import mjcf, physics, strength
from jaxwalk.model.engine import Setup

BODY, DT, TICKS, ROWS = BodyConfig(), 0.002, 200, 3
# Of hip, knee and ankle, left then right.
COMMANDS = {
    # Hip rate, knee angle, ankle torque: the first row lets it stand on stiff legs; the second saturates
    # hips and knees; the third pushes off.
    "servo": [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [8.0, 1.4, 5.0, -8.0, 1.0, -5.0],
        [0.5, 0.1, -60.0, -0.5, 0.0, -20.0],
    ],
    # Angles beyond the start's, rad, to which torques spring: the same.
    "torque": [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1.5, 1.4, 0.1, -1.5, 1.0, -0.1],
        [0.1, 0.1, -1.2, -0.1, 0.0, -0.4],
    ],
}
STIFFNESS, DAMPING = np.tile([300.0, 400.0, 50.0], 2), np.tile([20.0, 20.0, 2.0], 2)
CONFIGS = {"servo": PRESETS["rigid"], "torque": Config()}


@pytest.fixture(scope="module", params=COMMANDS)
def config(request):
    return CONFIGS[request.param]


@pytest.fixture(scope="module")
def flown(config):
    """(start, end) plants [ROWS] and the forces [ROWS, TICKS] between."""
    setup, settings = Setup.of(config), config.physics

    def one(key, command):
        who = Person.of(config.gait, jnp.float32(1.8), jnp.float32(75.0))
        model, bones = model_of(setup, who), skeleton(setup, who)
        start = walker.start(setup, who, key, jnp.float32(0.0)).plant

        def tick(plant, _):
            told = command
            if settings.drives == "torque":
                told = STIFFNESS * (start.qpos[3:] + told - plant.qpos[3:]) - DAMPING * plant.qvel[3:]
            made = physics.advance(BODY, settings, model, plant, told, jnp.zeros((7, 2)))
            return physics.outcome(BODY, made[1])[0], forces.of_tick(mjcf.PLANAR, bones, plant, *made)

        end, told = jax.lax.scan(tick, start, length=TICKS)
        return start, end, told

    keys = jax.random.split(jax.random.key(3), ROWS)
    told = jnp.asarray(COMMANDS[settings.drives], jnp.float32)
    return jax.device_get(jax.jit(jax.vmap(one))(keys, told))


def mechanics(config, plant, row):
    """Forward and upward momentum (N s) and energy (J), by C MuJoCo."""
    model = physics.compile_mujoco(BODY, config.physics)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = plant.qpos[row], plant.qvel[row]
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    momentum = data.subtree_linvel[0] * model.body_subtreemass[0]
    return momentum[0], momentum[2], data.energy.sum()


@pytest.mark.parametrize("row", range(ROWS))
def test_the_ground_s_impulse_is_the_momentum_gained(config, flown, row):
    start, end, told = flown
    before, after = mechanics(config, start, row), mechanics(config, end, row)
    weight = 75 * GRAVITY
    ground = told.ground[row].astype(np.float64).sum((0, 1)) * DT
    # The share of what the ground gives altogether that a time step of 2 ms loses to the pose's change.
    size = weight * TICKS * DT
    assert ground[0] == pytest.approx(after[0] - before[0], abs=0.01 * size)
    assert ground[1] - size == pytest.approx(after[1] - before[1], abs=0.01 * size)


@pytest.mark.parametrize("row", range(ROWS))
def test_work_is_the_energy_gained(config, flown, row):
    start, end, told = flown
    before, after = mechanics(config, start, row), mechanics(config, end, row)
    rates = told.rates[row].astype(np.float64)
    actuators, damping = told.torque[row] * rates, told.damping[row] * rates[..., 2]
    parts = np.array([actuators.sum(), damping.sum(), told.contact_power[row].sum()]) * DT
    gross = DT * (np.abs(actuators).sum() + np.abs(damping).sum() + np.abs(told.contact_power[row]).sum())
    assert parts.sum() == pytest.approx(after[2] - before[2], abs=0.03 * gross)


def test_torques_stay_within_the_actuators_limits_and_damping_brakes(config, flown):
    _, _, told = flown
    limits = [config.physics.hip_limit, config.physics.knee_limit, config.physics.ankle_limit]
    peaks = [strength.peak(config.physics.actuators, joint) for joint in range(3)]
    limits = [limit if peak is None else peak for limit, peak in zip(limits, peaks, strict=True)]
    # A servo just below its limit at a tick's start may end that tick a little above it.
    assert (np.abs(told.torque) <= np.array(limits) * 1.25).all()
    assert np.isclose(np.abs(told.torque[1, :, :, 0]), limits[0]).any()  # the second row saturates
    assert (told.damping * told.rates[..., 2]).sum() < 0


def test_a_foot_in_the_air_feels_no_ground(flown):
    _, _, told = flown
    up = told.ground[..., 1] == 0
    assert up.any()
    # Float32 moments of hundreds of N m at the other leg must not leak into this one.
    assert np.abs(told.ground[..., 0][up]).max() < 0.1
    assert (told.ground[..., 1] >= 0).all()
