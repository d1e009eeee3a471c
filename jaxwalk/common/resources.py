"""Files that ship with the package: the MJCF models and the trained policy."""

from __future__ import annotations

from pathlib import Path

from jaxwalk.common.errors import UserError

_PACKAGE = Path(__file__).resolve().parents[1]
# A wheel carries models/ inside the package; a checkout has it beside the package.
_FOLDERS = (_PACKAGE / "models", _PACKAGE.parent / "models")


def model_path(name: str) -> Path:
    """Where a shipped file lies, e.g. ``shipped.safetensors`` or ``planar.xml``.

    Raises:
      UserError: no such file ships.
    """
    for folder in _FOLDERS:
        path = folder / name
        if path.is_file():
            return path
    shipped = sorted(path.name for folder in _FOLDERS if folder.is_dir() for path in folder.iterdir())
    raise UserError(f"no model {name!r} in this installation: give one of {', '.join(shipped) or '(none)'}")
