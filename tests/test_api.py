"""The names that ``import jaxwalk`` offers: cheap to import, and at work from wherever they are called."""

import asyncio
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import jaxwalk as jw

TEST = jw.PushTest(walkers=4, seconds=5.0, impulses=(-20.0,), phases=2, replicas=2)


def test_importing_fetches_nothing_and_every_name_is_there():
    program = (
        "import sys, jaxwalk; assert not {'jax', 'numpy', 'mujoco'} & set(sys.modules), 'imported';"
        "assert set(jaxwalk.__all__) == set(dir(jaxwalk));"
        "[getattr(jaxwalk, name) for name in jaxwalk.__all__]"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
    with pytest.raises(AttributeError, match="no attribute 'trian'"):
        _ = jw.trian
    assert all(getattr(jw, name).__doc__ for name in jw.__all__)


@pytest.fixture(scope="module")
def found():
    return jw.evaluate("replan", TEST)


def test_an_evaluation_is_plain_values(found):
    assert found["walking"]["survival"] == 1.0 and 0.9 < found["walking"]["speed_mean"] < 1.1
    assert np.shape(found["pushes"]["survival"]) == (1, 2)


def test_a_thread_and_a_running_event_loop_find_the_same(found):
    """As of a server and of a notebook."""
    told = []
    thread = threading.Thread(target=lambda: told.append(jw.evaluate("replan", TEST)))
    thread.start()
    thread.join()

    async def cell():
        return jw.evaluate(jw.load_policy("replan"), TEST)

    assert told == [found] and asyncio.run(cell()) == found


def test_a_process_that_has_used_jax_before_can_go_on():
    program = (
        "import jax; jax.numpy.ones(3).sum().block_until_ready(); count = jax.device_count();"
        "import jaxwalk as jw; jw.FootstepEnv(); assert jax.device_count() == count"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda out: jw.preset("defualt"), "no preset 'defualt': give one of default"),
        (lambda out: jw.load_policy("nobody"), "no policy 'nobody'"),
        (lambda out: jw.load_policy(height=9.0), "9.0 m"),
        (lambda out: jw.load_policy(speed=50.0), "speed 50: give 0.1 to 3 m/s"),
        (lambda out: jw.evaluate("fixed", jw.PushTest(walkers=0)), "walkers 0: give"),
        (lambda out: jw.push_map("fixed", out, phases=0), "phases 0: give"),
        (lambda out: jw.push_map("fixed", out, points=("nose",)), "'nose' is no point"),
        (lambda out: jw.push_map("fixed", out, impulses=(40.0, -40.0)), "give ascending numbers"),
        (lambda out: jw.export_policy(jw.load_policy(height=1.6), out), "was changed"),
        (lambda out: jw.train(jw.Config(), out, seeds=0), "seeds 0"),
        (
            lambda out: jw.export_policy("shipped", out, formats=("pt",)),
            "give a tuple of some",
        ),
        (lambda out: jw.export_policy("fixed", out), "not trained"),
        (lambda out: jw.train(jw.Config(), out, seed=-1), "seed -1"),
        (lambda out: jw.resume(out), "give a run folder"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, wrong, says):
    with pytest.raises(jw.UserError, match=says) as error:
        wrong(tmp_path / "out")
    assert "\n" not in str(error.value) and not (tmp_path / "out").exists()


def test_every_name_is_offered_and_documented():
    from jaxwalk import api

    assert {*api.__all__, "__version__"} == set(jw.__all__)
    page = (Path(__file__).parent.parent / "docs" / "api.md").read_text()
    assert all(name in page for name in api.__all__)
