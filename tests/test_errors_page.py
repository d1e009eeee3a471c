"""docs/errors.md knows every message that the package has for its user, and links lead there."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGE = " ".join((ROOT / "docs" / "errors.md").read_text(encoding="utf-8").split())
# A reason of the third becomes part of a message of the first.
RAISED = ("UserError", "NoStride", "Agreed", "Bad")
TREES = {path: ast.parse(path.read_text()) for path in sorted((ROOT / "jaxwalk").rglob("*.py"))}
LEAST = 8  # characters: what is shorter stands in many messages


def name_of(node: ast.AST) -> str | None:
    return getattr(node, "id", getattr(node, "attr", None))


def pieces(node: ast.AST) -> list[str]:
    """The constant parts of a message, '...' for what is between them."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, ast.JoinedStr):
        return [text for part in node.values for text in pieces(part)]
    if isinstance(node, ast.BinOp):  # text + text
        return pieces(node.left) + pieces(node.right)
    return ["..."]


def definitions(name: str) -> Iterator[ast.AST]:
    """What functions called ``name`` return, and what is assigned to it."""
    for tree in TREES.values():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and node.name == name:
                yield from (one.value for one in ast.walk(node) if isinstance(one, ast.Return) and one.value)
            elif isinstance(node, ast.Assign) and any(name_of(target) == name for target in node.targets):
                yield node.value


def messages() -> Iterator[tuple[str, list[str]]]:
    """(where, constant parts) of every message, and of every reason that one is made of."""
    for path, tree in TREES.items():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call) or name_of(node.func) not in RAISED or not node.args:
                continue
            where, said = f"{path.relative_to(ROOT)}:{node.lineno}", node.args[0]
            yield where, pieces(said)
            if isinstance(said, ast.Call):  # a helper makes it of reasons
                found = [*definitions(str(name_of(said.func))), *said.args]
            elif isinstance(said, ast.Name):
                found = list(definitions(said.id))
            else:
                found = []
            yield from ((where, pieces(one)) for one in found)


def is_told(parts: list[str]) -> bool:
    """Whether the page has the longest constant part, or, if all are short, the message with gaps."""
    longest = max((" ".join(part.split()) for part in parts), key=len)
    if len(longest) < LEAST:
        longest = re.sub(r"(\.\.\.)+", "...", "".join(parts)).strip()
    return longest in PAGE


def test_every_message_is_on_the_page():
    found = list(messages())
    assert len(found) > 120  # or they are no longer recognised
    missing = [f"{where}: {''.join(parts)}" for where, parts in found if not is_told(parts)]
    assert not missing, "docs/errors.md lacks:\n" + "\n".join(missing)


def test_a_new_message_would_be_missed():
    new = ast.parse('UserError(f"{path}: the moon is in the way; wait for {hours} h")').body[0].value.args[0]  # pyright: ignore[reportAttributeAccessIssue]
    assert not is_told(pieces(new))
    assert not is_told(pieces(ast.parse('f"{a}, {b}; {c}"').body[0].value))  # pyright: ignore[reportAttributeAccessIssue]


def test_the_policy_files_own_reasons_are_on_the_page():
    """They are returned, not raised."""
    returned = [*definitions("_problem")]
    assert len(returned) >= 5
    ends: list[ast.AST] = []
    for one in returned:
        ends += [one.body, one.orelse] if isinstance(one, ast.IfExp) else [one]
    assert all(is_told(pieces(one)) for one in ends if not isinstance(one, ast.Constant) or one.value)


@pytest.mark.parametrize("page", ["resume.md", "deploy.md", "watch.md", "sweep.md"])
def test_other_pages_lead_there(page):
    assert "](errors.md)" in (ROOT / "docs" / page).read_text(encoding="utf-8")
