"""What walkers of training draw: one thing at a time, within what is configured, and most of them nothing."""

import dataclasses
from functools import partial

import jax
import numpy as np
import pytest

from jaxwalk.config import Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.task import circumstances

MANY = 4_000
CONFIG = Config()


@pytest.fixture(scope="module")
def drawn():
    keys = jax.random.split(jax.random.key(3), MANY)
    return jax.device_get(jax.vmap(partial(circumstances.draw, CONFIG))(keys))


def changed(drawn):
    """By kind: [N] whether a walker's is another than configured."""
    burden = drawn.burden
    late = burden.delay > 0
    assert (late == (burden.strength < 1)).all()  # late and weak go together
    return {
        "speed": drawn.speed != 1.0,
        "backpack": (burden.mass > 0) & (burden.ahead < 0),
        "front_pack": (burden.mass > 0) & (burden.ahead > 0),
        "slope": burden.slope != 0,
        "friction": burden.friction != np.float32(CONFIG.physics.friction),
        "noise": drawn.noise != 1.0,
        "late": late,
    }


def test_a_share_of_the_walkers_meets_one_thing_late_instruments_more_often_than_another(drawn):
    met = changed(drawn)
    assert tuple(met) == circumstances.KINDS
    assert np.sum(list(met.values()), axis=0).max() == 1
    each = CONFIG.circumstances.share / (len(circumstances.KINDS) + CONFIG.circumstances.late - 1)
    for name, own in met.items():
        share = CONFIG.circumstances.late * each if name == "late" else each
        assert np.mean(own) == pytest.approx(share, abs=5 * np.sqrt(share / MANY))


def test_what_is_met_reaches_from_the_usual_to_the_limits(drawn):
    own, burden = CONFIG.circumstances, drawn.burden
    for values, low, high in (
        (drawn.speed, 1 - own.speed, 1 + own.speed),
        (burden.mass, 0.0, own.pack),
        (burden.slope, -np.radians(own.slope), np.radians(own.slope)),
        (burden.friction, own.friction, CONFIG.physics.friction),
        (drawn.noise, 1.0, own.noise),
        (burden.delay, 0.0, own.delay),
        (burden.strength, own.strength, 1.0),
    ):
        assert low - 1e-6 <= values.min() and values.max() <= high + 1e-6
        span = high - low
        assert values.min() < low + 0.25 * span and values.max() > high - 0.25 * span
    # The density of what has one side rises from nought to the limit: its mean is two thirds of it.
    assert np.mean(burden.delay[burden.delay > 0]) == pytest.approx(own.delay * 2 / 3, rel=0.05)


def test_nobody_bears_anything_where_none_is_to():
    alone = dataclasses.replace(CONFIG.circumstances, share=0.0)
    one = circumstances.draw(dataclasses.replace(CONFIG, circumstances=alone), jax.random.key(0))
    assert one.burden is None and (float(one.speed), float(one.noise)) == (1.0, 1.0)
    assert circumstances.draw(PRESETS["paper"], jax.random.key(0)).burden is None
