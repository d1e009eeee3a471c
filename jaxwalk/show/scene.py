"""The stage that a walk is drawn on: MuJoCo's renderer without a screen, the scene, the camera."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.rendering.classic import gl_context

from jaxwalk.common.errors import UserError
from jaxwalk.config import REFERENCE_HEIGHT, Config
from jaxwalk.model import anthropometry, mjcf, pushes
from jaxwalk.model.similarity import Similarity
from jaxwalk.show.recording import Shove

FADE_SECONDS = 0.35  # a push is over within three pictures: its arrow fades more slowly

_BACKENDS = ("egl", "osmesa")  # both draw without a display; EGL is the faster
_PROBE = "import mujoco; mujoco.Renderer(mujoco.MjModel.from_xml_string('<mujoco/>'), 8, 8)"
_MISSING = (
    "OpenGL cannot draw off-screen here: install libegl1 or libosmesa6 (Debian: apt-get install libegl1)"
)

VIEW = 2.3  # m that a picture shows from bottom to top, on the reference body
_LOOK = 0.93  # m, height of the picture's middle, on the reference body
_FOVY = 26.0  # degrees: far away, so that perspective is mild
_AZIMUTH, _ELEVATION = 98.0, -5.0  # degrees: from the right, a little from behind and above

# Blue and orange stay apart for colour-blind eyes, and light against dark in print.
_LEFT, _RIGHT = (0.16, 0.38, 0.70), (0.93, 0.53, 0.16)
_TRUNK, _HEAD, _JOINT, _PUSH = (0.30, 0.34, 0.40), (0.80, 0.68, 0.58), (0.22, 0.24, 0.28), (0.82, 0.08, 0.16)
_SKY, _HORIZON = (0.80, 0.88, 0.95), (0.97, 0.98, 0.99)
_FLOOR, _TILE, _LINE = (0.88, 0.90, 0.92), (0.79, 0.82, 0.85), (0.68, 0.72, 0.76)

# A body that has fallen: joints stay within what knees and hips can do, and only friction moves them.
_RANGES = {
    "hip": (-0.6, 2.1),
    "knee": (0.0, 2.4),
    "ankle": (-0.8, 0.5),
    "abduction": (-0.1, 0.4),
    "inversion": (-0.3, 0.3),
}
_LIMP_DAMPING = 12.0  # N m s/rad, on the reference body


@dataclass(frozen=True)
class Arrow:
    """A push to be drawn.

    Attributes:
      impulse: N s, forward positive.
      height: of the point pushed, above the torso's centre, m.
      strength: 1 while it acts, less as its picture fades.
    """

    impulse: float
    height: float
    strength: float

    @classmethod
    def at(cls, shove: Shove | None, second: float) -> Arrow | None:
        """How a push looks at ``second``; None: not at all, as one of a leg."""
        if shove is None or second < shove.time or shove.place != pushes.TORSO:
            return None
        strength = 1 - max(0.0, second - shove.time - shove.duration) / FADE_SECONDS
        return cls(shove.impulse, shove.height, strength) if strength > 0 else None


def _dress(spec: mujoco.MjSpec) -> None:
    """Looks only: colours, joints, floor, sky and light."""
    for geom in spec.geoms:
        if geom.group == mjcf.DRAWN:
            colours = {"left": _LEFT, "right": _RIGHT, "trunk": _TRUNK, "head": _HEAD}
            geom.rgba = [*colours[geom.name.split("_")[-1]], 1.0]
    for side in mjcf.SIDES:
        for part in ("thigh", "shank", "foot"):
            box = spec.geom(f"{part}_{side}")
            radius = spec.geom(f"shank_{side}").size[0] * (0.9 if part == "foot" else 1.1)
            spec.body(f"{part}_{side}").add_geom(
                type=mujoco.mjtGeom.mjGEOM_CYLINDER,
                fromto=[0, box.pos[1] - 1.04 * box.size[1], 0, 0, box.pos[1] + 1.04 * box.size[1], 0],
                size=[radius, 0, 0],
                rgba=[*_JOINT, 1],
                group=mjcf.DRAWN,
                contype=0,
                conaffinity=0,
                mass=0,
            )
    grid = spec.texture("grid")
    grid.rgb1, grid.rgb2, grid.markrgb = _FLOOR, _TILE, _LINE
    grid.mark, grid.width, grid.height = mujoco.mjtMark.mjMARK_EDGE, 512, 512
    spec.material("grid").texrepeat = [1, 1]  # tiles of half a metre
    spec.material("grid").reflectance = 0.0
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=256, height=1536)
    sky.builtin, sky.rgb1, sky.rgb2 = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, _SKY, _HORIZON
    visual = spec.visual
    visual.rgba.haze = [*_HORIZON, 1]
    visual.global_.fovy = _FOVY
    visual.quality.offsamples, visual.quality.shadowsize = 8, 4096
    visual.map.shadowclip = 3.0  # beyond it the floor is speckled
    visual.headlight.ambient, visual.headlight.diffuse = [0.42] * 3, [0.30] * 3
    visual.headlight.specular = [0.0] * 3
    for light in list(spec.worldbody.lights):
        spec.delete(light)
    # The light goes along with the walker, or its shadow would leave the shadow map.
    spec.body("torso").add_light(
        pos=[-1.5, -2.5, 5],
        dir=[0.28, 0.42, -1],
        mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACK,
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        diffuse=[0.55] * 3,
        specular=[0.15] * 3,
        castshadow=True,
    )


def _let_go(spec: mujoco.MjSpec, damping: float) -> None:
    """No controllers, limits at the joints, and every box lands on the floor."""
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    spec.option.iterations, spec.option.ls_iterations = 50, 20
    spec.geom("floor").conaffinity = 1
    for geom in spec.geoms:
        if geom.group == mjcf.DRAWN and geom.name:
            geom.contype = 1
    for joint in spec.joints:
        limits = _RANGES.get(joint.name.split("_")[0])
        if limits is not None:
            joint.range, joint.limited, joint.damping = (
                limits,
                mujoco.mjtLimited.mjLIMITED_TRUE,
                [damping, 0, 0],
            )


def model(config: Config) -> mujoco.MjModel:
    """The walker of ``config`` in C MuJoCo as it is drawn; stepped, it is a limp body that falls."""
    person = anthropometry.build(config.body)
    spec = mjcf.build(person, config.physics, config.body.model)
    _dress(spec)
    _let_go(spec, _LIMP_DAMPING * Similarity.of(person.height, person.mass).rotational_damping)
    return spec.compile()


class Stage:
    """Draws poses of one model; a context manager that gives the renderer back.

    Args:
      model: from `model`.
      stature: of the walker, m.
      width, height: of the pictures, pixels.

    Raises:
      UserError: no OpenGL that draws off-screen.
    """

    def __init__(self, model: mujoco.MjModel, stature: float, width: int, height: int) -> None:
        choose_backend()
        try:
            self._renderer = mujoco.Renderer(model, height, width, max_geom=200)
        except (ImportError, AttributeError, RuntimeError, mujoco.FatalError) as error:
            raise UserError(
                f"{_MISSING}; MUJOCO_GL={os.environ.get('MUJOCO_GL', '')} says: {error}"
            ) from None
        self._model, self._data = model, mujoco.MjData(model)
        self._scale = stature / REFERENCE_HEIGHT
        self._options = mujoco.MjvOption()
        self._options.sitegroup[:] = 0
        self._camera = mujoco.MjvCamera()
        aim(self._camera, stature)

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_: object) -> None:
        self._renderer.close()

    def draw(self, qpos: np.ndarray, centre: float, arrow: Arrow | None = None) -> np.ndarray:
        """One picture, [height, width, 3] bytes.

        Args:
          qpos: [D] the pose. centre: x of the picture's middle, m.
        """
        self._data.qpos[:] = qpos
        mujoco.mj_forward(self._model, self._data)
        self._camera.lookat[:] = [centre, 0.0, _LOOK * self._scale]
        self._renderer.update_scene(self._data, self._camera, self._options)
        scene = self._renderer.scene
        scene.flags[mujoco.mjtRndFlag.mjRND_HAZE] = True
        if arrow is not None:
            add_arrow(scene, self._model, self._data, arrow, self._scale)
        return self._renderer.render()


def aim(camera: mujoco.MjvCamera, stature: float) -> None:
    """From the right, a little from behind and above, as far off as fits a walker."""
    camera.azimuth, camera.elevation = _AZIMUTH, _ELEVATION
    camera.distance = VIEW * stature / REFERENCE_HEIGHT / (2 * np.tan(np.radians(_FOVY / 2)))


def add_arrow(
    scene: mujoco.MjvScene, model: mujoco.MjModel, data: mujoco.MjData, arrow: Arrow, scale: float
) -> None:
    """A push, drawn onto the walker that ``data`` has posed.

    Args:
      scale: of the walker, against the reference body.
    """
    imu = data.site("imu")
    forward, _, up = imu.xmat.reshape(3, 3).T
    away = -np.sign(arrow.impulse)
    depth = model.geom("trunk").size[0]
    tip = imu.xpos + arrow.height * up + away * depth * forward
    tail = tip + [away * scale * min(0.2 + 0.006 * abs(arrow.impulse), 0.55), 0.0, 0.0]
    geom = scene.geoms[scene.ngeom]
    rgba = np.array([*_PUSH, arrow.strength], np.float32)
    mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_ARROW, np.zeros(3), np.zeros(3), np.eye(3).ravel(), rgba)
    mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_ARROW, 0.035 * scale, tail, tip)
    geom.size[2] = 2 * np.linalg.norm(tip - tail)  # MuJoCo draws an arrow half as long as it says
    geom.emission = 0.4
    scene.ngeom += 1


def choose_backend() -> None:
    """Have MuJoCo draw without a display, unless the user has said how it shall.

    MuJoCo chooses once, as it is first imported, and a choice that fails can end a process: each is
    tried in one of its own.

    Raises:
      UserError: no OpenGL that draws off-screen.
    """
    if sys.platform != "linux" or "MUJOCO_GL" in os.environ:
        return
    for name in _BACKENDS:
        environment = os.environ | {"MUJOCO_GL": name}
        if (
            subprocess.run([sys.executable, "-c", _PROBE], env=environment, capture_output=True).returncode
            == 0
        ):
            os.environ["MUJOCO_GL"] = name
            importlib.reload(gl_context)
            return
    raise UserError(_MISSING)
