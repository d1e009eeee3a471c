"""What the nodes are made of, without ROS: files, frames, safety, whose commands count, and loads."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.deploy import Controller
from jaxwalk.export import command as export
from jaxwalk.ode import library
from jaxwalk.ros import body as bodies
from jaxwalk.ros import command, loop, making, parameters, watch, wire
from jaxwalk.ros.inbox import Inbox
from jaxwalk.ros.measures import Record
from jaxwalk.ros.simulation import Simulation, unfit
from jaxwalk.ros.watch import OLDEST, Collector, Keeper
from jaxwalk.ros.wire import PASSIVE, Frame

try:
    library.load()
except UserError as missing:
    pytest.skip(str(missing), allow_module_level=True)

TICK = 2_000_000  # ns


@pytest.fixture(scope="module")
def body():
    return making.body(Config(), 0)


def frame(nanoseconds: int, **changes) -> Frame:
    told = Frame(nanoseconds, (0.0, 1.0), 0.0, 0.0, 1.0, (0.1,) * 6, (0.0,) * 6, (300.0, 400.0))
    return dataclasses.replace(told, **changes)


class Counting(Controller):
    """Says how often it has been asked since it began."""

    def __init__(self):
        self.asked, self.passive = 0, False

    @property
    def fallen(self):
        return False

    def start(self, said, stance):
        self.asked = 0
        return np.full(6, 100.0 + stance)

    def tick(self, said):
        self.asked += 1
        return np.full(6, float(self.asked))


@pytest.fixture
def said():
    return []


@pytest.fixture
def keeper(said):
    return Keeper(Counting(), 1, said.append)


def test_a_body_is_read_as_it_was_written(body, tmp_path):
    (tmp_path / "body.json").write_text(bodies.text(body))
    again = bodies.read(tmp_path / "body.json")
    assert bodies.text(again) == bodies.text(body)
    assert all((getattr(again, name) == getattr(body, name)).all() for name in ("qpos", "qvel", "touch"))
    assert body.joints == ("hip_left", "knee_left", "ankle_left", "hip_right", "knee_right", "ankle_right")


@pytest.mark.parametrize("broken", ["[]", "{", "tree", "start", "mass", "stance", "foot"])
def test_a_damaged_body_is_told_in_one_line(body, tmp_path, broken):
    told = json.loads(bodies.text(body))
    if broken in told:
        del told[broken]
    told.get("tree", {}).update({"mass": [1.0]} if broken == "mass" else {})
    told.get("tree", {}).update({"foot": [3, 3, 6, 9]} if broken == "foot" else {})
    told.get("start", {}).update({"stance": 2} if broken == "stance" else {})
    text = broken if broken in ("[]", "{") else json.dumps(told)
    (tmp_path / "body.json").write_text(text)
    with pytest.raises(UserError, match=r"give the body\.json that jaxwalk ros writes"):
        bodies.read(tmp_path / "body.json")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("parent", lambda told: [-2, *told[1:]]),
        ("parent", lambda told: [told[0], -1, *told[2:]]),
        ("driven", lambda told: [0, *told[1:]]),
        ("driven", lambda told: [told[1], *told[1:]]),
        ("turn", lambda told: [0.5, *told[1:]]),
        ("imu", lambda told: [*told, 0.0]),
        ("imu", lambda told: [told]),
        ("soles", lambda told: told[:1]),
        ("anchor", lambda told: [[*row, 0.0] for row in told]),
        ("mass", lambda told: [[one] for one in told]),
        ("mass", lambda told: [1e-10, *told[1:]]),
        ("inertia", lambda told: [1e-10, *told[1:]]),
        ("damping", lambda told: [*told[:-1], -0.1]),
        ("friction", lambda told: -0.1),
        ("timestep", lambda told: 0.02),
        ("timestep", lambda told: 1e-5),
    ],
)
def test_a_tree_that_ode_cannot_hold_is_told_in_one_line(body, tmp_path, name, value):
    told = json.loads(bodies.text(body))
    told["tree"][name] = value(told["tree"][name])
    (tmp_path / "body.json").write_text(json.dumps(told))
    with pytest.raises(UserError, match="not of a body"):
        bodies.read(tmp_path / "body.json")


@pytest.mark.parametrize(
    "names",
    [
        ["a"] * 6,
        ["a", "b", "c", "d", "e"],
        ["a", "b", "c", "d", "e", "f g"],
        ["", *"bcdef"],
        [*"abcde", "/f"],
    ],
)
def test_joints_are_six_names_for_topics(body, tmp_path, names):
    told = json.loads(bodies.text(body)) | {"joints": names}
    (tmp_path / "body.json").write_text(json.dumps(told))
    with pytest.raises(UserError, match="not of a body"):
        bodies.read(tmp_path / "body.json")


def test_five_joints_are_none_even_where_all_parts_agree(body, tmp_path):
    told = json.loads(bodies.text(body))
    for name in ("driven", "gain", "offset", "rate", "limit"):
        told["tree"][name].pop()
    told["joints"].pop()
    (tmp_path / "body.json").write_text(json.dumps(told))
    with pytest.raises(UserError, match="not of a body"):
        bodies.read(tmp_path / "body.json")


@pytest.mark.parametrize("said", [b"", b"garbage\n", b"<a>", b"<methodResponse></methodResponse>"])
def test_what_is_no_master_does_not_answer(monkeypatch, said):
    monkeypatch.setattr(command, "_ANSWERING", 0.3)
    raw = said == b"garbage\n"
    head = b"HTTP/1.0 200 OK\r\nContent-Type: text/xml\r\nContent-Length: %d\r\n\r\n" % len(said)
    done = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            # xmlrpc asks a second time where it was hung up on.
            with contextlib.suppress(OSError):
                while True:
                    one, _ = server.accept()
                    with one:
                        one.recv(4096)
                        if not said:
                            done.wait(60.0)  # takes the call and is silent
                        one.sendall(said if raw else head + said)

        threading.Thread(target=serve, daemon=True).start()
        begun = time.monotonic()
        assert not command.answers(f"http://127.0.0.1:{server.getsockname()[1]}")
        assert time.monotonic() - begun < 30.0
        done.set()
        server.shutdown(socket.SHUT_RDWR)


@pytest.mark.parametrize(
    "address", ["nonsense", "ftp://a", "http://127.0.0.1:port", "http://[", "http://127.0.0.1:1"]
)
def test_what_is_no_address_does_not_answer(address):
    assert not command.answers(address)


def test_only_planar_legs_that_yield_are_spoken_to():
    with pytest.raises(UserError, match="joints are told torques"):
        making.body(PRESETS["rigid"], 0)
    with pytest.raises(UserError, match="moves planar walkers"):
        making.body(dataclasses.replace(Config(), body=BodyConfig(model="walls")), 0)


def told_of(one: Frame) -> dict[str, dict]:
    return {
        wire.IMU: dict(pitch=one.pitch, pitch_rate=one.pitch_rate, acceleration=one.acceleration),
        wire.VELOCITY: dict(velocity=one.velocity),
        wire.JOINTS: dict(joints=one.joints, joint_rates=one.joint_rates),
        **{foot: dict(touch=force) for foot, force in zip(wire.FEET, one.touch, strict=True)},
    }


def test_frames_are_put_together_in_any_order_and_none_is_made_of_two_times():
    collector, first, second = Collector(), frame(TICK), frame(2 * TICK, velocity=2.0)
    parts, later = list(told_of(first).items()), list(told_of(second).items())
    assert not any(collector.take(topic, 2 * TICK, values) for topic, values in later[:3])
    assert not any(collector.take(topic, TICK, values) for topic, values in reversed(parts[1:]))
    assert collector.take(parts[0][0], TICK, parts[0][1]) == first
    assert [collector.take(topic, 2 * TICK, values) for topic, values in later[3:]] == [None, second]
    # What has gone by is left out; a message that is lost costs its frame alone.
    assert not any(collector.take(topic, TICK, values) for topic, values in parts)
    third = frame(4 * TICK)
    assert not any(collector.take(topic, 3 * TICK, values) for topic, values in parts[:4])
    assert [collector.take(topic, 4 * TICK, values) for topic, values in told_of(third).items()][-1] == third


def test_a_simulation_that_begins_again_is_followed():
    collector = Collector()
    for stamp in (0, TICK, 0):
        assert [collector.take(topic, stamp, x) for topic, x in told_of(frame(stamp)).items()][-1] == frame(
            stamp
        )


def test_the_controller_is_asked_once_a_frame_from_the_start_on(keeper, said):
    assert [keeper.answer(frame(n * TICK))[0] for n in range(3)] == [101.0, 1.0, 2.0]
    assert keeper.answer(frame(0))[5] == 101.0 and keeper.answer(frame(TICK))[5] == 1.0
    assert said == []


def taken(collector, one: Frame, topics=wire.SENSORS) -> list[Frame]:
    """Frames that come of what ``topics`` say of ``one``."""
    told = told_of(one)
    made = [collector.take(topic, one.nanoseconds, told[topic]) for topic in topics]
    return [made_one for made_one in made if made_one is not None]


def test_a_second_frame_0_is_a_new_beginning():
    collector, first, second = Collector(), frame(0), frame(0, velocity=2.0)
    assert taken(collector, first) == [first]
    assert taken(collector, second) == [second]


def test_nothing_of_the_walk_before_gets_into_the_new_one():
    collector, old = Collector(), frame(TICK, velocity=9.0)
    before, after = wire.SENSORS[:2], wire.SENSORS[2:]
    assert taken(collector, frame(0)) == [frame(0)]
    assert taken(collector, old, before) == []
    # These have begun again; what the others had to say of the walk before comes only now.
    assert taken(collector, frame(0), before) == [] and taken(collector, old, after) == []
    assert taken(collector, frame(0), after) == [frame(0)]
    assert taken(collector, frame(TICK), reversed(wire.SENSORS)) == [frame(TICK)]


def test_a_topic_that_lags_behind_at_the_start_is_waited_for():
    collector, ahead, lags = Collector(), wire.SENSORS[:4], wire.SENSORS[4:]
    assert taken(collector, frame(0), ahead) == taken(collector, frame(TICK), ahead) == []
    assert [*taken(collector, frame(0), lags), *taken(collector, frame(TICK), lags)] == [
        frame(0),
        frame(TICK),
    ]


def test_a_topic_whose_0_was_lost_is_heard_again_and_joints_are_passive(keeper, said):
    collector = Collector()
    keeper.answer(*taken(collector, frame(0)))
    keeper.answer(*taken(collector, frame(TICK)))
    assert taken(collector, frame(0), wire.SENSORS[1:]) == []
    found = [one for n in range(1, 20) for one in taken(collector, frame(n * TICK))]
    assert found and found[-1] == frame(19 * TICK)
    assert keeper.answer(found[0]) is PASSIVE and "under way" in said[0]


@pytest.mark.parametrize(
    ("next_one", "why"),
    [
        (frame(TICK, velocity=math.nan), "not a number"),
        (frame(TICK, touch=(math.inf, 0.0)), "not a number"),
        (frame(TICK, pitch=(0.0, 0.0)), "not a number"),
        (frame(TICK, joint_rates=()), "no answer: cannot reshape"),
        (frame(OLDEST + TICK), "no sensors for more than 20 ms"),
    ],
)
def test_it_rests_for_good_and_says_so_once_until_the_simulation_begins_again(keeper, said, next_one, why):
    keeper.answer(frame(0))
    assert keeper.answer(next_one) is PASSIVE
    after = next_one.nanoseconds + TICK
    assert keeper.answer(frame(after)) is PASSIVE and not keeper.watch(after + 2 * OLDEST)
    assert len(said) == 1 and why in said[0]
    assert keeper.answer(frame(0))[0] == 101.0


@pytest.fixture(scope="module")
def policy(tmp_path_factory):
    """The file of the policy that is shipped."""
    trained, manifest = export.load("shipped")
    return export.write(trained, manifest, ("safetensors",), tmp_path_factory.mktemp("policy"))["safetensors"]


@pytest.fixture
def shipped(policy, body, said):
    return Keeper(Controller.load(policy), body.stance, said.append)


@pytest.mark.parametrize(
    ("change", "least", "why"),
    [
        ({"pitch_rate": 5e3}, 11, "what cannot be true"),  # for 20 ms the last that could be stands for it
        ({"pitch": wire.turned(1.5)}, 1, "has fallen"),
    ],
)
def test_what_lets_the_controller_go_is_the_safe_state(shipped, said, body, change, least, why):
    one = Simulation(body).frame
    for beginning in (1, 2):
        assert shipped.answer(one) is not PASSIVE
        told = [
            shipped.answer(dataclasses.replace(one, nanoseconds=n * TICK, **change)) for n in range(1, 16)
        ]
        assert [row is PASSIVE for row in told] == [n >= least for n in range(1, 16)] and shipped.safe
        assert len(said) == beginning and why in said[-1]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"pitch_rate": 5e3}, "what cannot be true"),
        ({"joints": (20.0,) * 6}, "give radians"),
        ({"joints": (0.1,) * 5}, "no answer"),
    ],
)
def test_a_first_frame_that_cannot_be_is_the_safe_state(shipped, said, body, change, why):
    one = Simulation(body).frame
    assert shipped.answer(dataclasses.replace(one, **change)) is PASSIVE
    assert shipped.answer(dataclasses.replace(one, nanoseconds=TICK)) is PASSIVE
    assert len(said) == 1 and why in said[0]


def test_a_message_that_is_none_is_the_safe_state_and_said_once(keeper, said):
    keeper.answer(frame(0))
    assert keeper.refuse("other joints") is PASSIVE and keeper.refuse("other joints") is PASSIVE
    assert keeper.answer(frame(TICK)) is PASSIVE
    assert said == ["safe state, joints are passive: other joints"]
    assert keeper.answer(frame(0)) is not PASSIVE


def test_joints_states_are_of_the_walkers_joints_in_their_order():
    names, angles, rates = ("a", "b"), [1.0, 2.0], [3.0, 4.0]
    assert wire.states(names, ["a", "b"], angles, rates) == {"joints": (1.0, 2.0), "joint_rates": (3.0, 4.0)}
    for wrong in ((["b", "a"], angles, rates), ([], [], []), (["a", "b"], angles, []), (["a"], [1.0], [3.0])):
        with pytest.raises(ValueError, match=wire.JOINTS):
            wire.states(names, *wrong)


@pytest.mark.parametrize("angle", [-3.1, -1.0, 0.0, 0.2, 3.0, math.pi])
def test_a_quaternion_and_its_negative_are_one_pitch(angle):
    y, w = wire.turned(angle)
    assert wire.pitch(y, w) == pytest.approx(angle, abs=1e-15) and wire.pitch(-y, -w) == wire.pitch(y, w)


def test_half_a_turn_is_positive():
    assert wire.pitch(-1.0, 0.0) == wire.pitch(1.0, 0.0) == wire.pitch(1.0, -0.0) == math.pi


def test_silence_is_noticed_by_the_clock(keeper, said):
    assert not keeper.watch(10 * OLDEST)  # nothing has begun
    keeper.answer(frame(0))
    keeper.answer(frame(TICK))
    assert not keeper.watch(TICK + OLDEST) and said == []
    assert keeper.watch(TICK + OLDEST + 1) and keeper.safe
    assert "no sensors" in said[0]


def test_who_comes_late_lets_the_joints_be(keeper, said):
    assert keeper.answer(frame(5 * TICK)) is PASSIVE
    assert "under way" in said[0]


def give(inbox, values, sender="/one"):
    for joint, value in enumerate(values):
        inbox.put(joint, value, sender)


def test_a_command_is_for_one_frame_and_complete_or_passive(said):
    inbox = Inbox(6, said.append)
    inbox.open(0)
    give(inbox, range(6))
    assert inbox.wait(0.0) == (0, 1, 2, 3, 4, 5) and math.isfinite(inbox.latency)
    inbox.open(TICK)
    give(inbox, range(5))
    assert inbox.wait(0.0) is PASSIVE
    assert said == ["no command within 0 s: joints are passive"]
    inbox.open(2 * TICK)
    give(inbox, [7.0] * 6, "/two")  # the first is lost: another may take over
    assert inbox.wait(0.0) == (7.0,) * 6


def test_a_second_controller_is_left_out(said):
    inbox = Inbox(6, said.append)
    inbox.open(0)
    inbox.put(0, 1.0, "/one")
    give(inbox, [9.0] * 6, "/two")
    give(inbox, [1.0] * 6, "/one")
    give(inbox, [9.0] * 6, "/two")
    assert inbox.wait(0.0) == (1.0,) * 6
    assert said == ["commands of /two are left out: /one controls the walker"]


def test_in_real_time_no_command_is_held_for_longer_than_20_ms(said):
    inbox = Inbox(6, said.append)
    assert inbox.newest(0) is PASSIVE and said == []
    inbox.open(0)
    give(inbox, [3.0] * 6)
    assert inbox.newest(OLDEST) == (3.0,) * 6
    assert inbox.newest(OLDEST + 1) is PASSIVE and inbox.newest(OLDEST + 2) is PASSIVE
    assert len(said) == 1 and "no command for more than 20 ms" in said[0]


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
    assert one.finite and not frame(0, pitch=(math.nan, 1.0)).finite


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


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"bodi": "x"}, "unknown parameter bodi: give some of body, method"),
        ({}, "parameter body is missing"),
        ({"body": "x", "lockstep": "yes"}, "parameter lockstep: 'yes' is no bool"),
        ({"body": 3}, "parameter body: 3 is no str"),
        ({"body": "x", "factor": True}, "parameter factor: True is no float"),
        (
            {"body": "x", "factor": 0.0},
            "node: parameter factor: 0.0 is out of range: give more than 0, finite",
        ),
        ({"body": "x", "factor": math.inf}, "parameter factor: inf is out of range"),
        ({"body": "x", "factor": math.nan}, "parameter factor: nan is out of range"),
        ({"body": "x", "factor": 10**400}, "parameter factor: 1000"),
        ({"body": "x", "method": "fast"}, "parameter method: 'fast' is out of range: give world or quick"),
        ({"body": "x", "patience": 0}, "parameter patience: 0 is out of range"),
        ({"body": "x", "seconds": -1.0}, "parameter seconds: -1.0 is out of range: give 0 or more, finite"),
        ({"body": "x", "listeners": 0}, "parameter listeners: 0 is out of range: give 1 or more"),
        (
            {"body": "x", "report": "/nowhere/at/all.json"},
            "node: parameter report /nowhere/at/all.json: there is",
        ),
        ({"body": "x", "report": "/tmp"}, "node: parameter report /tmp: is a folder"),
    ],
)
def test_parameters_that_are_no_good_are_named(told, said):
    with pytest.raises(UserError, match=said):
        parameters.read(parameters.Simulated, told, "node")


@pytest.mark.parametrize(
    ("kind", "told", "said"),
    [
        (parameters.Controlled, {"delay": 0.05}, "delay: 0.05 is out of range: give 0 or more, 0.04 at most"),
        (parameters.Controlled, {"factor": -1.0}, "factor: -1.0 is out of range"),
        (
            parameters.Controlled,
            {"commands": "/nowhere/at/all"},
            "commands /nowhere/at/all: there is no folder",
        ),
        (parameters.Pushed, {"impulse": math.inf}, "impulse: inf is out of range: give a finite number"),
        (parameters.Pushed, {"begin": -0.1}, "begin: -0.1 is out of range"),
        (parameters.Pushed, {"seconds": 0.0}, "seconds: 0.0 is out of range"),
        (parameters.Pushed, {"patience": 0.0}, "patience: 0.0 is out of range"),
    ],
)
def test_ranges_of_the_other_nodes(kind, told, said):
    needed = {
        parameters.Controlled: {"policy": "p", "body": "b"},
        parameters.Pushed: {"impulse": 1, "begin": 0},
    }
    assert parameters.read(kind, needed[kind], "node")
    with pytest.raises(UserError, match=f"node: parameter {said}"):
        parameters.read(kind, needed[kind] | told, "node")


def test_a_policy_that_does_not_fit_the_body_is_refused(policy, body, tmp_path):
    controller = Controller.load(policy)
    watch.check(controller, body, "policy", "body.json")
    slower = dataclasses.replace(body, tree=dataclasses.replace(body.tree, timestep=0.004))
    with pytest.raises(UserError, match=r"body\.json: ticks of 0\.004 s, but the policy's are of 0\.002 s"):
        watch.check(controller, slower, "policy", "body.json")
    trained, manifest = export.load("shipped-rigid")
    rigid = export.write(trained, manifest, ("safetensors",), tmp_path)["safetensors"]
    with pytest.raises(UserError, match="policy rigid: joints are told torques"):
        watch.check(Controller.load(rigid), body, "rigid", "body.json")


@pytest.mark.parametrize("told", [[], ["nobody_node"], ["../node"], ["two\nlines"]])
def test_the_packages_program_names_the_nodes(told):
    program = Path(command.__file__).parent / "package" / "node"
    done = subprocess.run([sys.executable, program, *told], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("give one of controller_node, push_node, simulation_node\n")
    assert len(done.stderr.splitlines()) == 1


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
