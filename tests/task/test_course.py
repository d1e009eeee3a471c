"""Which pushes are dealt: cells that cover what they should, and more of those whose outcome is open."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.task import course

MANY = 20_000
FOCUS = 0.7


@jax.jit
def draws(shares, key):
    return jax.vmap(lambda k: course.draw(shares, k))(jax.random.split(key, MANY))


def test_dealt_alike_they_cover_both_sides_all_sizes_and_the_whole_step():
    told = draws(jnp.asarray(course.even()), jax.random.key(0))
    assert np.mean(told.forward) == pytest.approx(0.5, abs=0.02)
    for numbers in (told.size, told.phase):
        share, _ = np.histogram(numbers, bins=12, range=(0.0, 1.0))
        assert share.sum() == MANY and np.all(np.abs(share / MANY * 12 - 1) < 0.15)
    assert np.abs(np.corrcoef([told.forward, told.size, told.phase]) - np.eye(3)).max() < 0.03


def test_a_push_is_of_the_cell_that_it_is_counted_as():
    one = jnp.zeros(course.CELLS)
    for cell in (0, 1, 37, course.CELLS - 1):
        told = jax.device_get(draws(one.at[cell].set(1.0), jax.random.key(cell)))
        assert np.unique(told.cell).tolist() == [cell]
        assert np.unique(told.forward).tolist() == [cell % 2 == 0]
        width = told.size.max() - told.size.min(), told.phase.max() - told.phase.min()
        assert width == pytest.approx((1 / course.SIZES, 1 / course.PHASES), rel=0.01)


def test_where_half_fall_most_is_dealt_and_where_all_or_none_do_the_least():
    dealt = jnp.full(course.CELLS, 100.0)
    lost = jnp.full(course.CELLS, 0.0).at[5].set(50.0).at[7].set(100.0).at[9].set(10.0)
    shares = course.shares(course.Course(dealt, lost), FOCUS)
    assert float(shares.sum()) == pytest.approx(1.0, abs=1e-5)
    assert shares[5] == shares.max() and float(shares[7]) == pytest.approx(float(shares[0]), rel=1e-3)
    assert shares[5] > shares[9] > shares[0] >= (1 - FOCUS) / course.CELLS


def test_what_nothing_is_known_of_is_dealt_alike():
    np.testing.assert_allclose(course.shares(course.start(), FOCUS), course.even(), rtol=1e-5)


def test_counts_leave_out_what_is_of_no_cell_and_fade():
    told = course.counted(jnp.array([3, course.NONE, 3, 95]))
    assert told[3] == 2 and told[95] == 1 and told.sum() == 3
    after = course.remembered(
        course.Course(told, told), jnp.zeros(course.CELLS), course.counted(jnp.array([0]))
    )
    assert after.dealt[3] == pytest.approx(2 * course.MEMORY) and after.lost[0] == 1
