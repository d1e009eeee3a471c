"""How strong joints are, held against the sources' own numbers."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import physics, strength
from jaxwalk.model.similarity import Similarity

REFERENCE = Similarity(1.0, 1.0)
WEIGHT = 75 * 9.81 * 1.8
STRONG = jnp.full(6, 1e4)
# Anderson et al. 2007, table 3, men of 18 to 25: C1, C4, C5 of each direction.
MEN = {
    "hip forward": (0, 1, 0.113, 2.095, 4.267),
    "hip back": (0, -1, 0.161, 1.578, 3.190),
    "knee flexed": (1, 1, 0.087, 2.008, 5.233),
    "knee straight": (1, -1, 0.163, 1.517, 3.952),
    "dorsiflexed": (2, 1, 0.033, 0.699, 1.940),
    "plantarflexed": (2, -1, 0.095, 0.987, 3.558),
}


@pytest.mark.parametrize("joint, way, most, quarter, half", MEN.values(), ids=MEN)
def test_a_young_mans_strength_at_their_three_rates(joint, way, most, quarter, half):
    for rate, share in ((0.0, 1.0), (quarter, 0.75), (half, 0.5), (-3.0, 1.0)):
        found = strength.limited("person", REFERENCE, way * STRONG, jnp.full(6, way * rate))
        np.testing.assert_allclose(
            np.asarray(found).reshape(2, 3)[:, joint], way * share * most * WEIGHT, rtol=1e-5
        )


def test_an_exoskeletons_motors_lose_their_torque_along_a_straight_line_to_their_free_rate():
    rates = jnp.array([0.0, 3.0, 9.0, 12.0, -2.0, 4.5])
    found = strength.limited("exoskeleton", REFERENCE, STRONG, rates)
    np.testing.assert_allclose(found, [110, 110 * 2 / 3, 0, 0, 110, 55], rtol=1e-5, atol=1e-3)


def test_a_torque_within_the_limits_is_given_as_asked_and_none_is_limited_without_them():
    asked = jnp.array([30.0, -20.0, 10.0, -40.0, 5.0, -60.0])
    np.testing.assert_array_equal(strength.limited("person", REFERENCE, asked, jnp.zeros(6)), asked)
    np.testing.assert_array_equal(strength.limited("unlimited", REFERENCE, STRONG, jnp.zeros(6)), STRONG)


def test_strength_grows_with_weight_and_stature_and_rates_as_similar_bodies_do():
    tall = Similarity(1.21, 1.5)  # rates go with 1/1.1
    found = strength.limited("exoskeleton", tall, STRONG, jnp.full(6, 4.5 / 1.1))
    np.testing.assert_allclose(found, 55 * 1.5 * 1.21, rtol=1e-5)


@pytest.mark.parametrize("actuators, most", [("person", 0.163 * WEIGHT), ("exoskeleton", 110.0)])
def test_the_model_gives_no_more_than_the_strongest_way(actuators, most):
    config = PhysicsConfig(actuators=actuators)
    model = physics.compile_mujoco(BodyConfig(), config)
    assert model.actuator_forcerange[1, 1] == pytest.approx(most)  # a knee's


def test_weak_motors_give_what_is_asked_up_to_their_share_of_a_joints_strength():
    """A still hip of 75 kg and 1.8 m gives 150 N m forward, 213 N m back (Anderson et al. 2007)."""
    body, asked = Similarity.of(1.8, 75.0), jnp.array([100.0, 0.0, 0.0, -100.0, 0.0, 0.0])

    def given(share, torque):
        return strength.of_share("person", body, jnp.float32(share), torque, jnp.zeros(6))

    for share in (0.8, 0.5):
        some, most = given(share, asked), given(share, 100 * asked)
        np.testing.assert_allclose(some[::3], [min(100, 150 * share), -min(100, 213 * share)], rtol=0.02)
        np.testing.assert_allclose(most[::3], [150 * share, -213 * share], rtol=0.02)
    # Whole ones give what controllers ask, who know their strength.
    np.testing.assert_array_equal(given(1.0, asked), asked)
