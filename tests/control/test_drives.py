"""Gazebo's drives: the PID and the timed effort by hand, alone and under a whole walker."""

import dataclasses
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, PidConfig, validate
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import drives, walker
from jaxwalk.control.person import Person, model_of
from jaxwalk.model import mjcf, physics
from jaxwalk.model.engine import Setup
from jaxwalk.model.similarity import Similarity

PAPER = PRESETS["paper"]
DT = PAPER.physics.timestep
TABLE = Path(__file__).resolve().parents[2] / "docs" / "paper-preset.md"


def gains(**changes):
    own = dict(proportional=2.0, integral=10.0, derivative=0.5, windup=3.0, limit=20.0) | changes
    return drives.Gains(**{name: jnp.array([value]) for name, value in own.items()})


def follow(gains, errors, timestep=0.1):
    """(torque N m, integral's torque N m) of a joint after each error, rad/s."""
    pid, told = drives.Pid(jnp.zeros(1), jnp.zeros(1)), []
    for error in errors:
        pid, torque = drives.step(gains, pid, jnp.array([error]), timestep)
        told.append((float(torque[0]), float(pid.integral[0])))
    return np.array(told).T


def test_a_pid_by_hand():
    # P 2 e, I 10 e dt more each tick, D 0.5 (e - last) / dt.
    torque, integral = follow(gains(), [1.0, 0.5, -0.5, 0.0])
    np.testing.assert_allclose(integral, [1.0, 1.5, 1.0, 1.0], rtol=1e-6)
    np.testing.assert_allclose(torque, [2 + 1 + 5, 1 + 1.5 - 2.5, -1 + 1 - 5, 0 + 1 + 2.5], atol=1e-5)


def test_the_integral_is_bounded():
    torque, integral = follow(gains(derivative=0.0), [1.0] * 5 + [-1.0])
    np.testing.assert_allclose(integral, [1, 2, 3, 3, 3, 2], rtol=1e-6)
    np.testing.assert_allclose(torque, [3, 4, 5, 5, 5, 0], atol=1e-5)


def test_the_torque_is_bounded_both_ways():
    torque, _ = follow(gains(), [30.0, 30.0, -30.0])
    np.testing.assert_allclose(torque, [20, 20, -20])


def test_a_saturated_pid_winds_up_no_further():
    # 8 N m asked of a joint that gives 5: only what brings it back is integrated.
    stuck = gains(derivative=0.0, limit=5.0)
    torque, integral = follow(stuck, [4.0, 4.0, 4.0, -1.0])
    np.testing.assert_allclose(integral, [0, 0, 0, -1], atol=1e-6)
    np.testing.assert_allclose(torque, [5, 5, 5, -3], atol=1e-6)
    # Had it come to 3 N m before, it would not grow, and would fall at once when the error turns.
    _, integral = follow(stuck, [1.0, 0.5, 2.0, 2.0, -2.0])
    np.testing.assert_allclose(integral, [1, 1.5, 1.5, 1.5, -0.5], atol=1e-6)


def test_an_effort_lasts_its_ticks_and_no_more():
    none = drives.Effort(jnp.zeros(2), jnp.zeros(2, jnp.int32))
    effort = drives.begin(none, jnp.array([True, False]), jnp.array([7.0, 9.0]), jnp.int32(3))
    given = []
    for _ in range(5):
        effort, torque = drives.spend(effort)
        given.append(torque.tolist())
    assert given == [[7, 0], [7, 0], [7, 0], [0, 0], [0, 0]]


def test_both_ways_move_every_joint():
    """Each actuator's PID and effort act on its own joint alone, in the plane and between walls."""
    for layout in (mjcf.PLANAR, mjcf.WALLS):
        own = PAPER.physics.gazebo
        alike = {name: PidConfig(1.0, 0.0, 0.0, 0.0) for name in ("hip", "knee", "ankle", "abduction")}
        told = dataclasses.replace(PAPER.physics, gazebo=dataclasses.replace(own, **alike))
        body = Similarity(1.0, 1.0)
        moves = np.eye(layout.dofs, dtype=np.float32)
        plant = physics.Plant(jnp.zeros(layout.dofs), jnp.zeros(layout.dofs), jnp.zeros(layout.dofs))
        for joint, name in enumerate(layout.joints):
            moving = plant.replace(qvel=jnp.array(moves[joint]))
            wanted = drives.rates(told, layout, body, jnp.zeros(6), moving)
            error = wanted - layout.actuated(moving.qvel)
            rest = drives.start(layout)
            _, torque = drives.step(drives.gains(told, layout, body), rest.pid, error, DT)
            actuated = not name.startswith(("root", "inversion"))
            assert sorted(torque.tolist())[:1] == [-1.0 if actuated else 0.0]
            assert jnp.count_nonzero(torque) == actuated
            effort = drives.begin(rest.effort, torque != 0, torque, jnp.int32(1))
            np.testing.assert_array_equal(drives.spend(effort)[1], torque)


def walks(config, engine, rows, seconds, noise=1.0):
    """[rows, T] plants, whether it has fallen, and actuator torques (N m) of the nominal step."""
    setup = Setup.of(config, engine)

    def one(key):
        who = Person.of(config.gait, jnp.float32(1.8), jnp.float32(75.0))
        model = model_of(setup, who)

        def tick(state, _):
            _, control, _ = walker.drive(setup, state)
            after, event = walker.tick(setup, model, state)
            return after, (after.plant, event.fell, control, state.gait)

        begun = walker.start(setup, who, key, jnp.float32(noise))
        return jax.lax.scan(tick, begun, length=round(seconds / config.physics.timestep))[1]

    return jax.device_get(jax.jit(jax.vmap(one))(jax.random.split(jax.random.key(0), rows)))


@pytest.fixture(scope="module")
def in_c():
    return walks(PAPER, "mujoco", 4, 4.0)


def test_the_papers_walker_walks_with_its_nominal_step(in_c):
    plants, fell, _, _ = in_c
    assert not fell.any()
    assert (plants.qpos[:, -1, 0] - plants.qpos[:, 2000, 0] > 2.0 * 0.4).all()


def test_toe_off_is_an_effort_of_its_duration(in_c):
    _, _, torque, gait = in_c
    ankles = torque[:, :, [2, 5]]
    swing = np.take_along_axis(ankles, 1 - gait.stance[..., None], 2)[..., 0]
    stance = np.take_along_axis(ankles, gait.stance[..., None], 2)[..., 0]
    assert (stance == 0).all()  # passive
    push = np.round(gait.toe_off_seconds / DT)
    retraction = round(PAPER.physics.gazebo.retraction_seconds / DT)
    at = np.round(gait.elapsed / DT)
    pressed = (at < push) & (gait.toe_off > 0)
    assert pressed.any()
    # A push ends early where the foot has left the floor, and the retraction follows it at once.
    held = (swing == -gait.toe_off) & pressed
    assert held[at == 0].sum() == (pressed & (at == 0)).sum()
    assert held.sum() > 0.3 * pressed.sum()
    assert (swing[at >= push + retraction] == 0).all()
    assert (np.abs(swing) <= PAPER.physics.ankle_limit).all()


def test_the_pids_keep_within_their_limits(in_c):
    _, _, torque, _ = in_c
    for joint, limit in ((0, PAPER.physics.hip_limit), (1, PAPER.physics.knee_limit)):
        assert (np.abs(torque[:, :, [joint, joint + 3]]) <= limit).all()


@pytest.mark.slow
def test_mjx_moves_it_as_c_does(in_c):
    ticks = round(0.5 / DT)
    ours, fell, _, _ = walks(PAPER, "mjx", 4, 0.5)
    theirs = in_c[0].qpos[:, :ticks]
    assert not fell.any()
    off = np.abs(ours.qpos - theirs)[:, :, :3]
    assert off[:, :100].max() < 2e-3
    assert np.median(off.max((1, 2))) < 0.01
    assert off.max() < 0.05


def test_a_push_that_grows_is_no_effort():
    gait = dataclasses.replace(PAPER.gait, toe_off_latched=False)
    with pytest.raises(UserError, match=r"--gait\.toe-off-latched"):
        validate.check(dataclasses.replace(PAPER, gait=gait))


@pytest.mark.slow
def test_it_walks_between_walls_too():
    config = dataclasses.replace(PAPER, body=BodyConfig(table="box", model="walls"))
    plants, fell, _, _ = walks(config, "mujoco", 4, 4.0)
    assert not fell.any()
    held = [mjcf.WALLS.joints.index(f"abduction_{side}") for side in mjcf.SIDES]
    assert np.abs(plants.qpos[..., held]).max() < 0.1


def rows():
    """{name: value} of every constant in the table, both as it is written there."""
    lines = TABLE.read_text().splitlines()
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")
    ]
    return {row[0].strip("`"): row[1] for row in cells}


def written(value):
    if isinstance(value, tuple):
        return ", ".join(map(str, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def test_the_table_is_the_preset():
    told, true = rows(), dict(validate.leaves(PAPER))
    parts = "gait.compliant.", "gait.step_plan.", "circumstances."  # of other legs, and of nobody
    others = [name for name in true if name.startswith(parts) and name != "circumstances.share"]
    assert PAPER.gait.form == "rigid"
    true = {name: value for name, value in true.items() if name not in others}
    true |= {f"{part}*": "as in format 1" for part in parts} | {"circumstances.*": "as by default"}
    assert set(told) == set(true)
    assert {name: value for name, value in told.items() if value != written(true[name])} == {}
