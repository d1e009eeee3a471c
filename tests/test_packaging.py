"""The wheel stands alone: models and all, outside the checkout."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from jaxwalk.common import resources
from jaxwalk.common.errors import UserError

ROOT = Path(__file__).resolve().parent.parent


def test_shipped_models_are_found_in_the_checkout():
    for path in (ROOT / "models").iterdir():
        assert resources.model_path(path.name).read_bytes() == path.read_bytes()
    assert resources.model_path("shipped.safetensors").stat().st_size > 0


@pytest.mark.parametrize("name", ["nobody.xml", "", "."])
def test_a_model_that_does_not_ship_is_named(name):
    with pytest.raises(UserError, match=r"shipped\.safetensors"):
        resources.model_path(name)


@pytest.mark.slow
def test_an_installed_wheel_finds_its_models_outside_the_checkout(tmp_path):
    def run(*command, **settings):
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, **settings)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    build = (
        "import sys; from hatchling.builders.wheel import WheelBuilder;"
        "print(*WheelBuilder(sys.argv[1]).build(directory='.'))"
    )
    wheel = tmp_path / run(sys.executable, "-c", build, ROOT).strip()
    models = {path.name for path in (ROOT / "models").iterdir()}
    packed = zipfile.ZipFile(wheel).namelist()
    assert models == {name.rpartition("/")[2] for name in packed if name.startswith("jaxwalk/models/")}
    assert not [name for name in packed if name.startswith(("tests", "scripts"))]

    # Dependencies come from this environment; the package itself must come from the wheel.
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", site, wheel)
    environment = os.environ | {"PYTHONPATH": str(site)}
    program = (
        "import sys; from jaxwalk.common.resources import model_path as m; "
        "print(*map(m, sys.argv[1:]), sep='\\n')"
    )
    found = run(sys.executable, "-c", program, *models, env=environment).split()
    assert set(map(Path, found)) == {site / "jaxwalk" / "models" / name for name in models}
    assert run(site / "bin" / "jaxwalk", "--help", env=environment).startswith("usage: jaxwalk")
