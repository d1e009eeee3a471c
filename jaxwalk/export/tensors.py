"""safetensors and npz: the policy's tensors and the manifest, as `jaxwalk.deploy` reads them."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import safetensors.numpy

from jaxwalk.deploy.file import MANIFEST
from jaxwalk.export import manifest
from jaxwalk.learn.policies import policy


def to_safetensors(trained: policy.Policy, told: dict[str, Any]) -> bytes:
    """Also a policy file: every command of jaxwalk reads it."""
    return safetensors.numpy.save(
        policy.tensors(trained), policy.header(trained) | {MANIFEST: manifest.text(told)}
    )


def to_npz(trained: policy.Policy, told: dict[str, Any]) -> bytes:
    """No pickle in it: the manifest is an array of one string."""
    content = io.BytesIO()
    parts = policy.tensors(trained) | {MANIFEST: np.array(manifest.text(told))}
    np.savez(content, allow_pickle=False, **parts)
    return content.getvalue()
