"""What programs call refuses wrong types by the argument's name."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyModel
from jaxwalk.options.arguments import looked_at

# In a process of its own: tests look at types themselves.
_WRONG = """
import jaxwalk as jw
for call in (
    lambda: jw.preset(3),
    lambda: jw.train("quick"),
    lambda: jw.train(jw.Config(), seed="one"),
    lambda: jw.load_policy(speed="fast"),
    lambda: jw.load_policy(model="round"),
    lambda: jw.evaluate(jw.Config()),
    lambda: jw.evaluate("fixed", jw.PushTest(walkers=2.5)),
    lambda: jw.evaluate("fixed", jw.PushTest(motor_strength=5.0)),
    lambda: jw.push_map("fixed", "x", impulses="30"),
    lambda: jw.push_map("fixed", None),
    lambda: jw.export_policy("shipped", "x", formats="c"),
    lambda: jw.resume("a\\0b"),
):
    try:
        call()
    except jw.UserError as error:
        print(error)
"""
_SAID = """
name 3: give a text
config 'quick': give a jaxwalk.Config
seed 'one': give a whole number
speed 'fast': give a number or None
model 'round': give one of planar, walls or None
policy Config(
walkers 2.5: give a whole number
motor_strength 5: give 0.1 to 1
impulses '30': give a sequence of which each is a number
out None: give a text or a path
formats 'c': give a tuple of which each is a text
run_dir 'a\\x00b': give a text or a path
"""


def test_every_wrong_type_is_named():
    done = subprocess.run([sys.executable, "-c", _WRONG], capture_output=True, text=True, check=True)
    said, told = done.stdout.splitlines(), _SAID.strip().splitlines()
    assert [line[: len(start)] for line, start in zip(said, told, strict=True)] == told


@looked_at
def _called(path: str | Path, model: BodyModel | None = None, n: int = 0):
    if n > 3:
        raise UserError("--motor-strength 3, --train.walkers: not -- as is")
    return jnp.asarray(np.zeros(1)).dtype


def test_numbers_of_numpy_are_numbers_and_jax_is_ours():
    three: Any = np.int64(3)
    with jax.enable_x64(True):
        assert _called(Path("a"), n=three) == jnp.float32
    with pytest.raises(UserError, match=r"^motor_strength 3, train\.walkers: not -- as is$"):
        _called("a", n=4)
    for wrong in (True, 1.0):
        with pytest.raises(UserError, match=r"n .*: give a whole number"):
            _called("a", n=wrong)  # pyright: ignore[reportArgumentType]
