"""Which pushes are dealt: cells that cover what they should, and more of those whose outcome is open."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import Config
from jaxwalk.task import course, spawn
from jaxwalk.task.stepper import Task

MANY = 20_000
FOCUS = 0.7


@jax.jit
def draws(shares, key, situation=course.USUAL):
    return jax.vmap(lambda k: course.draw(shares, jnp.int32(situation), k))(jax.random.split(key, MANY))


def test_dealt_alike_they_cover_both_sides_all_sizes_and_the_whole_step():
    told = draws(jnp.asarray(course.even()), jax.random.key(0))
    assert np.mean(told.forward) == pytest.approx(0.5, abs=0.02)
    for numbers in (told.size, told.phase):
        share, _ = np.histogram(numbers, bins=12, range=(0.0, 1.0))
        assert share.sum() == MANY and np.all(np.abs(share / MANY * 12 - 1) < 0.15)
    assert np.abs(np.corrcoef([told.forward, told.size, told.phase]) - np.eye(3)).max() < 0.03


def test_a_push_is_of_the_cell_that_it_is_counted_as():
    none = jnp.zeros((course.SITUATIONS, course.PUSHES))
    for situation, cell in ((course.USUAL, 0), (course.LATE, 1), (course.SOON, course.PUSHES - 1)):
        told = jax.device_get(draws(none.at[situation, cell].set(1.0), jax.random.key(cell), situation))
        assert np.unique(told.cell).tolist() == [situation * course.PUSHES + cell]
        assert np.unique(told.forward).tolist() == [cell % 2 == 0]
        width = told.size.max() - told.size.min(), told.phase.max() - told.phase.min()
        assert width == pytest.approx((1 / course.SIZES, 1 / course.PHASES), rel=0.01)


def test_where_half_fall_most_is_dealt_and_where_all_or_none_do_the_least():
    dealt = jnp.full(course.CELLS, 100.0)
    lost = jnp.full(course.CELLS, 0.0).at[5].set(50.0).at[7].set(100.0).at[9].set(10.0)
    all_shares = course.shares(course.Course(dealt, lost), FOCUS)
    shares = all_shares[course.USUAL]
    np.testing.assert_allclose(all_shares.sum(1), 1.0, atol=1e-5)
    assert shares[5] == shares.max() and float(shares[7]) == pytest.approx(float(shares[0]), rel=1e-3)
    assert shares[5] > shares[9] > shares[0] >= (1 - FOCUS) / course.PUSHES
    # What is open to one walker says nothing of those in another situation.
    np.testing.assert_allclose(all_shares[course.LATE], 1 / course.PUSHES, rtol=1e-5)


def test_what_nothing_is_known_of_is_dealt_alike():
    np.testing.assert_allclose(course.shares(course.start(), FOCUS), course.even(), rtol=1e-5)


def test_counts_leave_out_what_is_of_no_cell_and_fade():
    told = course.counted(jnp.array([3, course.NONE, 3, 200]))
    assert told[3] == 2 and told[200] == 1 and told.sum() == 3
    after = course.remembered(
        course.Course(told, told), jnp.zeros(course.CELLS), course.counted(jnp.array([0]))
    )
    assert after.dealt[3] == pytest.approx(2 * course.MEMORY) and after.lost[0] == 1


def test_a_walker_is_dealt_the_pushes_of_its_situation():
    config = Config()
    keys = jax.random.split(jax.random.key(2), 2_000)
    task = Task.of(config)

    @jax.jit
    def dealt(keys):
        def one(key):
            begin, again = jax.random.split(key)
            fresh = spawn.walker(config, task, begin)
            walked = fresh.replace(walker=fresh.walker.replace(tick=jnp.int32(500)))
            return fresh, spawn.push(config, walked, again)

        return jax.vmap(one)(keys)

    fresh, again = jax.device_get(dealt(keys))
    late = fresh.walker.person.burden.delay > 0
    timestep, own = config.physics.timestep, config.pushes
    first = fresh.walker.push
    # Nobody is pushed soon after a push that never was.
    np.testing.assert_array_equal(first.cell // course.PUSHES, np.where(late, course.LATE, course.USUAL))
    step = spawn.USUAL * fresh.walker.person.ratio.time
    assert (first.start * timestep > own.rest - step - timestep).all()
    soon = again.cell // course.PUSHES == course.SOON
    assert soon.mean() == pytest.approx(own.soon, abs=0.03)
    np.testing.assert_array_equal(again.cell[~soon] // course.PUSHES, late[~soon])
    wait = again.start * timestep - 1.0
    assert (wait[soon] < spawn.SOON[1] + step[soon]).all() and (wait[~soon] > own.rest - step[~soon]).all()
