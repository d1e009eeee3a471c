"""Write models/*.xml from the anthropometry: the planar walker, and the paper's boxes in both models.

The package builds its models itself and never reads these files; they are for people,
for MuJoCo's viewer and for other programs. A test fails when they drift from the code.

    python scripts/make_models.py
"""

from __future__ import annotations

import argparse
from pathlib import Path

from jaxwalk.common import runtime
from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import anthropometry, mjcf

FILES = {
    "planar.xml": BodyConfig(),
    "planar_box.xml": BodyConfig(table="box"),
    "biped_walls.xml": BodyConfig(table="box", model="walls"),
}
MODELS = Path(__file__).resolve().parent.parent / "models"


def text(config: BodyConfig) -> str:
    """The default walker of ``config``'s body as MJCF."""
    spec = mjcf.build(anthropometry.build(config), PhysicsConfig(), config.model)
    spec.compile()  # to_xml wants a spec that is known to be sound
    return spec.to_xml()


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--out", type=Path, default=MODELS, help="folder to write to (default: models/)")
    folder = parser.parse_args().out
    folder.mkdir(parents=True, exist_ok=True)
    for name, config in FILES.items():
        (folder / name).write_text(text(config))
        print(folder / name)


if __name__ == "__main__":
    runtime.setup()
    main()
