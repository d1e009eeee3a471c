"""Compile the walkers that pages carry: jaxwalk/show/play/modules.

    python scripts/make_page.py

It takes clang and lld (Debian's clang and lld packages); whoever makes a page does not.
"""

from __future__ import annotations

import dataclasses
import json
import subprocess
import tempfile
from pathlib import Path

import jax

from jaxwalk.common import runtime
from jaxwalk.learn.policies import named
from jaxwalk.show.play import module, program

FLAGS = (
    "--target=wasm32 -std=c++17 -O2 -nostdlib -ffreestanding -fwrapv -fno-strict-aliasing -fno-math-errno "
    "-fno-trapping-math -fno-exceptions -fno-rtti -fno-threadsafe-statics -mbulk-memory -w "
    "-Wl,--no-entry -Wl,--allow-undefined -Wl,--export=__heap_base -Wl,--strip-all -Wl,-z,stack-size=65536"
).split()
SUBJECTS = {"planned": "shipped", "told": "constant"}
"""Of each module, somebody who walks by it."""
HOME = Path(module.__file__).parent / "modules"


def main() -> None:
    """Write them all."""
    HOME.mkdir(exist_ok=True)
    for name in module.NAMES:
        config = named.load(SUBJECTS[name]).config
        text = program.source(config)
        code = compiled(text)
        given, state = program.layouts(config)
        made = module.Module(code, program.kind(config), program.digest(text), jax.__version__, given, state)
        told = {field.name: getattr(made, field.name) for field in dataclasses.fields(made)}
        (HOME / f"{name}.wasm").write_bytes(told.pop("code"))
        (HOME / f"{name}.json").write_text(json.dumps(told, separators=(",", ":")) + "\n")
        print(f"{HOME / name}.wasm: {len(code):,} bytes")


def compiled(text: str) -> bytes:
    """The WebAssembly module of a source."""
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder) / "walker.cc", Path(folder) / "walker.wasm"
        source.write_text(text)
        subprocess.run(["clang++", *FLAGS, str(source), "-o", str(made)], check=True)
        return made.read_bytes()


if __name__ == "__main__":
    runtime.setup()
    main()
