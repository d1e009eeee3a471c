"""What the default walk holds without learning, in few walkers; docs/results.md measures it in many."""

import dataclasses
import math

import numpy as np
import pytest

from jaxwalk.learn.policies import named
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest
from jaxwalk.model.burdens import BACKPACK, FRONT_PACK, Burden

USUAL = Burden(0.0, 0.0, 0.0, 0.0, 0.9)
TEST = PushTest(walkers=16, seconds=10.0, impulses=(-80.0, 135.0), phases=16, replicas=1)
HARD = dataclasses.replace(TEST, impulses=(-80.0, 80.0))
LATE = dataclasses.replace(USUAL, delay=0.02, strength=0.8)
GENTLE = dataclasses.replace(TEST, impulses=(-40.0, 40.0))


@pytest.fixture(scope="module")
def programs():
    return evaluation.Programs(TEST)


@pytest.fixture(scope="module")
def walk(programs):
    """(test, speed asked for, burden) -> what became of the walkers; one program for all."""
    return lambda test, speed=1.0, burden=USUAL: evaluation.evaluate(
        named.load("replan", speed=speed), test, programs=programs, burden=burden
    )


def test_it_holds_80_from_the_front_and_135_from_behind_at_every_phase(walk):
    found = walk(TEST)
    assert found["walking"]["survival"] == 1.0
    assert found["walking"]["speed_mean"] == pytest.approx(1.0, abs=0.04)
    assert np.sum(found["pushes"]["survival"]) >= 31  # of 32


def test_who_was_pushed_back_walks_on(walk):
    """And does not step in place for ever."""
    found = walk(dataclasses.replace(TEST, impulses=(-125.0,)))
    assert np.sum(found["pushes"]["steady"]) >= 15  # of 16


@pytest.mark.parametrize(
    "test, burden",
    [(HARD, LATE), (dataclasses.replace(TEST, impulses=(-50.0, 60.0), push_again=1.0), USUAL)],
    ids=["late instruments on weak motors", "a second push"],
)
def test_it_holds_harder_things_at_every_phase(walk, test, burden):
    found = walk(test, burden=burden)
    assert found["walking"]["survival"] == 1.0 and found["walking"]["speed_mean"] > 0.85
    assert np.sum(found["pushes"]["survival"]) >= 31  # of 32


@pytest.mark.parametrize(
    "changes",
    [
        {"slope": math.radians(3)},
        {"slope": math.radians(-3)},
        {"friction": 0.4},
        {"mass": 20.0, "ahead": BACKPACK[0], "up": BACKPACK[1]},
        {"mass": 25.0, "ahead": FRONT_PACK[0], "up": FRONT_PACK[1]},
    ],
    ids=lambda changes: " ".join(changes),
)
def test_it_walks_under_what_it_is_not_told_of(walk, changes):
    found = walk(GENTLE, burden=dataclasses.replace(USUAL, **changes))
    assert found["walking"]["survival"] >= 15 / 16
    assert found["walking"]["speed_mean"] > 0.3
    packed = "mass" in changes  # of whom one in five falls when pushed towards the pack
    assert np.sum(found["pushes"]["survival"]) >= (24 if packed else 28)  # of 32


@pytest.mark.parametrize("speed", [0.65, 1.35])
def test_it_walks_as_fast_as_it_is_asked_to(walk, speed):
    found = walk(GENTLE, speed)
    assert found["walking"]["survival"] == 1.0
    assert found["walking"]["speed_mean"] == pytest.approx(speed, abs=0.07)
