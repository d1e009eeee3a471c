"""A command line made of options gives those options again."""

import importlib
import json
import shlex
from pathlib import Path

import pytest

from jaxwalk.common.files import to_json
from jaxwalk.config import validate
from jaxwalk.measure.agreement.options import AgreementArgs
from jaxwalk.measure.bench.options import BenchArgs
from jaxwalk.measure.compare.options import CompareArgs
from jaxwalk.measure.evaluate.options import EvaluateArgs
from jaxwalk.measure.gait.options import GaitArgs
from jaxwalk.measure.generalise.options import GeneraliseArgs
from jaxwalk.measure.push_map.options import PushMapArgs
from jaxwalk.measure.report.options import ReportArgs
from jaxwalk.measure.sensitivity.options import SensitivityArgs
from jaxwalk.options import lines
from jaxwalk.options.parse import parse
from jaxwalk.paper.options import PaperArgs

CASES = [
    ("evaluate", EvaluateArgs("fixed", impulses=(-100.0, 0.1, 1 / 3), height=1.4, json=Path("a b/e.json"))),
    (
        "push-map",
        PushMapArgs(
            "runs/it's", Path("m"), points=("torso-0.25", "swing-shank"), engine="mujoco", seed=2**32 - 1
        ),
    ),
    ("compare", CompareArgs(("fixed", "my ddpg=runs/a,runs/b"), Path("c"), noise=1e-05, impulses=(-40.0,))),
    ("agreement", AgreementArgs("shipped", Path("a"), mass=60.0)),
    ("sensitivity", SensitivityArgs("shipped", Path("s"), timesteps=(0.001,), iterations=(2.0, 16.0))),
    ("generalise", GeneraliseArgs("shipped", Path("n"), only=("mass", "force"), masses=(60.5,))),
    ("gait", GaitArgs("shipped", Path("g"), seconds=6.5)),
    ("bench", BenchArgs(walkers=3)),
    ("bench", BenchArgs(stages=True, batches=(64.0, 256.0))),
    ("report", ReportArgs("shipped", Path("r.html"), quick=True, parts=("gait", "bench"))),
    ("paper", PaperArgs(Path("p"), policy="fixed", only=("speed", "loads"), trained=Path("docs/paper"))),
]


@pytest.mark.parametrize(("command", "args"), CASES, ids=[command for command, _ in CASES])
def test_the_line_reads_back_as_the_same_options(command, args):
    program, name, *rest = shlex.split(lines.line(command, args))
    assert (program, name) == ("jaxwalk", command)
    assert parse(type(args), rest, command) == args
    # And from the plain values that a JSON file keeps.
    assert (
        validate.from_dict(type(args), json.loads(to_json({k: _kept(v) for k, v in vars(args).items()})))
        == args
    )


def _kept(value):
    return str(value) if isinstance(value, Path) else value


def test_what_has_its_default_is_not_said():
    assert lines.line("evaluate", EvaluateArgs("fixed")) == "jaxwalk evaluate fixed"
    args = PushMapArgs("fixed", Path("m"), impulses=(-20.0, 12.5))
    assert lines.line("push-map", args) == "jaxwalk push-map fixed --out m --impulses -20,12.5"


def test_every_command_that_the_report_shows_is_among_the_cases():
    parts = importlib.import_module("jaxwalk.measure.report.parts")
    assert set(parts.PARTS) <= {command for command, _ in CASES}
