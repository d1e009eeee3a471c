"""``jaxwalk render``: a film, a strip of poses, or a page that replays walks."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import imageio.v2 as imageio
import imageio_ffmpeg
import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont
from rich.console import Console
from rich.progress import track

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.options import lines
from jaxwalk.show import recording, scene, session
from jaxwalk.show.recording import SEGMENT, Loop, Shove, Walk, camera_path
from jaxwalk.show.replay_page import replay
from jaxwalk.show.scene import FADE_SECONDS, Arrow, Stage

if TYPE_CHECKING:
    from jaxwalk.show.render.options import RenderArgs

UPRIGHT, LYING = 0.62, 0.95  # width of a pose in the strip, in units of its height

INK, FAINT, RED = (40, 44, 52), (120, 127, 138), (196, 24, 40)


def film(walk: Walk, stage: Stage, args: RenderArgs, fps: float) -> Iterator[np.ndarray]:
    """The frames, [height, width, 3] bytes each."""
    path = camera_path(walk)
    font = _font(args.height_px / 22)
    margin = args.height_px // 22
    for i in range(int(walk.seconds * fps) + 1):
        second = i / fps
        tick = round(second / walk.timestep)
        shove = walk.pushed(second)
        arrow = Arrow.at(shove, second)
        picture = Image.fromarray(stage.draw(walk.qpos[tick], float(path[tick]), arrow))
        pen = ImageDraw.Draw(picture)
        pen.text((margin, margin), f"{second:.1f} s", INK, font)
        pen.text((args.width - margin, margin), f"{walk.qpos[tick, 0]:.1f} m", INK, font, anchor="ra")
        if shove is not None and second < shove.time + shove.duration + FADE_SECONDS:
            pen.text((args.width // 2, margin), _told(shove), RED, font, anchor="ma")
        elif walk.fell is not None and second >= walk.fell:
            pen.text((args.width // 2, margin), "fell", RED, font, anchor="ma")
        yield np.asarray(picture)


def _told(shove: Shove) -> str:
    return f"push {shove.impulse:+g} N s"


def pose_times(seconds: float, count: int, highlight: float | None) -> np.ndarray:
    """[count] times of a strip's poses, evenly spaced within 0..seconds; one is at ``highlight``, s."""
    if highlight is None:
        return np.linspace(0.0, seconds, count)
    before = round(highlight / seconds * (count - 1))
    after = count - 1 - before
    steps = ([highlight / before] if before else []) + ([(seconds - highlight) / after] if after else [])
    return np.clip(highlight + min(steps) * (np.arange(count) - before), 0.0, seconds)


def strip(walk: Walk, stage: Stage, args: RenderArgs, times: np.ndarray, band: int) -> np.ndarray:
    """Poses side by side over a time axis, [height, width, 3] bytes.

    Args:
      stage: as wide as one pose, and lower than the picture by ``band``.
      times: [P] of the poses, s. band: height of the time axis, pixels.
    """
    path = camera_path(walk)
    picture = Image.new("RGB", (args.width, args.height_px), "white")
    pen, font = ImageDraw.Draw(picture), _font(band * 0.36)
    wide, axis = args.width / len(times), args.height_px - band

    def across(second: float) -> float:
        return wide * ((second - times[0]) / (times[1] - times[0]) + 0.5)

    for i, second in enumerate(times):
        tick = round(second / walk.timestep)
        pose = stage.draw(walk.qpos[tick], float(path[tick]), Arrow.at(walk.pushed(second), second))
        picture.paste(Image.fromarray(pose), (round(i * wide), 0))
        pen.line([across(second), axis, across(second), axis + band // 8], FAINT, 2)
        pen.text(
            (across(second), axis + band * 0.58),
            f"{second:.2f} s, {walk.qpos[tick, 0]:.1f} m",
            INK,
            font,
            anchor="mm",
        )
    for i in range(1, len(times)):
        pen.line([round(i * wide), 0, round(i * wide), axis], "white", 2)
    pen.line([0, axis, args.width, axis], FAINT, 2)
    for shove in walk.pushes:
        left, right = across(shove.time), across(shove.time + shove.duration)
        pen.rectangle([left, axis - 2, max(right, left + 4), axis + band // 6], RED)
        pen.text(((left + right) / 2, band * 0.4), _told(shove), RED, font, anchor="mm")
    if walk.fell is not None:
        pen.text((across(walk.fell), band * 0.9), "fell", RED, font, anchor="mm")
    return np.asarray(picture)


def main(args: RenderArgs) -> None:
    """Run ``jaxwalk render``.

    Raises:
      UserError: no such policy, no OpenGL, or the file cannot be written.
    """
    subject = named.asked(args) if args.session is None else session.subject(args.policy, args.session)
    if args.page:
        _write_page(args, subject)
        return
    scene.choose_backend()  # before the walk, which takes its time
    console = Console(markup=False)
    model = scene.model(subject.config)
    with console.status("walking"):
        walk = _walk(args, subject, model)
    draw = _write_strip if args.out.suffix.lower() == ".png" else _write_film
    try:
        with tempfile.TemporaryDirectory(dir=args.out.parent, prefix=".jaxwalk.") as folder:
            whole = Path(folder) / args.out.name
            draw(whole, walk, partial(Stage, model, subject.config.body.height), args)
            files.replace(args.out, whole.read_bytes())
    except OSError as error:
        reason = error.strerror or _encoder(str(error))
        raise UserError(f"cannot write {args.out}: {reason}") from error
    fell = "" if walk.fell is None else f"; fell at {walk.fell:.1f} s"
    console.print(f"{args.out}: {walk.seconds:.1f} s, {walk.qpos[-1, 0]:.1f} m{fell}", highlight=False)


def _walk(args: RenderArgs, subject: Subject, model: mujoco.MjModel) -> Walk:
    if args.session is not None:
        return session.record(subject, session.read(args.session), model)
    shove = Shove(args.push, args.push_time, args.push_duration, args.push_height) if args.push else None
    return recording.record(Loop(subject, SEGMENT, args.engine), model, args.seconds, args.seed, shove)


def _encoder(said: str) -> str:
    """Of what went wrong with ffmpeg, which says it in many lines, the one that counts."""
    known = subprocess.run([imageio_ffmpeg.get_ffmpeg_exe(), "-encoders"], capture_output=True).stdout
    if b"libx264" not in known:
        return "this ffmpeg lacks libx264; unset IMAGEIO_FFMPEG_EXE, or give --out a name that ends in .gif"
    return next(iter(said.splitlines()), "ffmpeg failed")


def _write_page(args: RenderArgs, subject: Subject) -> None:
    console = Console(markup=False)
    with console.status("walking") as status:
        recorded = replay.record(subject, args.impulses, args.seed, status.update, args.engine)
    page = replay.html(recorded, named.origin(args.policy), lines.line("render", args))
    files.write_bytes(args.out, page)
    worst = replay.verify(args.out, recorded)
    print(
        f"{args.out}: {len(recorded.walks)} walks; loads nothing, read back within {1000 * worst:.2g} mm or "
        "mrad of what was recorded"
    )


def _write_strip(path: Path, walk: Walk, stage_of: Callable[[int, int], Stage], args: RenderArgs) -> None:
    band = max(args.height_px // 10, 24)
    high = args.height_px - band
    poses = max(2, round(args.width / (high * (UPRIGHT if walk.fell is None else LYING))))
    shove = walk.pushed(walk.seconds)
    middle = None if shove is None else min(shove.time + shove.duration / 2, walk.seconds)
    with stage_of(-(-args.width // poses), high) as stage:
        imageio.imwrite(path, strip(walk, stage, args, pose_times(walk.seconds, poses, middle), band))


def _write_film(path: Path, walk: Walk, stage_of: Callable[[int, int], Stage], args: RenderArgs) -> None:
    if path.suffix.lower() == ".gif":
        centiseconds = max(2, round(100 / args.fps))  # a GIF's clock; viewers slow down what is faster
        fps = 100 / centiseconds
        writer = imageio.get_writer(path, mode="I", duration=10 * centiseconds, loop=0)
    else:
        fps = float(args.fps)
        # Or it forks, which JAX's threads do not bear; Ctrl-C then reaches ffmpeg as well, as it may.
        os.environ.setdefault("IMAGEIO_FFMPEG_NO_PREVENT_SIGINT", "1")
        writer = imageio.get_writer(
            path, fps=fps, codec="libx264", quality=8, macro_block_size=2, ffmpeg_log_level="quiet"
        )
    with writer, stage_of(args.width, args.height_px) as stage:
        frames = film(walk, stage, args, fps)
        for frame in track(frames, "drawing", int(walk.seconds * fps) + 1, transient=True):
            writer.append_data(frame)


def _font(size: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(max(size, 9))
