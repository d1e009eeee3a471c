"""What the claims make of walks and trials that are known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from jaxwalk.config import Config
from jaxwalk.learn.policies.named import Subject
from jaxwalk.paper.claims import registry
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.trace import Trace, landings
from jaxwalk.paper.verdict import above, below, verdict

DT, STEP, COUNT = 0.002, 200, 12  # s; ticks in a step; steps


def walk(*, peak=0.95, walkers=6, pushed=None, answer=(0.0, 0.0), seed=0):
    """Walkers whose speed is highest at ``peak`` of each step and whose pitch swings by 0.08 rad.

    Pushed at that tick, they choose a step that is longer by ``answer`` (m, s) at the next touch-down.
    """
    rng, ticks = np.random.default_rng(seed), STEP * COUNT
    place = (np.arange(ticks) % STEP) / STEP
    one = np.ones((walkers, 1), np.float32)
    away = np.abs((place - peak + 0.5) % 1.0 - 0.5)
    velocity = one * (1.1 - 0.4 * away) + 0.001 * rng.normal(size=(walkers, 1))
    noise = rng.normal(size=(walkers, ticks, 2))
    raw = np.stack([velocity, 0 * velocity], axis=2) + noise
    smooth = np.stack([velocity, 0 * velocity], axis=2)
    shift, tick = np.zeros((walkers, ticks)), np.arange(ticks)
    if pushed is not None:
        answered = -(-pushed // STEP) * STEP + 5  # a few ticks after the touch-down that follows
        shift[:, (tick >= answered) & (tick < answered + STEP)] = 1.0
    # What is chosen differs a little from step to step and walker to walker.
    own = np.repeat(rng.normal(size=(walkers, COUNT)), STEP, axis=1)
    arrays = {
        "velocity": velocity,
        "raw": raw,
        "mean": smooth + 0.3 * noise,
        "filtered": smooth + 0.1 * noise,
        "pitch": one * (0.09 + 0.04 * np.sin(2 * np.pi * place)),
        "elapsed": one * place * STEP * DT,
        "toe_off": one * np.full(ticks, 0.04),
        "torque": one * np.full(ticks, 80.0),
        "length": 0.6 + 0.001 * own + answer[0] * shift,
        "duration": 0.1 + 0.0001 * own + answer[1] * shift,
    }
    push = np.zeros(ticks, bool)
    if pushed is not None:
        push[pushed : pushed + 50] = True
    flags = {"pushing": one.astype(bool) & push, "fell": np.zeros((walkers, ticks), bool)}
    return Trace(**{name: np.asarray(x, np.float32) for name, x in arrays.items()}, **flags)


class Bench(Lab):
    """A laboratory that has these walks, unpushed and pushed either way; the rest a test sets."""

    def __init__(self, calm, forward=None, backward=None, **asked):
        walks = {0.0: calm, 30.0: forward, -40.0: backward}
        subject = Subject("somebody", Config(), None, lambda params, seen: seen)
        self.quick = True
        self.trace = lambda model, impulse=0.0: walks[impulse]
        self.timestep = lambda model: DT
        self.subject = lambda model: subject
        self.fixed = lambda model: dataclasses.replace(subject, name="fixed")
        vars(self).update(asked)


def test_touch_downs_are_found_until_the_fall():
    trace = walk()
    assert landings(trace, 0).tolist() == list(range(STEP, STEP * COUNT, STEP))
    fell = trace.fell.copy()
    fell[0, 500:] = True
    assert landings(trace.replace(fell=fell), 0).tolist() == [STEP, 2 * STEP]


@pytest.mark.parametrize(("peak", "share"), [(0.95, 1.0), (0.0, 1.0), (0.5, 0.0), (0.05, 0.0)])
def test_a_step_is_fastest_just_before_touch_down_or_not(peak, share):
    numbers = registry()["speed"].measure(Bench(calm=walk(peak=peak)), "planar")
    assert numbers["late"]["mean"] == share
    assert numbers["speed"]["mean"] == pytest.approx(1.0, abs=0.002)
    course = np.array(numbers["course"]["mean"])
    places = np.linspace(-0.5, 0.5, len(course))
    assert abs((places[course.argmax()] - peak + 0.5) % 1.0 - 0.5) < 0.03


def test_who_fell_is_left_out_and_nobody_is_no_number():
    trace = walk(walkers=2)
    fallen = trace.replace(fell=np.ones_like(trace.fell))
    for name in ("speed", "pitch"):
        claim = registry()[name]
        assert verdict(claim.checks(claim.measure(Bench(calm=fallen), "planar"))) == "cannot be told"
        assert claim.draw is not None
        claim.draw({"planar": claim.measure(Bench(calm=fallen), "planar")})


def test_filters_are_told_by_what_they_leave_of_the_change():
    numbers = registry()["filters"].measure(Bench(calm=walk()), "planar")
    # The noise is 1, 0.3 and 0.1 of its size.
    for name in ("velocity", "acceleration"):
        assert numbers[name]["mean_to_raw"]["mean"] == pytest.approx(0.3, abs=0.01)
        assert numbers[name]["filtered_to_mean"]["mean"] == pytest.approx(1 / 3, abs=0.02)
        assert numbers[name]["filtered_to_raw"]["mean"] == pytest.approx(0.1, abs=0.01)
    assert numbers["velocity"]["error"]["filtered"]["mean"] == pytest.approx(0.1, abs=0.01)
    # So much is more than is allowed.
    assert verdict(registry()["filters"].checks(numbers)) == "does not hold"


def test_the_pitch_is_told_from_its_least_to_its_greatest():
    numbers = registry()["pitch"].measure(Bench(calm=walk()), "planar")
    assert numbers["swing"]["mean"] == pytest.approx(0.08, abs=1e-3)
    assert numbers["mean"]["mean"] == pytest.approx(0.09, abs=1e-3)


def test_the_answer_to_a_push_is_the_first_step_chosen_after_it():
    walks = {
        "calm": walk(),
        "forward": walk(pushed=6 * STEP + 30, answer=(0.1, -0.02)),
        "backward": walk(pushed=6 * STEP + 130, answer=(-0.05, 0.03), seed=1),
    }
    claim = registry()["steps"]
    changes = claim.measure(Bench(**walks), "planar")["changes"]
    told = [changes[way][name]["mean"] for way in changes for name in ("length", "duration")]
    assert told == pytest.approx([0.1, -0.02, -0.05, 0.03], abs=2e-3)
    assert above(changes["forward"]["length"]) and below(changes["forward"]["duration"])


def test_the_parts_of_the_step_are_pushed_at_their_own_moments():
    pushed = {}

    def scenarios(subject, impulse, phase):
        pushed.update(impulse=impulse, phase=phase)

    # Whoever is pushed in toe-off, 0.04 s of 0.4, stays up.
    bench = Bench(calm=walk(), scenarios=scenarios, pushed=lambda *_: {"up": pushed["phase"] < 0.1})
    claim = registry()["phases"]
    numbers = claim.measure(bench, "planar")
    assert numbers["parts"]["toe-off"] == pytest.approx([0.0, 0.1])
    assert numbers["parts"]["swing"] == pytest.approx([0.1, 0.35], abs=1e-3)
    assert {p: x["mean"] for p, x in numbers["ways"]["both ways"].items()} == {"toe-off": 1.0, "swing": 0.0}
    assert verdict(claim.checks(numbers)) == "holds" and len(claim.table(numbers)) == 8 * 2 * 4


def exam(pushed, calm=1.0, speed=1.0):
    up = np.arange(48) < 48 * pushed
    told = {"mean": pushed, "low": pushed - 0.05, "high": pushed + 0.05, "n": 48}
    rest = {"speed": {**told, "mean": speed}, "speeds": [speed, speed + 0.01], "survived": up.tolist()}
    return {"calm": {**told, "mean": calm}, "pushed": told, **rest}


def test_each_controller_is_taken_away_alone():
    asked = {}

    def examined(subject, model, numbers, what):
        asked[what] = subject, numbers
        return exam(0.9 if what == "all three" else 0.3)

    bench = Bench(calm=walk(), exam=examined)
    claim, own = registry()["controllers"], Config().gait
    numbers = claim.measure(bench, "planar")
    assert asked["all three"][1] == own and asked["step never adapted"][0].name == "fixed"
    changes = {
        what: {name: x for name, x in vars(found).items() if x != getattr(own, name)}
        for what, (_, found) in asked.items()
        if found is not None
    }
    assert changes["no stance control"] == {"stance_rate_max": 0.0}
    assert changes["no toe-off"] == {"toe_off_gain": 0.0}
    # Frozen, toe-off is what it usually is, at any speed.
    constant = changes["toe-off frozen"]
    torque = [constant["toe_off_gain"] * (constant["toe_off_speed"] - speed) for speed in (0.5, 1.5)]
    assert torque == pytest.approx([80.0, 80.0], abs=0.05)
    assert verdict(claim.checks(numbers)) == "holds"


def test_the_sweeps_are_of_one_number_each():
    asked = []

    def examined(subject, model, numbers=None, what=""):
        speed = subject.config.gait.speed_desired if numbers is None else numbers.speed_desired
        damping = subject.config.physics.ankle_damping
        asked.append((speed, damping))
        # Faster and less robust with more of the one and less of the other.
        fast = speed - 1.0 - 0.1 * (damping - 1.0)
        return exam(0.6 - fast, speed=1.0 + fast)

    claim = registry()["trade"]
    numbers = claim.measure(Bench(calm=walk(), exam=examined), "planar")
    assert asked == [(0.8, 1.0), (1.0, 1.0), (1.2, 1.0), (1.0, 0.25), (1.0, 1.0), (1.0, 4.0)]
    assert verdict(claim.checks(numbers)) == "holds"


@pytest.mark.slow
def test_a_real_walk_is_traced_and_examined(tmp_path):
    real = Lab("fixed", tmp_path, True, 0)
    calm = real.trace("planar")
    # Unpushed walkers touch down every half second or so, and never fall.
    assert not calm.fell.any() and calm.velocity.shape == (24, 4 / DT)
    assert all(4 < len(landings(calm, walker)) < 14 for walker in range(24))
    assert 0.95 < calm.velocity.mean() < 1.05 and not calm.pushing.any()
    # What is measured is the truth with noise; filters take it off.
    errors = [np.std(stage[..., 0] - calm.velocity) for stage in (calm.raw, calm.mean, calm.filtered)]
    assert 0.02 < errors[0] < 0.05 and errors[2] < 0.05
    pushed = real.trace("planar", 30.0)
    assert (pushed.pushing.sum(axis=1) == 50).all()
    exam = real.exam(real.fixed("planar"), "planar")
    assert (
        exam["calm"]["mean"] == 1.0 and len(exam["survived"]) == 48 and 0.05 < exam["pushed"]["mean"] < 0.95
    )
    # Without toe-off nobody keeps walking as fast.
    config = real.fixed("planar").config
    weak = real.exam(real.fixed("planar"), "planar", dataclasses.replace(config.gait, toe_off_gain=0.0))
    assert weak["calm"]["mean"] < 0.5 or weak["speed"]["mean"] < exam["speed"]["mean"] - 0.1
