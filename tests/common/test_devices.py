"""Walkers are split evenly, over as many devices as that allows."""

import jax
import jax.numpy as jnp
import pytest

from jaxwalk.common.parallel import devices


@pytest.mark.parametrize("walkers", [1, 5, 6, 7, 256])
def test_the_mesh_is_the_largest_that_divides_the_walkers(walkers):
    size = devices.mesh(walkers).size
    assert walkers % size == 0 and size <= jax.device_count()
    assert all(walkers % larger for larger in range(size + 1, min(walkers, jax.device_count()) + 1))
    assert devices.mesh().size == jax.device_count()


def test_an_accelerator_moves_all_walkers_at_once(monkeypatch):
    """Whatever block a CPU would move: one after another they would leave it idle."""

    def walk(x):
        return str(jax.make_jaxpr(lambda x: devices.each(lambda one: one + 1, x, block=1))(x))

    assert "scan" in walk(jnp.zeros(8))
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert "scan" not in walk(jnp.zeros(8))
