"""The policy as StableHLO: one program for CPU and CUDA, any batch.

The file is a zip of what `jax.export` serialised (``program.bin``) and the manifest (``manifest.json``):
the serialised form has no room for names and units. Nothing in it is executed before it is called.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import export
from jaxtyping import Array, Float

from jaxwalk.common import untrusted, untrusted_arrays
from jaxwalk.common.errors import UserError
from jaxwalk.deploy.file import MAX_BYTES
from jaxwalk.export import manifest
from jaxwalk.learn.policies import policy

PLATFORMS = ("cpu", "cuda")
_PROGRAM, _MANIFEST = "program.bin", "manifest.json"


def to_stablehlo(trained: policy.Policy, told: dict[str, Any]) -> bytes:
    """[batch, O] raw observations to (actions [batch, A] in [-1, 1], commands [batch, A] in m and s)."""
    low, high = (jnp.array([one[end] for one in told["action"]], jnp.float32) for end in ("low", "high"))

    def both(observation: Float[Array, "B O"]) -> tuple[Float[Array, "B A"], Float[Array, "B A"]]:
        action = policy.act(trained, observation)
        return action, low[None] + 0.5 * (action + 1.0) * (high - low)[None]

    (batch,) = export.symbolic_shape("batch")
    shape = jax.ShapeDtypeStruct((batch, len(told["observation"])), jnp.float32)
    program = export.export(jax.jit(both), platforms=PLATFORMS)(shape).serialize()
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        for name, part in ((_PROGRAM, bytes(program)), (_MANIFEST, manifest.text(told).encode())):
            file.writestr(zipfile.ZipInfo(name), part)  # without a time: the same policy, the same bytes
    return content.getvalue()


def load(path: Path) -> export.Exported:
    """The program of a file that `to_stablehlo` made. It is a program: load what you would run.

    Raises:
      UserError: it cannot be read, or is no such file.
    """
    cure = "export the policy anew"
    content = untrusted.content(path, MAX_BYTES, cure)
    try:
        program = untrusted_arrays.members(content, MAX_BYTES)[_PROGRAM]
    except untrusted.Bad as bad:
        raise UserError(untrusted.unreadable(path, bad, cure)) from None
    except KeyError:
        raise UserError(untrusted.unreadable(path, f"there is no {_PROGRAM} in it", cure)) from None
    return export.deserialize(bytearray(program))


def run(path: Path, observation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(actions, commands) of [B, O] observations, on this machine's first device."""
    action, command = jax.jit(load(path).call)(jnp.asarray(observation))
    return np.asarray(action), np.asarray(command)
