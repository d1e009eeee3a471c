"""Frames put together of messages, and a controller that is asked only what it can answer."""

from __future__ import annotations

import dataclasses
import math

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.deploy import Controller
from jaxwalk.export import command as export
from jaxwalk.ros import making, watch, wire
from jaxwalk.ros.simulation import Simulation
from jaxwalk.ros.watch import OLDEST, Collector
from jaxwalk.ros.wire import PASSIVE, Frame

TICK = 2_000_000  # ns


def frame(nanoseconds: int, **changes) -> Frame:
    told = Frame(nanoseconds, (0.0, 1.0), 0.0, 0.0, 1.0, (0.1,) * 6, (0.0,) * 6, (300.0, 400.0))
    return dataclasses.replace(told, **changes)


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
