"""Commands on files that are none of theirs, and what the package may not use to read any."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from jaxwalk import cli

ROOT = Path(__file__).resolve().parents[2]

ONE_LINE = {
    "policy": (["evaluate", "BAD.safetensors"], "BAD.safetensors"),
    "export": (["export", "BAD.safetensors", "--out", "exported"], "BAD.safetensors"),
    "run": (["train", "--resume", "run"], "run/config.json"),
    "comparison": (["compare", "fixed", "BAD.safetensors", "--out", "compared"], "BAD.safetensors"),
    "map": (["push-map", "shipped", "--out", "map"], "map/map.npz"),
    "gait": (["gait", "shipped", "--out", "gait"], "gait/gait.json"),
    "report": (["report", "shipped", "--out", "r.html", "--results", "all"], "all/evaluate/evaluate.json"),
    "paper": (["paper", "--out", "paper"], "paper/paper.json"),
}  # fmt: skip


@pytest.mark.parametrize("case", ONE_LINE)
@pytest.mark.parametrize(
    "content",
    [b"", b"\xff" * 100, b"{}", b'{"config": {"body": {"height": 1e308}}}'],
    ids=["nothing", "bytes", "no-fields", "huge"],
)
def test_commands_end_in_one_line_and_touch_nothing(tmp_path, monkeypatch, capsys, case, content):
    argv, name = ONE_LINE[case]
    monkeypatch.chdir(tmp_path)
    Path(name).parent.mkdir(parents=True, exist_ok=True)
    Path(name).write_bytes(content)
    assert cli.main(argv) == 2
    line = capsys.readouterr().err
    assert line.startswith("jaxwalk: error: ") and line.count("\n") == 1 and line[:-1].isprintable()
    assert name in line, line
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [tmp_path / name]
    assert Path(name).read_bytes() == content


def executing(tree: ast.AST) -> list[str]:
    """What in a program can execute what it reads."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [one.name for one in node.names] + [getattr(node, "module", None) or ""]
            found += {"pickle", "marshal", "shelve", "dill", "yaml", "joblib"} & {
                name.split(".")[0] for name in names
            }
        elif isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            found += [name] if name in ("eval", "exec", "compile", "np.load", "numpy.load") else []
            found += ["allow_pickle" for one in node.keywords if ast.unparse(one) == "allow_pickle=True"]
    return found


def test_nothing_in_the_package_can_execute_what_it_reads():
    for path in (ROOT / "jaxwalk").rglob("*.py"):
        assert not executing(ast.parse(path.read_text())), path
    for bad in (
        "import pickle",
        "from yaml import load",
        "eval(text)",
        "np.load(path)",
        "f(allow_pickle=True)",
    ):
        assert executing(ast.parse(bad)), bad
