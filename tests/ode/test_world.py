"""ODE by itself: what a block and a double pendulum must do, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.common.errors import UserError
from jaxwalk.ode import Tree, World, library

try:
    library.load()
except UserError as missing:
    pytest.skip(str(missing), allow_module_level=True)

G, DT = 9.81, 0.002
NONE = np.zeros(0)
MASS, FRICTION, SPRING, DAMPER = 10.0, 0.5, 2e5, 5e3


def block(**changes) -> Tree:
    """10 kg, on two balls 1 m apart, its centre 0.1 m over the floor at z = 0.1 m."""
    one = dict(
        timestep=DT,
        gravity=G,
        parent=np.array([-1]),
        anchor=np.zeros((1, 2)),
        centre=np.zeros((1, 2)),
        mass=np.array([MASS]),
        inertia=np.array([1.0]),
        turn=np.ones(1),
        damping=np.zeros(1),
        imu=np.array([0.0, 0.2]),
        foot=np.array([0, 0]),
        ball=np.array([[-0.5, -0.05], [0.5, -0.05]]),
        radius=np.full(2, 0.05),
        stiffness=np.full(2, SPRING),
        yielding=np.full(2, DAMPER),
        friction=FRICTION,
        soles=np.array([0, -1]),
        driven=np.zeros(0, int),
        gain=NONE,
        offset=NONE,
        rate=NONE,
        limit=NONE,
    )
    return Tree(**{**one, **changes})


def pendulum(**changes) -> Tree:
    """A heavy body, high above the floor, and a rod on it that one motor turns."""
    two = dict(
        parent=np.array([-1, 0]),
        anchor=np.array([[0.0, 0.0], [0.0, -0.3]]),
        centre=np.array([[0.0, 0.1], [0.0, -0.4]]),
        mass=np.array([1e6, 2.0]),
        inertia=np.array([1e6, 0.1]),
        turn=np.array([1.0, -1.0]),
        damping=np.zeros(2),
        foot=np.zeros(0, int),
        ball=np.zeros((0, 2)),
        radius=NONE,
        stiffness=NONE,
        yielding=NONE,
        gravity=0.0,
        driven=np.array([1]),
        gain=np.ones(1),
        offset=np.zeros(1),
        rate=np.zeros(1),
        limit=np.array([50.0]),
    )
    return block(**{**two, **changes})


def run(world: World, qpos: Any, qvel: Any, seconds: float, force: float = 0.0, control: Any = NONE):
    """Joints, rates and sensors of every tick, a row each."""
    qpos, qvel, rows = np.array(qpos, float), np.array(qvel, float), []
    push = np.zeros((len(world.tree.parent), 2))
    push[0, 0] = force
    for _ in range(round(seconds / world.tree.timestep)):
        qpos, qvel, sensed = world.tick(qpos, qvel, np.asarray(control, float), push)
        rows.append((qpos, qvel, sensed))
    return tuple(map(np.stack, zip(*rows, strict=True)))


@pytest.mark.parametrize("method", ["world", "quick"])
@pytest.mark.parametrize("steps", [1, 3])
def test_a_block_at_rest_weighs_what_it_weighs_and_sinks_into_its_springs(method, steps):
    qpos, qvel, sensed = run(World(block(), method, steps), [0, 0.1, 0], [0, 0, 0], 1.0)
    assert sensed[-1, 9] == pytest.approx(MASS * G, rel=1e-6)
    assert sensed[-1, 10] == 0.0
    assert 0.1 - qpos[-1, 1] == pytest.approx(MASS * G / (2 * SPRING), rel=1e-6)
    assert np.abs(qvel[-1]).max() < 1e-6


def test_a_block_that_is_shifted_slides_by_what_friction_leaves():
    holds, slides = (
        run(World(block()), [0, 0.1, 0], [0, 0, 0], 1.0, force)[1][-1, 0] for force in (45.0, 60.0)
    )
    assert abs(holds) < 1e-6
    # It presses a little more than it weighs only while it settles.
    assert slides == pytest.approx((60.0 - FRICTION * MASS * G) / MASS, rel=0.01)


def test_a_block_that_slides_comes_to_rest_where_friction_brings_it():
    qpos, qvel, _ = run(World(block()), [0, 0.1 - MASS * G / (2 * SPRING), 0], [2.0, 0, 0], 1.0)
    assert qpos[-1, 0] == pytest.approx(2.0**2 / (2 * FRICTION * G), rel=0.02)
    assert abs(qvel[-1, 0]) < 1e-6


def test_a_landing_follows_the_spring_and_the_damper():
    """Against the same spring and damper, integrated finely."""
    tree = block(timestep=1e-5)
    _, qvel, _ = run(World(tree), [0, 0.1 - 1e-9, 0], [0, -0.5, 0], 0.004)
    depth, speed, peak = 0.0, 0.5, []
    for _ in range(40_000):
        speed += (G - 2 * (SPRING * depth + DAMPER * speed) / MASS) * 1e-7
        depth += speed * 1e-7
        peak.append(-speed)
    assert qvel[:, 1] == pytest.approx(np.array(peak[99::100]), abs=2e-3)


def test_a_torque_turns_both_bodies_opposite_ways_and_ends_at_its_limit():
    about = 2.0 * 0.4**2 + 0.1  # kg m^2, about the hinge
    told, most = (
        run(World(pendulum()), [0, 5, 0, 0], np.zeros(4), DT, control=[torque])[1][0]
        for torque in (3.0, 900.0)
    )
    assert told[3] == pytest.approx(3.0 / about * DT, rel=1e-4)
    assert most[3] == pytest.approx(50.0 / about * DT, rel=1e-4)
    # The joint's positive sense leans the rod back, and its bearing's force has an arm of 0.4 m at the body.
    assert told[2] == pytest.approx((3.0 + 2.0 * 0.4 * 0.4 * 3.0 / about) / 1e6 * DT, rel=1e-3)


def test_a_servo_and_a_damper_are_motors():
    """A servo takes its joint to the rate at the pace of its gain, a damper to rest; both implicitly."""
    about, gain = 2.0 * 0.4**2 + 0.1, 20.0
    servo = pendulum(gain=np.array([gain]), rate=np.array([-gain]))
    _, rates, _ = run(World(servo), [0, 5, 0, 0], np.zeros(4), 0.02, control=[1.5])
    left = (1 + gain * DT / about) ** -np.arange(1.0, 11.0)
    assert rates[:, 3] == pytest.approx(1.5 * (1 - left), rel=1e-3)
    slow = pendulum(gain=np.array([gain]), rate=np.array([-gain]), limit=np.array([2.0]))
    _, rates, _ = run(World(slow), [0, 5, 0, 0], np.zeros(4), DT, control=[1.5])
    assert rates[0, 3] == pytest.approx(2.0 / about * DT, rel=1e-3)
    damped = pendulum(damping=np.array([0.0, gain]))
    _, rates, _ = run(World(damped), [0, 5, 0, 0], [0, 0, 0, 1.5], 0.02, control=[0.0])
    assert rates[:, 3] == pytest.approx(1.5 * left, rel=1e-3)


def test_a_fast_pendulum_keeps_its_momentum_and_loses_energy_to_the_steps_alone():
    """ODE's steps are of the first order: what they lose shrinks as they do; nothing is ever gained."""
    tree = pendulum(mass=np.array([3.0, 2.0]), inertia=np.array([0.5, 0.1]))

    def energy(at, rates):
        moved = tree.motion(at, rates)
        return 0.5 * (tree.mass @ (moved.speed**2).sum(1) + tree.inertia @ moved.spin**2)

    def spin(moved):
        (x, z), (u, w) = moved.place.T, moved.speed.T
        return tree.mass @ (z * u - x * w) + tree.inertia @ moved.spin

    lost = []
    for steps in (1, 2, 4):
        qpos, qvel, _ = run(World(tree, steps=steps), [0, 0, 0, 0], [0, 0, 1.0, 9.0], 1.0, control=[0.0])
        told = np.array([energy(*each) for each in zip(qpos, qvel, strict=True)])
        assert np.diff(told).max() < 1e-4 * told[0]
        lost.append(1 - told[-1] / told[0])
        moved = [tree.motion(*each) for each in zip(qpos, qvel, strict=True)]
        assert np.ptp([tree.mass @ one.speed for one in moved], axis=0).max() < 1e-9  # N s
        assert np.ptp([spin(one) for one in moved]) < 1e-5  # N m s
    assert lost[0] < 0.05
    assert 1.8 < lost[0] / lost[1] < 2.6 and 1.8 < lost[1] / lost[2] < 2.6


@pytest.mark.parametrize("broken", [np.nan, np.inf, 1e30])
def test_a_walker_that_is_not_finite_is_told_as_such(broken):
    world = World(block())
    for place in range(3):
        for told in (0, 1):
            state = np.zeros((2, 3))
            state[told, place] = broken
            if (told, place, broken) == (0, 0, 1e30):
                continue  # far away is no error
            rows = world.tick(state[0], state[1], NONE, np.zeros((1, 2)))
            assert all(np.isnan(row).all() for row in rows)
    assert np.isfinite(world.tick(np.array([0, 0.1, 0]), np.zeros(3), NONE, np.zeros((1, 2)))[0]).all()


def test_a_second_of_it_comes_out_the_same_again():
    first, again = (run(World(block(), "quick"), [0, 0.3, 0.1], [1, 0, 0], 1.0) for _ in range(2))
    assert all((one == other).all() for one, other in zip(first, again, strict=True))


def test_no_place_is_too_far():
    near, far = (run(World(block()), [x, 0.2, 0.1], [1, 0, 0], 0.5)[0] for x in (0.0, 1e3))
    assert far - near == pytest.approx(np.tile([1e3, 0, 0], (len(near), 1)), abs=1e-9)


def test_without_the_library_one_line_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(library, "NAME", "libode.so.0")
    library.load.cache_clear()
    try:
        assert cli.main(["evaluate", "fixed", "--engine", "ode"]) == 2
    finally:
        library.load.cache_clear()
    said = capsys.readouterr().err
    assert said.strip().splitlines() == [said.strip()]
    assert "libode.so.0 is not here: apt-get install libode8" in said


def test_a_body_between_walls_is_refused(capsys):
    assert cli.main(["evaluate", "fixed", "--engine", "ode", "--model", "walls"]) == 2
    assert "--engine ode: moves planar walkers" in capsys.readouterr().err
