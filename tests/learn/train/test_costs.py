"""What the loop must not cost: a second compilation, ways through the host, copies, ever more memory."""

from __future__ import annotations

import dataclasses
import resource
import sys
from pathlib import Path

import jax
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import small

from jaxwalk.common.parallel import devices
from jaxwalk.learn.train import device_loop

# A window a report: a thousand reports take seconds.
CONFIG = dataclasses.replace(
    small.CONFIG, train=dataclasses.replace(small.CONFIG.train, walkers=4, windows_per_report=1)
)
WARM = 300  # reports, of which the later ones learn


@pytest.fixture(scope="module")
def mesh():
    return devices.mesh(device_loop.blocks(CONFIG))


@pytest.fixture(scope="module")
def advance(mesh):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(devices, "BLOCK", 4)
        program = device_loop.make(CONFIG, mesh)
        program.lower(device_loop.layout(CONFIG))  # traced while blocks are small
        yield program


@pytest.fixture
def state(mesh, advance):
    current = device_loop.init(CONFIG, mesh, 0)
    for _ in range(WARM):
        current = jax.block_until_ready(advance(current))
    assert int(current.learner.updates) > 0
    return current


def test_a_state_that_was_written_down_needs_no_other_program():
    """Read again, no number is weakly typed: a state with one would be compiled for once more on resuming."""
    assert not [leaf for leaf in jax.tree.leaves(device_loop.layout(CONFIG)) if leaf.weak_type]


def test_it_is_compiled_once_and_needs_nothing_of_the_host(advance, state):
    compiled: list[str] = []
    jax.monitoring.register_event_duration_secs_listener(
        lambda event, duration_secs, **more: compiled.append(event) if "compile" in event else None
    )
    with jax.transfer_guard("disallow"):
        for _ in range(5):
            state = jax.block_until_ready(advance(state))
    assert not compiled


def test_its_state_is_given_up_and_written_in_place(advance, state):
    before = jax.tree.leaves((state.steppers.walker.plant, state.replay, state.learner.actor, state.key))
    ring = state.replay.rows.observation.addressable_shards[0].data.unsafe_buffer_pointer()
    after = jax.block_until_ready(advance(state))
    assert all(leaf.is_deleted() for leaf in before)
    assert after.replay.rows.observation.addressable_shards[0].data.unsafe_buffer_pointer() == ring


def test_a_thousand_reports_leave_nothing_behind(advance, state):
    arrays, begun = len(jax.live_arrays()), _peak_mb()
    for _ in range(1000):
        state = jax.block_until_ready(advance(state))
    assert len(jax.live_arrays()) < arrays + 100  # a state has more than that
    # Keeping the state of each would be over 100 MB here, the ring above all.
    assert _peak_mb() - begun < 20


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
