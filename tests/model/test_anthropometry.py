"""The generated body is the person that the anthropometric tables describe."""

import mujoco
import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import anthropometry, mjcf

SEGMENTS = ("torso", "thigh", "shank", "foot")

# Winter at 75 kg and 1.8 m, worked by hand: mass = fraction M; length = fraction H; COM = share of
# the length (torso: of hip to shoulder, 0.288 H = 0.5184 m); inertia = mass (gyration length)^2.
# name: mass kg, length m, COM (x, z) from the proximal joint m, inertia about the COM kg m^2.
WINTER = {
    "torso": (50.85, 0.8460, (0.0, 0.32452), 3.3619),  # 0.626 x 0.5184; 50.85 (0.496 x 0.5184)^2
    "thigh": (7.5, 0.4410, (0.0, -0.19095), 0.15217),  # 0.433 x 0.441; 7.5 (0.323 x 0.441)^2
    "shank": (3.4875, 0.4428, (0.0, -0.19173), 0.06237),  # 0.433 x 0.4428; 3.4875 (0.302 x 0.4428)^2
    "foot": (1.0875, 0.0702, (0.045, -0.0351), 0.01837),  # 1.0875 (0.475 x 0.152 x 1.8)^2
}


@pytest.mark.parametrize("name", SEGMENTS)
def test_segments_are_winters(name):
    segment = getattr(anthropometry.build(BodyConfig()), name)
    mass, length, com, inertia = WINTER[name]
    # 5e-4: the hand-worked figures carry four digits.
    assert segment.mass == pytest.approx(mass, rel=5e-4)
    assert segment.length == pytest.approx(length, rel=5e-4)
    assert segment.com == pytest.approx(com, rel=5e-4)
    assert segment.inertia == pytest.approx(inertia, rel=5e-4)


def test_the_torso_is_as_hard_to_turn_about_the_hip_as_the_tables_say():
    def about_hip(table):
        torso = anthropometry.build(BodyConfig(table=table)).torso
        return torso.inertia + torso.mass * torso.com[1] ** 2

    # Winter: 3.362 + 50.85 x 0.3245^2 = 8.72. Box: m h^2 / 3 = 50.85 x 0.846^2 / 3 = 12.13.
    assert about_hip("winter") == pytest.approx(8.72, abs=0.005)
    assert about_hip("box") == pytest.approx(12.13, abs=0.005)


def test_boxes_are_uniform():
    built = anthropometry.build(BodyConfig(table="box"))
    for name in ("torso", "thigh", "shank"):
        segment = getattr(built, name)
        assert abs(segment.com[1]) == pytest.approx(segment.length / 2)
        assert segment.inertia == pytest.approx(segment.mass * segment.length**2 / 12)


@pytest.mark.parametrize("table", ["winter", "box"])
def test_the_whole_weighs_and_measures_what_was_asked(table):
    built = anthropometry.build(BodyConfig(height=1.6, mass=60.0, table=table))
    legs = built.thigh.mass + built.shank.mass + built.foot.mass
    assert built.torso.mass + 2 * legs == pytest.approx(60.0)
    assert built.hip_height + built.torso.length == pytest.approx(1.6)
    # The sole is the design's 0.21 m at 1.8 m: heel -0.06 m, toe +0.15 m.
    assert (built.heel, built.toe) == pytest.approx((-0.06 / 1.8 * 1.6, 0.15 / 1.8 * 1.6))


@pytest.mark.parametrize("table", ["winter", "box"])
def test_everything_scales_with_height_and_mass(table):
    small = anthropometry.build(BodyConfig(height=1.5, mass=50.0, table=table))
    large = anthropometry.build(BodyConfig(height=3.0, mass=150.0, table=table))
    for name in SEGMENTS:
        one, other = getattr(small, name), getattr(large, name)
        assert other.mass == pytest.approx(3 * one.mass)
        assert other.length == pytest.approx(2 * one.length)
        assert other.com == pytest.approx(tuple(2 * x for x in one.com))
        assert other.inertia == pytest.approx(3 * 2**2 * one.inertia)
    assert (large.heel, large.toe) == pytest.approx((2 * small.heel, 2 * small.toe))


@pytest.mark.parametrize("config", [BodyConfig(), BodyConfig(1.5, 90.0), BodyConfig(table="box")])
def test_mujoco_compiles_the_same_body(config):
    built = anthropometry.build(config)
    model = mjcf.build(built, PhysicsConfig()).compile()
    for row in range(1, model.nbody):
        compiled = model.body(row)
        segment = getattr(built, compiled.name.partition("_")[0])
        assert compiled.mass[0] == pytest.approx(segment.mass)
        assert compiled.ipos == pytest.approx([segment.com[0], 0.0, segment.com[1]])
        # The second axis is the pitch axis, in the body's own frame: MuJoCo has not turned it.
        assert compiled.iquat == pytest.approx([1, 0, 0, 0])
        assert compiled.inertia[1] == pytest.approx(segment.inertia)
    assert model.body_mass.sum() == pytest.approx(config.mass)


def test_mujoco_finds_the_centre_of_mass_where_the_table_puts_it():
    built = anthropometry.build(BodyConfig())
    model = mjcf.build(built, PhysicsConfig()).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)  # all angles 0: standing straight, hip at the origin
    # Heights above the hip: torso 0.3245; thigh -0.1910; shank -0.441 - 0.1917 = -0.6327; foot
    # -0.441 - 0.4428 - 0.0351 = -0.9189. Weighted by the mass fractions:
    # 0.678 x 0.3245 - 2 (0.1 x 0.1910 + 0.0465 x 0.6327 + 0.0145 x 0.9189) = 0.0963 m;
    # forward only the feet are off, 2 x 0.0145 x 0.045 = 0.0013 m.
    np.testing.assert_allclose(data.subtree_com[0], [0.0013, 0.0, 0.0963], atol=1e-4)


@pytest.mark.parametrize(
    ("config", "says"),
    [
        (BodyConfig(height=0.3), "height 0.3 m"),
        (BodyConfig(height=3.1), "height 3.1 m"),
        (BodyConfig(height=float("nan")), "height nan m"),
        (BodyConfig(mass=-75.0), "mass -75.0 kg"),
        (BodyConfig(mass=0.0), "mass 0.0 kg"),
        (BodyConfig(mass=501.0), "mass 501.0 kg"),
    ],
)
def test_nobody_is_built_out_of_bounds(config, says):
    with pytest.raises(UserError, match=f"{says}: give a"):
        anthropometry.build(config)


def test_an_unknown_table_is_named_with_the_known_ones():
    config = BodyConfig()
    object.__setattr__(config, "table", "round")  # past the type checker, as a damaged JSON would be
    with pytest.raises(UserError, match="table 'round': give one of winter, box"):
        anthropometry.build(config)
