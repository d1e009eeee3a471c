"""Self-test vectors beside an export, and the test itself, made in a fresh process.

``python -m jaxwalk.export.selftest FORMAT FILE`` tests one file against the ``selftest.json`` beside it and
prints the largest differences as JSON. For safetensors and npz it imports NumPy alone.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.common import untrusted
from jaxwalk.common.errors import UserError

VECTORS, C_TEST = "selftest.json", "selftest.c"
TOLERANCE = 1e-5  # m, s; of a steep network JAX itself is half of that from the same sums in doubles
"""Largest difference of a command, m and s: 32-bit sums in another order differ by so much at most."""
C_FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2")


def vectors(path: Path) -> dict[str, np.ndarray]:
    """``observations`` [N, O], ``actions`` and ``commands`` [N, A] of a ``selftest.json``."""
    told = untrusted.read_json(path, "export the policy anew")
    try:
        names = ("observations", "actions", "commands")
        found = {name: np.array(told[name], np.float32) for name in names}
    except (KeyError, TypeError, ValueError):
        found = {}
    if {x.ndim for x in found.values()} != {2} or len({len(x) for x in found.values()}) != 1:
        raise UserError(f"{path} holds no observations with their answers: export the policy anew")
    return found


def outputs(kind: str, path: Path, observations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(actions, commands) that the file's own runtime gives for [N, O] observations.

    Raises:
      UserError: the runtime is not there.
    """
    if kind in ("safetensors", "npz"):
        from jaxwalk import deploy

        policy = deploy.load(path)
        actions = policy.act(observations)
        return actions, policy.command(actions)
    if kind == "onnx":
        from jaxwalk.export.onnx import require

        session = require("onnxruntime").InferenceSession(str(path), providers=["CPUExecutionProvider"])
        actions, commands = session.run(["action", "command"], {"observation": observations})
        return np.asarray(actions), np.asarray(commands)
    if kind == "stablehlo":
        from jaxwalk.export import stablehlo

        return stablehlo.run(path, observations)
    return _by_c(path, observations)


def _by_c(path: Path, observations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By the self-test's program, which reads observations and writes actions and commands as float32."""
    with tempfile.TemporaryDirectory() as folder:
        program = compile_c(path.with_name(C_TEST), Path(folder) / "selftest")
        raw = observations.astype(np.float32).tobytes()
        said = subprocess.run([program, "-"], input=raw, capture_output=True, check=True).stdout
    both = np.frombuffer(said, np.float32).reshape(len(observations), 2, -1)
    return both[:, 0], both[:, 1]


def compile_c(source: Path, program: Path, *flags: str) -> Path:
    """``program``, made of ``source`` by the system's compiler, every warning an error.

    Raises:
      UserError: no compiler, or one that refuses.
    """
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise UserError("--format c: no C compiler to test it with; install gcc or leave out --verify")
    command = [compiler, *C_FLAGS, *flags, str(source), "-o", str(program), "-lm"]
    made = subprocess.run(command, capture_output=True, text=True)
    if made.returncode:
        first = next(iter(made.stderr.splitlines()), "no reason given")
        raise UserError(f"{source}: the C compiler refuses it ({first}); see {' '.join(command)}")
    return program


def differences(kind: str, path: Path) -> dict[str, float]:
    """Largest absolute difference of ``actions`` and ``commands`` from the vectors beside ``path``."""
    expected = vectors(path.with_name(VECTORS))
    found = outputs(kind, path, expected["observations"])
    return {
        name: float(np.max(np.abs(given - expected[name])))
        for name, given in zip(("actions", "commands"), found, strict=True)
    }


def in_fresh_process(kind: str, path: Path) -> dict[str, float]:
    """`differences`, found by a new interpreter that has only the files.

    Raises:
      UserError: it failed, or a command differs by more than `TOLERANCE`.
    """
    command = [sys.executable, "-m", "jaxwalk.export.selftest", kind, str(path)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        said = done.stderr.strip().splitlines() or ["no reason given"]
        raise UserError(f"{path}: the self-test failed: {said[-1]}")
    found = json.loads(done.stdout.splitlines()[-1])
    if not found["commands"] <= TOLERANCE:
        raise UserError(
            f"{path}: commands differ from JAX's by {found['commands']:.2g}, more than {TOLERANCE:g}: "
            "do not use it, and report this"
        )
    return found


C_SOURCE = """\
/* Self-test of policy.h: without arguments it compares with the vectors below and returns 0 if they hold;
 * with any argument it reads observations (float32) and writes actions and commands. */
#include <stdio.h>

#include "{header}"

#define VECTORS {count}
{arrays}

int main(int argc, char **argv) {{
    float seen[JAXWALK_OBSERVATIONS], answer[2 * JAXWALK_ACTIONS], worst = 0.0f;
    (void)argv;
    if (argc > 1) {{
        while (fread(seen, sizeof(float), JAXWALK_OBSERVATIONS, stdin) == JAXWALK_OBSERVATIONS) {{
            jaxwalk_act(seen, answer);
            jaxwalk_command(answer, answer + JAXWALK_ACTIONS);
            fwrite(answer, sizeof(float), 2 * JAXWALK_ACTIONS, stdout);
        }}
        return 0;
    }}
    for (int i = 0; i < VECTORS; ++i) {{
        jaxwalk_act(observations + i * JAXWALK_OBSERVATIONS, answer);
        jaxwalk_command(answer, answer + JAXWALK_ACTIONS);
        for (int k = 0; k < JAXWALK_ACTIONS; ++k)
            worst = fmaxf(worst, fabsf(answer[JAXWALK_ACTIONS + k] - commands[i * JAXWALK_ACTIONS + k]));
    }}
    printf("largest difference of a command: %.3g (at most {tolerance:g})\\n", (double)worst);
    return worst <= {tolerance:g}f ? 0 : 1;
}}
"""


def main(argv: list[str]) -> int:
    """Test the file that ``argv``, [FORMAT, FILE], names; gives the exit status, 2 for a bad file."""
    kind, path = argv
    try:
        found: dict[str, Any] = differences(kind, Path(path))
    except UserError as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
