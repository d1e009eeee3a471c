"""The walker in ODE as a node moves it: loads, resets, instruments, the loop, and what a walk came to."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

from jaxwalk.common import files
from jaxwalk.ros import loop, wire
from jaxwalk.ros.measures import Record
from jaxwalk.ros.simulation import Simulation, unfit
from jaxwalk.ros.wire import PASSIVE

TICK = 2_000_000  # ns


def hung(body):
    """A simulation of ``body`` high in the air, at rest."""
    lifted = dataclasses.replace(body, qpos=body.qpos + np.eye(1, 9, 1)[0] * 5, qvel=np.zeros(9))
    return Simulation(lifted)


def momentum(simulation):
    tree = simulation.body.tree
    return tree.mass @ tree.motion(simulation.qpos, simulation.qvel).speed[:, 0]


def test_a_wrench_gives_its_impulse_at_its_time(body):
    simulation = hung(body)
    assert simulation.wrench("shank_left", 400.0, 0.0, 5 * TICK, 10 * TICK) == ""
    assert simulation.wrench("elbow", 1.0, 0.0, 0, 0).startswith("no body elbow: give one of torso")
    given = []
    for _ in range(30):
        simulation.tick(PASSIVE)
        given.append(momentum(simulation))
    assert given[4] == pytest.approx(0.0, abs=1e-9)
    assert given[5] == pytest.approx(0.8, abs=1e-6)  # 400 N in 2 ms
    assert given[14:] == pytest.approx(np.full(16, 8.0), abs=1e-9)


def test_an_effort_is_added_to_the_command_and_ends(body):
    rates = []
    for asked, told in ((0.0, 20.0), (15.0, 5.0)):
        simulation = hung(body)
        assert simulation.effort("knee_right", asked, 0, 3 * TICK) == ""
        for _ in range(3):
            simulation.tick((0, 0, 0, 0, told, 0))
        rates.append(simulation.qvel[7])
        assert simulation.effort("elbow", 1.0, 0, 0).startswith("no joint elbow")
    assert rates[0] == pytest.approx(rates[1], abs=1e-12) and rates[0] > 0.05
    assert not simulation._efforts or not simulation._acting(simulation._efforts)
    for_ever = hung(body)
    for_ever.effort("knee_right", 20.0, 0, -1)
    for _ in range(3):
        for_ever.tick(PASSIVE)
    assert for_ever.qvel[7] == pytest.approx(rates[0], abs=1e-12)


def test_loads_that_are_none_are_refused(body):
    simulation = hung(body)
    for value in (math.nan, math.inf):
        assert simulation.effort("knee_right", value, 0, -1).startswith("give finite")
        assert simulation.wrench("torso", value, 0.0, 0, -1).startswith("give finite")
        assert simulation.wrench("torso", 0.0, value, 0, -1).startswith("give finite")
    assert simulation.effort("knee_right", 1.0, 0, 0).startswith("duration 0")
    assert simulation.wrench("torso", 1.0, 0.0, 0, 0).startswith("duration 0")
    assert simulation._efforts == simulation._wrenches == []


def test_wrenches_are_in_the_plane_at_the_centre_in_the_worlds_frame():
    nought, along, about = (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)
    assert unfit("", nought, along, about) == unfit("world", nought, along, about) == ""
    assert unfit("torso", nought, along, about) == "reference_frame torso: give world"
    for wrong in ((along, along, about), (nought, about, about), (nought, along, along)):
        assert unfit("", *wrong).startswith("give a force along x")
    assert unfit("", nought, (0.0, math.nan, 0.0), about)


def test_a_reset_forgets(body):
    simulation = hung(body)
    first = simulation.frame
    simulation.wrench("torso", 400.0, 0.0, 0, -1)
    simulation.tick(PASSIVE)
    simulation.reset()
    assert (simulation.frame, simulation.now) == (first, 0)
    simulation.tick(PASSIVE)
    assert momentum(simulation) == pytest.approx(0.0, abs=1e-9)


def test_frames_tell_what_the_instruments_do(body):
    simulation = Simulation(body)
    one = simulation.tick(PASSIVE)
    said = wire.sensors(one)
    assert one.nanoseconds == TICK
    assert said.pitch == pytest.approx(body.qpos[2], abs=1e-12)  # MuJoCo's are of the tick's start
    assert said.joints == pytest.approx(simulation.qpos[3:].reshape(2, 3), abs=0)
    assert said.pitch_rate == pytest.approx(body.qvel[2], abs=1e-12)
    assert one.finite and not dataclasses.replace(one, pitch=(math.nan, 1.0)).finite


def test_the_loop_answers_every_frame(body, keeper):
    given = loop.commands(hung(body), keeper, 4)
    assert [row[0] for row in given] == [101.0, 1.0, 2.0, 3.0]


def test_the_shipped_policy_walks_in_ode(body, shipped, said):
    simulation = Simulation(body)
    loop.commands(simulation, shipped, 1500)
    place = simulation.qpos[0]
    simulation.wrench("torso", 400.0, 0.0, 0, 50 * TICK)  # 40 N s
    loop.commands(simulation, shipped, 2000)
    assert simulation.qpos[1] > 0.85 and said == []
    assert (simulation.qpos[0] - place) / 4.0 == pytest.approx(1.05, abs=0.15)


def test_a_report_has_no_latency_where_nobody_answered(tmp_path):
    record = Record(0.002)
    record.add(np.array([0.0, 1.0, 0.0]), PASSIVE, math.nan, 0.0)
    files.write_json(tmp_path / "report.json", record.told(1.0))
    assert json.loads((tmp_path / "report.json").read_text())["latency"] == {"mean": None, "p99": None}


def test_what_a_walk_came_to():
    record = Record(0.002)
    for tick in range(2501):
        record.add(np.array([0.002 * tick, 1.0, 0.0]), (0.0,) * 6, 0.001, 0.004 * tick)
    assert not record.fallen
    record.add(np.array([5.0, 0.5, 0.0]), PASSIVE, math.nan, 10.004)
    told = record.told(0.5)
    assert told["fell"] and (told["passive_ticks"], told["unanswered_ticks"]) == (1, 1)
    assert told["speed"] == pytest.approx(1.0, rel=1e-3)
    assert told["period"]["mean"] == pytest.approx(4.0) and told["latency"]["mean"] == pytest.approx(1.0)
    assert told["real_time_share"] == pytest.approx(1.0, rel=1e-3)
