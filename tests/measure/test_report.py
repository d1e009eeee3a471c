"""``jaxwalk report`` from the outside: what it uses, what it measures, and the page that comes of it."""

from __future__ import annotations

import html.parser
import io
import json
import re
import shlex
import shutil
from typing import Any

import numpy as np
import pytest
from PIL import Image

from jaxwalk import cli
from jaxwalk.common import figures, files, resources
from jaxwalk.learn.policies import named, provenance
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.push_map import summary
from jaxwalk.measure.push_map.capturability import Pendulum
from jaxwalk.measure.push_map.grid import Grid
from jaxwalk.measure.push_map.table import Table
from jaxwalk.measure.report.options import Name, ReportArgs
from jaxwalk.measure.report.parts import PARTS
from jaxwalk.options.parse import parse

CANNED = (
    "compare",
    "evaluate",
    "generalise",
    "sensitivity",
    "agreement",
)  # what stands on `evaluation.evaluate` alone
VOID = {"area", "br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}


def canned(subject, args, tell=None, programs=None, burden=None):
    """An evaluation of known outcome: pushes of 50 N s and less are survived, by ``fixed`` of 40."""
    limit = 40 if subject.name == "fixed" else 50
    impulses = sorted(args.impulses)
    survival = [[1.0 if abs(x) <= limit else 0.25] * args.phases for x in impulses]
    both = {"forward": float(limit), "backward": float(limit)}
    found = {
        "walking": {
            "survival": 1.0, "speed_mean": 1.009, "speed_std": 0.01, "step_length_mean": 0.454,
            "step_duration_mean": 0.446, "torso_pitch_mean": 0.09, "torso_pitch_amplitude": 0.05,
        },
        "pushes": {
            "impulses": impulses, "phases": [i / args.phases for i in range(args.phases)],
            "survival": survival, "steady": survival,
            "recovery_seconds": [[2.0 if abs(x) <= 50 else None] * args.phases for x in impulses],
            "impulse_delivered": impulses,
        },
        "threshold": both,
        "threshold_worst_phase": both,
    }  # fmt: skip
    return found | provenance.stamp("evaluate", args, subject, subject.config)


def push_map():
    grid = Grid((-40.0, 40.0, 60.0), (0.0, 0.5), ("torso",), (0.1,), 4, 0)
    table = Table.empty(grid, {})
    survived = np.ones(grid.shape, bool)
    survived[0, 0, 2, 1] = False  # 60 N s at half of the step
    table.columns["survived"][:] = survived.ravel()
    table.columns["recovery_seconds"][:] = 1.5
    pendulum = Pendulum(
        height=1.05, mass=75.0, step=0.45, seconds=0.45, longest=0.8, shortest=0.1, half_foot=0.15
    )
    return summary.summarise(table, pendulum)


def gait():
    people = {"mean": 1.2, "low": 1.1, "high": 1.3, "source": "Nobody 2000"}
    speed = {"unit": "m/s", "mean": 1.0, "sd": 0.01, "human": people}
    return {
        "walkers": 8, "fell": 1, "strides": {"left": 30, "right": 31}, "strides_left_out": 0,
        "measures": {"speed": speed, "step_length": {"unit": "m", "mean": 0.45, "sd": 0.02}},
        "symmetry": {"step_length": {"mean": -0.5, "mean_size": 1.5}},
        "sources": {"Nobody 2000": "a book"},
    }  # fmt: skip


def bench():
    rate = {"physics_steps_per_second": 84309.3, "footsteps_per_second": None, "updates_per_second": None}
    return {
        "programs": {"mjx_step": rate, "tick": {**rate, "footsteps_per_second": 333.7}},
        "ratios": {"tick/mjx_step": 0.91},
        "checkpoint": {"seconds": 0.3, "every_seconds": 60.0, "share": 0.005},
        "walkers": 256,
    }


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Results of the policy ``shipped`` that no command needs to be run for."""
    folder, subject = tmp_path_factory.mktemp("stored"), named.load("shipped")
    loaded = named.load("shipped", speed=1.0, noise=1.0)
    results: list[tuple[Name, dict[str, Any], named.Subject | None]] = [
        ("push-map", push_map(), subject), ("gait", gait(), loaded), ("bench", bench(), None),
    ]  # fmt: skip
    for name, content, who in results:
        part = PARTS[name]
        (folder / name).mkdir()
        args = part.args("shipped", folder, quick=False, seed=7)
        stamp = provenance.stamp(name, args, who, (who or subject).config)
        files.write_json(folder / name / part.json, content | stamp)
        if part.png:
            Image.new("RGB", (600, 300), "white").save(folder / name / part.png)
    return folder


@pytest.fixture
def folder(stored, tmp_path):
    return shutil.copytree(stored, tmp_path / "results")


@pytest.fixture
def asked(monkeypatch):
    """Evaluations are canned, pictures blank; gives the options of each."""
    calls, blank = [], io.BytesIO()
    Image.new("RGB", (60, 30), "white").save(blank, format="png")
    monkeypatch.setattr(figures, "png", lambda figure: blank.getvalue())

    def recorded(subject, args, *rest, **more):
        calls.append(args)
        return canned(subject, args, *rest, **more)

    monkeypatch.setattr(evaluation, "evaluate", recorded)
    return calls


class Document(html.parser.HTMLParser):
    """Tags in balance, and what they carry."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.words = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def report(out, folder, *options, policy="shipped"):
    return cli.main(["report", str(policy), "--out", str(out), "--results", str(folder), *options])


@pytest.fixture(scope="module")
def page(stored, tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    shutil.copytree(stored, folder / "results")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluation, "evaluate", canned)
        assert report(folder / "page.html", folder / "results") == 0
    return folder / "page.html"


@pytest.fixture(scope="module")
def document(page):
    return Document(page.read_text(encoding="utf-8"))


def test_the_page_is_whole_and_stands_alone(page, document):
    text = page.read_text(encoding="utf-8")
    assert document.open == [] and text.startswith("<!DOCTYPE html>")
    assert page.stat().st_size < 3 * 2**20
    used = [
        tags[name] for _, tags in document.tags for name in ("src", "href", "srcset", "data") if name in tags
    ]
    assert used and all(one.startswith(("data:image/png;base64,", "#")) for one in used)
    assert "url(" not in text and "@import" not in text
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in document.tags}
    anchors = [tags["id"] for _, tags in document.tags if "id" in tags]
    assert len(set(anchors)) == len(anchors) and set(PARTS) <= set(anchors)
    assert {one[1:] for one in used if one.startswith("#")} <= set(anchors)
    assert ("meta", {"name": "viewport", "content": "width=device-width, initial-scale=1"}) in document.tags


def test_every_picture_is_described_and_has_its_size(document):
    pictures = [tags for tag, tags in document.tags if tag == "img"]
    assert len(pictures) == sum(part.png is not None for part in PARTS.values())
    for tags in pictures:
        assert len(tags["alt"]) > 30 and int(tags["width"]) > 0 and int(tags["height"]) > 0


def test_tables_are_as_wide_as_their_headings(page):
    for table in re.findall(r"<table>.*?</table>", page.read_text(encoding="utf-8"), re.DOTALL):
        rows = [len(re.findall(r"<t[hd]\b", row)) for row in re.findall(r"<tr>.*?</tr>", table, re.DOTALL)]
        assert len(rows) > 1 and len(set(rows)) == 1


def test_the_page_says_the_known_numbers(document):
    said = document.text
    assert "50 N s forward and 50 N s backward at the worst phase" in said  # of the canned evaluation
    assert "shipped beats fixed at the worst phase in both directions" in said
    assert "40 N s forward and 40+ N s backward at the worst phase" in said  # of the map: 60 fails at 0.5
    assert "30 left and 31 right strides of 8 walkers, of whom 1 fell" in said
    assert "Of 1 measures whose range in people is known, 0 lie within it" in said
    assert "tick at 0.91" in said
    assert "of the walkers of fixed stay up in 36 of 36" in said
    # Wilson, 95 %: 16 of 16 is [0.806, 1]; cells that agree fully overlap.
    assert "overlap in 100.0 % of 72 cells" in said
    assert named.load("shipped").digest in said
    origin = named.origin("shipped")
    assert origin is not None and origin.command in said
    assert "Small samples" not in said


def test_the_headline_sets_the_policy_beside_the_step_that_is_never_adapted(page):
    first = re.findall(r"<table>.*?</table>", page.read_text(encoding="utf-8"), re.DOTALL)[0]
    rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in first.split("<tr>")[1:]]
    assert rows[0] == ["", "shipped", "fixed"]
    assert ["speed, m/s", "1.009", "1.009"] in rows
    assert ["push survived forward, worst phase, N s", "50", "40"] in rows


def test_each_command_gives_the_options_that_its_results_were_made_with(page):
    text = page.read_text(encoding="utf-8")
    for name, part in PARTS.items():
        section = text.partition(f'<section id="{name}">')[2].partition("</section>")[0]
        line = html.unescape(re.sub("<.*?>", "", re.findall(r"<code>(.*?)</code>", section)[0]))
        program, command, *rest = shlex.split(line)
        assert (program, command) == ("jaxwalk", name)
        args = parse(part.kind, rest, name)
        kept = json.loads((page.parent / "results" / name / part.json).read_text())["options"]
        assert json.loads(files.to_json({option: getattr(args, option) for option in kept})) == kept
        assert part.place(page.parent / "results").items() <= vars(args).items()


def test_only_what_is_missing_is_measured_and_what_is_there_stays(folder, asked, tmp_path):
    before = {path: path.read_bytes() for path in folder.rglob("*.*")}
    assert report(tmp_path / "p.html", folder, "--parts", "gait", "agreement", "push-map") == 0
    assert [args.engine for args in asked] == ["mjx", "mujoco"]
    assert {path: path.read_bytes() for path in before} == before
    assert report(tmp_path / "q.html", folder, "--parts", "gait", "agreement", "push-map") == 0
    assert len(asked) == 2
    # In the page's own order, whatever that of the options; and only those.
    sections = re.findall(r'<section id="([\w-]+)">', (tmp_path / "q.html").read_text(encoding="utf-8"))
    assert sections == ["push-map", "agreement", "gait", "how", "configuration"]


def test_an_interrupted_report_goes_on(folder, asked, monkeypatch, tmp_path, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("jaxwalk.measure.agreement.command.main", interrupted)
        assert report(tmp_path / "p.html", folder) == 130
    assert not (tmp_path / "p.html").exists()
    assert {path.parent.name for path in folder.glob("*/*.json")} == set(PARTS) - {"agreement"}
    asked.clear()
    assert report(tmp_path / "p.html", folder) == 0
    assert [args.engine for args in asked] == ["mjx", "mujoco"]


def test_small_samples_are_said(folder, asked, tmp_path):
    assert report(tmp_path / "p.html", folder, "--quick", "True", "--seed", "5") == 0
    assert asked[0].walkers < PARTS["compare"].kind.walkers and {args.seed for args in asked} == {5}
    said = Document((tmp_path / "p.html").read_text(encoding="utf-8")).text
    titles = ", ".join(PARTS[name].title for name in PARTS if name in CANNED)
    assert f"than a full report: {titles}." in said.replace("&#39;", "'")
    # Small results that are there are not taken for full ones, whoever asks.
    assert report(tmp_path / "q.html", folder) == 0
    assert "Small samples" in (tmp_path / "q.html").read_text(encoding="utf-8")


def test_a_name_is_text_and_never_markup(folder, tmp_path):
    policy = tmp_path / "<b>a&b<script>.safetensors"
    shutil.copy(resources.model_path("shipped.safetensors"), policy)
    assert report(tmp_path / "p.html", folder, "--parts", "bench", "push-map", policy=policy) == 0
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "<script" not in text and "&lt;script&gt;" in text
    assert Document(text).open == []


def edited(**changes):
    def edit(path):
        path.write_text(json.dumps(json.loads(path.read_text()) | changes))

    return edit


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda path: path.write_text(path.read_text()[:-200]), "map.json: not JSON"),
        (lambda path: path.write_bytes(b"\xff\xfe"), "map.json: not UTF-8 text"),
        (lambda path: path.write_text("[1]"), "is no result of jaxwalk push-map"),
        (edited(format=2), "has format 2, this version reads 1"),
        (edited(made_by="gait"), "was made by jaxwalk gait"),
        (edited(policy_digest="0" * 64), "is of another policy or configuration than shipped"),
        (edited(config={"gait": {"speed_desired": 2}}), "of another policy or configuration than shipped"),
        (edited(options={"policy": "shipped", "colour": "red"}), "unknown field colour"),
        (edited(maps=[]), "is no result of jaxwalk push-map (IndexError"),
        (edited(versions="many"), "is no result of jaxwalk push-map (AttributeError"),
        (lambda path: path.with_suffix(".png").unlink(), "map.png: No such file"),
        (lambda path: path.with_suffix(".png").write_bytes(b"no picture"), "map.png: cannot identify image"),
    ],
)  # fmt: skip
def test_bad_results_are_one_line_and_nothing_is_written(folder, asked, tmp_path, capsys, spoil, says):
    spoil(folder / "push-map" / "map.json")
    before = {path: path.read_bytes() for path in folder.rglob("*.*")}
    out = tmp_path / "p.html"
    out.write_text("older")
    assert report(out, folder) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1 and "map" in error
    assert out.read_text() == "older" and asked == []
    assert {path: path.read_bytes() for path in folder.rglob("*.*")} == before


def test_results_of_another_policy_are_not_used(folder, asked, tmp_path, capsys):
    assert report(tmp_path / "p.html", folder, policy="fixed") == 2
    assert "is of another policy or configuration than fixed" in capsys.readouterr().err
    assert not (tmp_path / "p.html").exists() and asked == []


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--out", "page.pdf"], "--out page.pdf: give a file that ends in .html"),
        (["--out", "no/such/page.html"], "there is no folder no/such"),
        (["--out", "p.html", "--parts", "gait", "gait"], "--parts gait gait: give one or more, each once"),
        (["--out", "p.html", "--parts", "mood"], "'mood'"),
        (["--out", "p.html", "--seed", "-1"], "--seed -1"),
        (["--out", "p.html", "--results", "file"], "file is not a folder"),
    ],
)
def test_bad_options_are_one_line(tmp_path, monkeypatch, capsys, options, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    assert cli.main(["report", "fixed", *options]) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_results_lie_beside_the_page():
    args = parse(ReportArgs, ["fixed", "--out", "runs/page.html"], "report")
    assert str(args.folder) == "runs/page" and args.parts == tuple(PARTS)
