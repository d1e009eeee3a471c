"""What a map says of trials whose outcome is known."""

import dataclasses

import numpy as np
import pytest

from jaxwalk.common import figures
from jaxwalk.measure.push_map import picture, summary
from jaxwalk.measure.push_map.capturability import Pendulum
from jaxwalk.measure.push_map.grid import Grid
from jaxwalk.measure.push_map.table import Table

GRID = Grid((-40.0, -20.0, 20.0, 40.0, 60.0), (0.0, 0.5), ("torso", "torso+0.2", "swing-shank"), (0.1,), 4, 0)
PENDULUM = Pendulum(1.0, 75.0, 0.6, 0.6, 0.8, 0.3)


def table(fell):
    """A finished table; of the four walkers for which ``fell(point, impulse, phase)``, three fall."""
    found = Table.empty(GRID, {})
    columns = GRID.columns()
    down = np.array(
        [
            fell(where, i, p)
            for where, i, p in zip(columns["point"], columns["impulse"], columns["phase"], strict=True)
        ]
    )
    down[3::4] = False  # the last replica always survives
    found.columns["survived"] = ~down
    found.columns["recovery_seconds"] = np.where(down, np.nan, 2.0).astype(np.float32)
    found.columns["impulse_delivered"] = columns["impulse"]
    found.done[:] = True
    return found


@pytest.fixture(scope="module")
def result():
    def fell(point, impulse, phase):
        return point == "torso" and (impulse == -40 or (impulse >= 40 and phase == 0.5))

    return summary.summarise(table(fell), PENDULUM)


def test_trials_are_in_the_grids_order():
    columns = GRID.columns()
    assert GRID.size == 3 * 5 * 2 * 4 == len(columns["impulse"])
    assert columns["point"][:80].tolist() == ["torso"] * 40 + ["torso+0.2"] * 40
    assert columns["impulse"][:8].tolist() == [-40.0] * 8
    assert columns["phase"][:8].tolist() == [0.0] * 4 + [0.5] * 4


def test_survival_and_its_interval(result):
    centre = result["maps"][0][0]
    assert centre["survival"] == [[0.25, 0.25], [1, 1], [1, 1], [1, 0.25], [1, 0.25]]
    # Wilson by hand, z^2 = 3.84146: 4 of 4 survive in at least 1 / (1 + z^2 / 4) = 0.51011.
    assert centre["low"][1][0] == pytest.approx(0.51011, abs=1e-4)
    assert centre["high"][1][0] == 1.0
    assert centre["recovery_seconds"][0][0] == 2.0


def test_thresholds_of_all_phases_each_and_the_worst(result):
    told = result["maps"][0][0]["threshold"]
    assert told["all_phases"]["forward"] == {"impulse": 20.0, "per_kg": 20 / 75, "censored": False}
    assert told["all_phases"]["backward"] == {"impulse": 20.0, "per_kg": 20 / 75, "censored": False}
    # At phase 0 all of the grid was survived: the walker's limit is beyond it.
    assert told["each_phase"][0]["forward"] == {"impulse": 60.0, "per_kg": 0.8, "censored": True}
    assert told["each_phase"][1]["forward"]["impulse"] == 20.0
    assert told["worst_phase"]["forward"]["impulse"] == 20.0
    above = result["maps"][0][1]["threshold"]
    assert above["worst_phase"]["backward"] == {"impulse": 40.0, "per_kg": 40 / 75, "censored": True}


def test_the_share_of_the_limit(result):
    centre = result["maps"][0][0]
    # B is 95 and 161 N s, C 25 and 65 N s for this pendulum, to the nearest N s.
    assert centre["share_of_limit"]["forward"] == pytest.approx([60 / 95, 20 / 161], rel=5e-3)
    assert centre["share_of_limit"]["backward"] == pytest.approx([20 / 25.4, 20 / 65], rel=8e-3)


def test_abilities_are_those_of_survivors():
    found = table(lambda point, impulse, phase: impulse in (60, -20))
    up = found.columns["survived"]
    found.columns["longest"] = np.where(up, 0.7, 5.0).astype(np.float32)
    # A step back is quick; it is no step ahead.
    ahead = up & (GRID.columns()["impulse"] > 0)
    found.columns["shortest"] = np.where(ahead, 0.4, 0.01).astype(np.float32)
    assert summary.abilities(found) == pytest.approx((0.7, 0.4))
    nobody = dataclasses.replace(found, columns=found.columns | {"survived": np.zeros(GRID.size, bool)})
    assert summary.abilities(nobody) == (0.0, 0.0)


def test_the_picture_is_drawn(result, tmp_path):
    from PIL import Image

    figures.write_png(picture.draw(result, "a map"), tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as image:
        assert min(image.size) > 300
        assert len(image.convert("RGB").resize((64, 64)).getcolors(4096) or []) > 20
