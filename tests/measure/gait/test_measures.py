"""Figures of a made-up walk that can be worked out by hand."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.measure.gait import energy, measures, signals
from jaxwalk.measure.gait.forces import Forces
from jaxwalk.measure.gait.measures import Measured
from jaxwalk.measure.gait.record import Ticks
from jaxwalk.measure.gait.strides import Cycle

DT, MASS = 0.01, 50.0
WEIGHT = MASS * 9.81
CYCLE = Cycle(side=0, start=100, stop=200, toe_off=160, other=150, double_support=0.2)


@pytest.fixture(scope="module")
def walk():
    """1 m/s; knee: 0.2 rad at 10 %, 1 rad at 75 % of the cycle; ankle pushes 60 N m at 2 rad/s.

    The body's weight rests on the left foot for 0..50 % of each cycle, then on the right one.
    """
    tick = np.arange(400)
    phase = np.stack([tick % 100, (tick + 50) % 100], axis=1) / 100
    joints = np.zeros((400, 2, 3))
    joints[..., 0] = 0.3 * np.cos(2 * np.pi * phase)
    joints[..., 1] = 0.2 * (np.abs(phase - 0.1) < 0.02) + 1.0 * (np.abs(phase - 0.75) < 0.02)
    torque, rates = np.zeros((400, 2, 3)), np.zeros((400, 2, 3))
    pushes = (phase > 0.395) & (phase < 0.595)  # 20 ticks: 60 N m x 2 rad/s x 0.2 s = 24 J a stride
    torque[..., 2], rates[..., 2] = -60.0 * pushes, -2.0 * pushes
    torque[..., 0], rates[..., 0] = 10.0, -1.0 * pushes  # the hip takes 10 W x 0.2 s = 2 J
    ground = np.zeros((400, 2, 2))
    ground[..., 1] = WEIGHT * (phase < 0.5)
    # Feet move 1 m with each stride, the right one half a stride later; 0.45 m ahead where it lands.
    stride = np.floor(np.stack([tick / 100, (tick - 50) / 100], axis=1))
    told = Forces(
        torque=jnp.asarray(torque),
        damping=jnp.asarray(1.5 * pushes),  # against 2 rad/s of plantarflexion: 3 W x 0.2 s = 0.6 J
        rates=jnp.asarray(rates),
        ground=jnp.asarray(ground),
        contact_power=jnp.full(400, -7.0),
    )
    return Ticks(
        pitch=jnp.full(400, 0.1),
        joints=jnp.asarray(joints),
        ankle_x=jnp.asarray(stride + [0.0, 0.45]),
        forces=told,
        fell=jnp.zeros(400, bool),
    )


@pytest.fixture(scope="module")
def figures(walk):
    return measures.of_cycle(walk, signals.of_walker(walk, DT, MASS), CYCLE, DT, MASS)


def test_every_figure_is_told(figures):
    assert set(figures) == set(measures.UNITS)


def test_steps_and_times(figures):
    told = {
        "speed": 1.0, "cadence": 120.0, "stride_length": 1.0, "stride_time": 1.0, "step_time": 0.5,
        # The left foot lands 1 m ahead of its old place, 0.55 m ahead of the right one.
        "step_length": 0.55, "stance_share": 60.0, "double_support_share": 20.0,
    }  # fmt: skip
    assert {name: figures[name] for name in told} == pytest.approx(told, abs=1e-6)


def test_angles_in_degrees(figures):
    degree = np.degrees(1.0)  # the hip's are the thigh's to the vertical, the torso being at 0.1
    told = {
        "hip_flexion_peak": 0.2 * degree, "hip_extension_peak": -0.4 * degree, "hip_excursion": 0.6 * degree,
        "knee_flexion_loading": 0.2 * degree, "knee_flexion_swing": degree,
        "torso_pitch_mean": 0.1 * degree, "torso_pitch_excursion": 0.0,
    }  # fmt: skip
    assert {name: figures[name] for name in told} == pytest.approx(told, abs=1e-4)


def test_work_against_weight_and_way(figures):
    """Two legs a stride: 24 J given by each ankle, 2 J taken by each hip; 50 kg over 1 m."""
    told = {
        "cost_of_transport": 48 / WEIGHT, "cost_of_transport_net": 44 / WEIGHT,
        "ankle_work_positive": 48 / WEIGHT, "ankle_work_negative": 0.0, "hip_work_negative": 4 / WEIGHT,
        "knee_work_positive": 0.0, "damping_loss": 1.2 / WEIGHT, "contact_loss": 7 / WEIGHT,
        # The hip takes 10 W while the ankle of its own leg gives 120.
        "cost_of_transport_by_leg": 44 / WEIGHT, "swing_work_share": 0.0,
    }  # fmt: skip
    assert {name: figures[name] for name in told} == pytest.approx(told, rel=1e-5)
    # The passive ankle takes 3 W of the 120, and the filter rings around a rectangle.
    assert figures["cost_of_transport_filtered"] == pytest.approx(46.8 / WEIGHT, rel=0.05)


def test_work_in_the_air_is_told_apart(walk):
    """Half the ankle's push falls after a toe-off at 49.5 % of the cycle."""
    early = dataclasses.replace(CYCLE, toe_off=150)
    told = energy.of_cycle(walk, signals.of_walker(walk, DT, MASS), early, 1.0, DT, MASS)
    assert told["swing_work_share"] == pytest.approx(50.0)


def test_a_spike_is_told_by_its_height_its_filtered_height_and_its_impulse(walk):
    """10 kN for one tick of 2 ms at touch-down, on top of the body's weight."""
    timestep, size = 0.002, 1e4 / WEIGHT
    ground = np.repeat(np.asarray(walk.forces.ground), 5, axis=0)
    ground[500::500, 0, 1] += 1e4
    long = jax.tree.map(lambda x: jnp.asarray(np.repeat(np.asarray(x), 5, axis=0)), walk)
    long = long.replace(forces=long.forces.replace(ground=jnp.asarray(ground)))
    cycle = Cycle(side=0, start=500, stop=1000, toe_off=800, other=750, double_support=0.2)
    told = measures.of_cycle(long, signals.of_walker(long, timestep, MASS), cycle, timestep, MASS)
    assert told["impact_peak"] == pytest.approx(1 + size, rel=1e-4)
    assert told["impact_impulse"] == pytest.approx(0.02 + size * timestep, rel=1e-4)
    # The filter's gain is 1 / (1 + (f / 62 Hz)^4): its integral over f, 138 / s, times the impulse; the
    # step of the body's weight adds its half.
    assert told["impact_peak_50_hz"] == pytest.approx(0.5 + 138 * size * timestep, rel=0.05)
    assert told["vertical_loading_peak"] < 0.5 * told["impact_peak_50_hz"]


def test_signs_of_moments_and_powers(walk, figures):
    told = signals.of_walker(walk, DT, MASS)
    push = 50  # per cent: in the middle of the push
    # Plantarflexion is positive; the damping of 1.5 N m works against the 60.
    assert told["ankle_moment"][CYCLE.start + push, 0] == pytest.approx(58.5 / MASS, rel=0.02)
    assert told["ankle_power"][CYCLE.start + push, 0] == pytest.approx(2 * 58.5 / MASS, rel=0.02)
    assert told["hip_moment"][CYCLE.start + push, 0] == pytest.approx(-10 / MASS)  # a flexor one
    assert figures["hip_flexor_moment"] == pytest.approx(10 / MASS)
    # What is filtered rings: the peaks of a rectangle overshoot by a tenth.
    assert figures["ankle_power_generated"] == pytest.approx(2 * 58.5 / MASS, rel=0.15)
    assert figures["impact_peak"] == pytest.approx(1.0)  # unfiltered


def test_the_filter_keeps_means_and_halves_the_power_at_its_cutoff():
    seconds = np.arange(0, 4, 0.002)
    wave = np.sin(2 * np.pi * signals.CUTOFF * seconds)
    passed = signals.low_pass(3.0 + wave, 0.002)
    assert passed.mean() == pytest.approx(3.0, abs=1e-3)
    middle = passed[500:1500] - 3.0
    assert np.sqrt(2) * middle.std() == pytest.approx(np.sqrt(0.5), rel=0.02)
    # No lag: the wave is the same, only smaller.
    assert np.corrcoef(middle, wave[500:1500])[0, 1] == pytest.approx(1.0, abs=1e-3)
    slow = np.sin(2 * np.pi * seconds)
    np.testing.assert_allclose(signals.low_pass(slow, 0.002)[500:1500], slow[500:1500], atol=0.01)


@pytest.mark.parametrize(
    ("left", "right", "index"), [(1.0, 1.0, 0.0), (1.1, 0.9, 20.0), (0.9, 1.1, -20.0), (3.0, 1.0, 100.0)]
)
def test_robinson_s_symmetry_index(left, right, index):
    assert measures.symmetry_index(left, right) == pytest.approx(index)


def measured(cells: list[tuple[int, int, float]]):
    """Cycles from (walker, side, value of every figure)."""
    return Measured.of([(w, side, dict.fromkeys(measures.UNITS, value)) for w, side, value in cells])


def test_symmetry_is_each_walker_s_own():
    # Walker 1 limps to the left by 20 %, walker 2 to the right: together they look symmetric.
    told = measures.symmetry(measured([(1, 0, 1.2), (1, 0, 1.0), (1, 1, 0.9), (2, 0, 0.9), (2, 1, 1.1)]))
    assert told["step_length"] == pytest.approx({"mean": 0.0, "mean_size": 20.0})


def test_symmetry_leaves_out_who_has_one_side_only():
    told = measures.symmetry(measured([(1, 0, 1.1), (1, 1, 0.9), (2, 0, 5.0)]))
    assert told["step_time"] == pytest.approx({"mean": 20.0, "mean_size": 20.0})


def test_summary_over_strides_and_sides():
    told = measures.summary(measured([(1, 0, 1.0), (1, 1, 3.0), (2, 0, 3.0), (2, 1, 5.0)]))["speed"]
    assert told == {"unit": "m/s", "mean": 3.0, "sd": pytest.approx(np.sqrt(2)), "left": 2.0, "right": 4.0}
