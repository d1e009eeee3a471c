"""``jaxwalk paper`` from the outside, with numbers in place of measurements: its files, and going on."""

from __future__ import annotations

import csv
import dataclasses
import html
import json
import re
import shlex

import pytest
from paper import canned
from PIL import Image

from jaxwalk import cli
from jaxwalk.options.parse import parse
from jaxwalk.paper import command
from jaxwalk.paper.claims import registry
from jaxwalk.paper.options import NAMES, PaperArgs


@pytest.fixture
def measured(monkeypatch):
    """(claim, body) of each measurement that is made."""
    calls = []
    monkeypatch.setattr(command, "registry", lambda: canned.claims(calls))
    return calls


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """The whole page, with one claim that does not hold and one that cannot be told."""
    folder = tmp_path_factory.mktemp("paper")
    claims = canned.claims([], drawn=True)
    for name, sign in (("pushes", -1), ("start", 0)):
        numbers = canned.NUMBERS[name](sign)
        claims[name] = dataclasses.replace(claims[name], measure=lambda lab, model, numbers=numbers: numbers)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "registry", lambda: claims)
        assert cli.main(["paper", "--out", str(folder)]) == 0
    return folder


def paper(out, *options):
    return cli.main(["paper", "--out", str(out), *map(str, options)])


def told(out):
    return json.loads((out / "paper.json").read_text(encoding="utf-8"))["claims"]


def text_of(page):
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", page)).replace("\u00a0", " ").split())


def test_markdown_html_and_json_say_the_same_of_every_claim(out):
    page, markdown = ((out / f"paper.{kind}").read_text(encoding="utf-8") for kind in ("html", "md"))
    assert tuple(told(out)) == NAMES
    for name, one in told(out).items():
        section = page.partition(f'<section id="{name}">')[2].partition("</section>")[0]
        part = markdown.partition(f'<a id="{name}"></a>')[2].partition("<a id=")[0]
        shown = text_of(section)
        assert f"{one['title']} {one['verdict']}" in shown and f"## {one['title']}: {one['verdict']}" in part
        for words in (one["paper"], one["rule"]):
            assert words in shown and words in part
        for body in one["bodies"].values():
            for check in body["checks"]:
                assert f"{check['says']} {check['so']}" in shown
                assert f"| {check['says']} | {check['so']} |" in part
        assert one["command"] in shown and f"`{one['command']}`" in part
    verdicts = [one["verdict"] for one in told(out).values()]
    assert verdicts.count("holds") == 11 and told(out)["pushes"]["verdict"] == "does not hold"
    assert told(out)["start"]["verdict"] == "cannot be told"
    assert "11 holds, 1 does not hold, 1 cannot be told." in text_of(page) + markdown


def test_the_page_stands_alone(out):
    page = (out / "paper.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and 'name="viewport"' in page and "@media print" in page
    used = re.findall(r'\b(?:src|href|srcset|data)="([^"]*)"', page)
    assert used and all(one.startswith(("data:image/png;base64,", "#")) for one in used)
    assert not re.search(r"url\(|@import|<(script|link|iframe|object)\b", page)
    assert "http" not in page.replace("data:image/png;base64,", "")
    markdown = (out / "paper.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)]+)\)", markdown)
    assert (
        all(link.startswith("#") or (out / link).is_file() for link in links)
        and len(links) > 3 * len(NAMES) - 1
    )


def test_each_claim_has_its_figure_its_table_and_a_command_that_measures_it_alone(out):
    for name, one in told(out).items():
        with Image.open(out / f"{name}.png") as picture:
            assert picture.width > 300
        rows = list(csv.DictReader((out / f"{name}.csv").open(encoding="utf-8")))
        assert rows and {row["body"] for row in rows} <= {"planar", "walls"}
        program, command, *rest = shlex.split(one["command"])
        assert (program, command) == ("jaxwalk", "paper")
        assert parse(PaperArgs, rest, "paper") == PaperArgs(out, only=(name,))


def test_what_is_measured_is_kept_when_it_is_interrupted_and_used_again(
    measured, tmp_path, monkeypatch, capsys
):
    def interrupted(lab, model):
        raise KeyboardInterrupt

    claims = canned.claims(measured)
    stopping = claims | {"pushes": dataclasses.replace(claims["pushes"], measure=interrupted)}
    with monkeypatch.context() as patch:
        patch.setattr(command, "registry", lambda: stopping)
        assert paper(tmp_path) == 130
    assert {name for name, _ in measured} == {"speed", "filters"} == set(told(tmp_path))
    measured.clear()
    capsys.readouterr()
    assert paper(tmp_path) == 0
    assert {name for name, _ in measured} == set(NAMES) - {"speed", "filters"}
    said = capsys.readouterr().out
    assert "1 of 13: speed: used again, measured 20" in said and "3 of 13: pushes: measured in" in said
    assert tuple(told(tmp_path)) == NAMES


def test_only_what_is_asked_for_is_measured_and_the_rest_stays(measured, tmp_path):
    assert paper(tmp_path, "--only", "pitch") == 0
    assert paper(tmp_path, "--only", "loads", "speed") == 0
    assert {name for name, _ in measured} == {"pitch", "loads", "speed"}
    assert tuple(told(tmp_path)) == ("speed", "pitch", "loads")


def test_new_trainings_are_measured_anew_and_nothing_else_is(measured, tmp_path):
    (tmp_path / "policies").mkdir()
    assert paper(tmp_path) == 0
    measured.clear()
    (tmp_path / "policies" / "pair-1.safetensors").write_bytes(b"another")
    assert paper(tmp_path) == 0
    assert {name for name, _ in measured} == {"state"}


def test_a_verdict_that_somebody_wrote_is_not_believed(measured, tmp_path):
    assert paper(tmp_path, "--only", "pitch") == 0
    path = tmp_path / "paper.json"
    path.write_text(path.read_text().replace('"holds"', '"does not hold"'))
    assert told(tmp_path)["pitch"]["verdict"] == "does not hold"
    measured.clear()
    assert paper(tmp_path, "--only", "pitch") == 0 and measured == []
    assert told(tmp_path)["pitch"]["verdict"] == "holds"


def test_small_samples_are_said_and_fewer_bodies_walk(measured, tmp_path):
    assert paper(tmp_path, "--quick", "True", "--only", "speed", "trade") == 0
    assert measured == [("speed", "planar"), ("speed", "walls"), ("trade", "planar")]
    for kind in ("md", "html"):
        assert "Small samples" in (tmp_path / f"paper.{kind}").read_text(encoding="utf-8")


def spoilt(**changes):
    return lambda content: json.dumps(content | changes)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda content: json.dumps(content)[:-50], "paper.json: not JSON"),
        (lambda content: "[1]", "is no result of jaxwalk paper"),
        (spoilt(made_by="gait"), "was made by jaxwalk gait"),
        (spoilt(policy_digest="0"), "is of another policy, other options or another version"),
        (spoilt(options={"quick": True, "seed": 0}), "is of another policy, other options or"),
        (spoilt(versions={"jaxwalk": "0"}), "is of another policy, other options or another version"),
        (spoilt(versions=3), "is of another policy, other options or another version"),
        (spoilt(claims=3), "holds no claims"),
        (
            lambda content: json.dumps(content).replace('"swing"', '"swung"'),
            "the numbers of pitch are damaged (KeyError",
        ),
    ],
)  # fmt: skip
def test_bad_results_are_one_line_and_stay(measured, tmp_path, capsys, spoil, says):
    assert paper(tmp_path, "--only", "pitch") == 0
    path = tmp_path / "paper.json"
    path.write_text(spoil(json.loads(path.read_text())))
    before = {one: one.read_bytes() for one in tmp_path.iterdir()}
    measured.clear()
    capsys.readouterr()
    assert paper(tmp_path) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1 and "paper.json" in error
    assert {one: one.read_bytes() for one in tmp_path.iterdir()} == before and measured == []


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--only", "speed", "speed"], "--only speed speed: give each claim once"),
        (["--only", "mood"], "mood"),
        (["--seed", "-1"], "--seed -1"),
        (["--policy", "nobody"], "no policy 'nobody'"),
        (["--trained", "nowhere"], "--trained nowhere: there is no such folder"),
        (["--out", "file"], "file is not a folder"),
    ],
)
def test_bad_options_are_one_line(tmp_path, monkeypatch, capsys, options, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    assert cli.main(["paper", "--out", "out", *options]) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_every_claim_has_a_module():
    assert tuple(registry()) == NAMES
