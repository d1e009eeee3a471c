"""``jaxwalk export``: a policy in the formats asked for, with its self-test."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import numpy as np
from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.export import c, manifest, onnx, page, selftest, stablehlo, tensors
from jaxwalk.export.options import ExportArgs, PageArgs
from jaxwalk.learn.policies import named, policy
from jaxwalk.learn.runs import run_folder

_VECTORS = 64
WRITERS = {
    "safetensors": ("policy.safetensors", tensors.to_safetensors),
    "npz": ("policy.npz", tensors.to_npz),
    "onnx": ("policy.onnx", onnx.to_onnx),
    "stablehlo": ("policy.stablehlo", stablehlo.to_stablehlo),
    "c": ("policy.h", c.header),
}


def load(name: str) -> tuple[policy.Policy, dict[str, Any]]:
    """The trained policy called ``name`` and its manifest.

    Raises:
      UserError: a rule that nobody trained, no such policy, or a damaged one.
    """
    trained, config = named.trained(name)
    return trained, manifest.build(trained, config)


def observations(trained: policy.Policy, count: int) -> np.ndarray:
    """[count, O] random observations, spread as those that the policy was trained on; always the same."""
    size = len(trained.metadata.observation_names)
    drawn = np.random.default_rng(0).standard_normal((count, size))
    spread = np.asarray(trained.observation_std) * drawn
    return (np.asarray(trained.observation_mean) + spread).astype(np.float32)


def write(
    trained: policy.Policy, told: dict[str, Any], kinds: tuple[str, ...], folder: Path
) -> dict[str, Path]:
    """The files by format, with ``selftest.json`` (and ``selftest.c`` for C) beside them.

    Raises:
      UserError: a package of the extra ``export`` is missing, or the folder cannot be written.
    """
    if "safetensors" in kinds:
        # Whose policy has the same name; one beside a self-test is of an earlier export.
        exported = (folder / selftest.VECTORS).exists()
        run_folder.check_none("--out", folder, [run_folder.POLICY] if exported else [])
    contents = {kind: WRITERS[kind][1](trained, told) for kind in kinds}
    seen = observations(trained, _VECTORS)
    actions = np.asarray(jax.jit(policy.act)(policy.without_origin(trained), seen))
    low, high = (np.array([one[end] for one in told["action"]], np.float32) for end in ("low", "high"))
    commands = low + np.float32(0.5) * (actions + np.float32(1)) * (high - low)
    files.make_folder("--out", folder)
    vectors = {"observations": seen, "actions": actions, "commands": commands}
    about = {key: told[key] for key in ("jaxwalk_version", "observation", "action")}
    files.write_json(folder / selftest.VECTORS, about | {"tolerance": selftest.TOLERANCE} | vectors)
    if "c" in kinds:
        arrays = "\n".join(c.array(name, vectors[name]) for name in ("observations", "commands"))
        source = selftest.C_SOURCE.format(
            header=WRITERS["c"][0], count=_VECTORS, arrays=arrays, tolerance=selftest.TOLERANCE
        )
        files.write_bytes(folder / selftest.C_TEST, source.encode())
    written = {}
    for kind, content in contents.items():
        written[kind] = folder / WRITERS[kind][0]
        files.write_bytes(written[kind], content)
    return written


def main(args: ExportArgs) -> None:
    """Run ``jaxwalk export``.

    Raises:
      UserError: a policy that cannot be had in a format asked for, or a file that fails its test.
    """
    kinds = tuple(kind for kind in args.format if kind in WRITERS)
    if kinds:
        _write_and_show(args, kinds)
    if isinstance(args, PageArgs):
        page.write(args)


def _write_and_show(args: ExportArgs, kinds: tuple[str, ...]) -> None:
    console = Console(markup=False)
    written = write(*load(args.policy), kinds, args.out)
    table = Table("format", "file", "bytes", "actions", "commands, m or s", title=f"{args.policy}, exported")
    for kind, path in written.items():
        found = selftest.in_fresh_process(kind, path) if args.verify else None
        told_of = [f"{found[name]:.1e}" for name in ("actions", "commands")] if found else ["-", "-"]
        table.add_row(kind, path.name, f"{path.stat().st_size:,}", *told_of)
    if args.verify:
        table.caption = "largest differences from JAX on the self-test vectors, each in a fresh process"
    console.print(table)
    console.print(f"files in {args.out}", highlight=False)
