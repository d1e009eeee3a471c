"""The loop on any number of devices: the same draws, the same walkers, the same learner but for rounding."""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

REPORTS = 3
LENGTH = 1e-2  # m: what rounding has become of a walker's place, who falls and lands on the way
PARAMETERS = 1e-4  # after a few updates

_PROGRAM = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from jaxwalk.common import runtime
runtime.setup()
import numpy as np
import small
from jaxwalk.common.parallel import devices
from jaxwalk.learn.train import checkpoint, device_loop
mesh = devices.mesh(device_loop.blocks(small.CONFIG))
assert mesh.size == int(sys.argv[1])
state, advance = device_loop.init(small.CONFIG, mesh, small.SEED), device_loop.make(small.CONFIG, mesh)
start = checkpoint.pack(state)
for _ in range({REPORTS}):
    state = advance(state)
found = {{f"start.{{name}}": x for name, x in start.items()}}
found |= {{f"end.{{name}}": x for name, x in checkpoint.pack(state).items()}}
np.savez(sys.argv[2], **found)
"""


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """What comes of it on so many devices, in a process of its own."""

    @functools.cache
    def on(count: int) -> dict[str, np.ndarray]:
        file = tmp_path_factory.mktemp("loop") / "end.npz"
        command = [sys.executable, "-c", _PROGRAM, str(count), str(file)]
        done = subprocess.run(
            command, capture_output=True, text=True, env=os.environ | {"JAX_NUM_CPU_DEVICES": str(count)}
        )
        assert done.returncode == 0, done.stderr[-2000:]
        return dict(np.load(file))

    return on


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 4])
def test_the_same_on_any_number_of_devices(trained, count):
    one, many = trained(1), trained(count)
    assert one.keys() == many.keys()
    for name, x in one.items():
        assert x.shape == many[name].shape, name
        whole = x.dtype.kind != "f" or name.startswith("start.")
        if whole:  # keys, ticks, who awaits what: nothing of these is rounded
            np.testing.assert_array_equal(x, many[name], err_msg=name)
    place = "end.steppers.walker.plant.qpos"
    np.testing.assert_allclose(one[place], many[place], rtol=0, atol=LENGTH)
    learned = [name for name in one if name.startswith("end.learner.") and name.split(".")[2] in _NETWORKS]
    assert len(learned) > 10
    for name in learned:
        np.testing.assert_allclose(one[name], many[name], rtol=0, atol=PARAMETERS, err_msg=name)
    assert one["end.learner.updates"] > 0 and one["end.replay.size"].sum() > 10


_NETWORKS = {"actor", "critic", "target_actor", "target_critic", "average"}
