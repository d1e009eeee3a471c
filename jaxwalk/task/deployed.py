"""A deployed controller on the walker in C MuJoCo: the loop that a machine would close around it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from jaxtyping import PRNGKeyArray

from jaxwalk.config import Config
from jaxwalk.control import sensors, walker
from jaxwalk.control.person import Person
from jaxwalk.deploy import Sensors
from jaxwalk.model import anthropometry, c_mujoco, physics
from jaxwalk.model.engine import Setup
from jaxwalk.task import scenarios


@runtime_checkable
class Runtime(Protocol):
    """What `jaxwalk.deploy.Controller` and the C header's offer."""

    def start(self, said: Sensors, stance: int) -> np.ndarray:
        """Begin anew: the foot ``stance`` (0 left, 1 right) has just landed; gives what `tick` does."""
        ...

    def tick(self, said: Sensors) -> np.ndarray:
        """[6] hip rate (rad/s), knee angle (rad), ankle torque (N m), or the torques of the three, until the
        next tick; left, right."""
        ...

    @property
    def touchdown(self) -> bool:
        """Whether a foot landed in the last tick."""
        ...


@dataclass
class Walk:
    """What became of a walk.

    Attributes:
      seconds: until it fell, or to the end. fell: it did.
      speed: mean of the hip's over the time after the first 3 s, m/s.

    And, where it is kept:

      said: what the instruments said, tick by tick, the start's first.
      commands: [T, 6] given after each, and landed: [T] a foot landed in it.
      qpos: pose after each, the start first.
      landings: (tick, leg that landed, how far it is ahead of the other, m).
    """

    seconds: float
    fell: bool
    speed: float
    said: list[Sensors] = field(default_factory=list)
    commands: list[np.ndarray] = field(default_factory=list)
    landed: list[bool] = field(default_factory=list)
    qpos: list[np.ndarray] = field(default_factory=list)
    landings: list[tuple[int, int, float]] = field(default_factory=list)


@dataclass(frozen=True)
class Shove:
    """A push: ``impulse`` N s (forward positive) over ``seconds``, ``delay`` s into footstep ``step``."""

    impulse: float
    delay: float
    step: int = 6
    seconds: float = 0.1


_SETTLE = 3.0  # s before the speed is measured


class Instruments:
    """The noisy instruments of `jaxwalk.control.sensors.measure`, in NumPy, as those of ``state`` go on."""

    def __init__(self, config: Config, rng: np.random.Generator, state: sensors.SensorState) -> None:
        self._own, self._rng, self._dt = config.sensors, rng, config.physics.timestep
        self._noise, self._bias = float(state.noise), np.asarray(state.bias)
        self._velocity = float(state.last_velocity)
        self._where = physics.layout(config.body)

    def read(self, data: mujoco.MjData) -> Sensors:
        """What the instruments say of ``data``, biases and noise included; to be called once a tick."""
        own, white = self._own, self._noise * self._rng.standard_normal(18)
        sensed = np.array(data.sensordata)
        before, self._velocity = self._velocity, sensed[0]
        return Sensors(
            velocity=sensed[0] + self._bias[0] + own.velocity_std * white[0],
            acceleration=(sensed[0] - before) / self._dt + self._bias[1] + own.acceleration_std * white[1],
            pitch=np.arctan2(sensed[3], sensed[5]) + self._bias[2] + own.pitch_std * white[2],
            pitch_rate=sensed[7] + own.gyro_std * white[3],
            joints=self._where.sagittal(data.qpos) + own.encoder_std * white[4:10].reshape(2, 3),
            joint_rates=self._where.sagittal(data.qvel) + own.encoder_rate_std * white[10:16].reshape(2, 3),
            touch=sensed[9:11] + own.touch_std * white[16:18],
        )


def walk(
    config: Config,
    runtime: Runtime,
    seconds: float,
    seed: int,
    shove: Shove | None = None,
    tell: Callable[[int], None] = lambda tick: None,
    keep: bool = False,
) -> Walk:
    """Walk ``seconds`` s on the body of ``config``, from a start of `jaxwalk.control.walker.start`.

    Args:
      seed: of the start and of the noise.
      tell: called before each tick.
      keep: what happened, tick by tick, too.
    """
    begun = jax.device_get(start(config, scenarios.root(seed, scenarios.DEPLOYED)).replace(key=None))
    # What the command is for.
    drives = "servo" if config.gait.form == "rigid" else "torque"
    moved_by = dataclasses.replace(config.physics, drives=drives)
    model = physics.compile_mujoco(config.body, c_mujoco.converged(moved_by))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = begun.plant.qpos, begun.plant.qvel
    told = begun.estimate
    said = Sensors(
        told.speed, told.acceleration, told.pitch, told.pitch_rate, told.joints, told.joint_rates, told.touch
    )
    instruments = Instruments(config, np.random.default_rng(seed), begun.sensors)
    command = runtime.start(said, int(begun.gait.stance))
    result = Walk(seconds, False, 0.0, [said], [command], [True], qpos=[data.qpos.copy()])
    feet, stance = [data.body(f"foot_{side}") for side in ("left", "right")], int(begun.gait.stance)
    lowest = config.gait.fall_height * anthropometry.build(config.body).hip_height
    dt = config.physics.timestep
    steps, begin, place = 0, None, 0.0
    elapsed = 0
    for tick in range(round(seconds / dt)):
        tell(tick)
        if shove is not None and begin is None and steps == shove.step:
            begin = tick + round(shove.delay / dt)
        pushed = shove is not None and begin is not None and begin <= tick < begin + round(shove.seconds / dt)
        data.xfrc_applied[1, 0] = shove.impulse / shove.seconds if shove is not None and pushed else 0.0
        data.ctrl[:6] = command  # what is beyond is told to stand still
        mujoco.mj_step(model, data)
        said = instruments.read(data)
        command = runtime.tick(said)
        steps += runtime.touchdown
        elapsed = 0 if runtime.touchdown else elapsed + 1
        if keep:
            result.said.append(said)
            result.commands.append(command)
            result.landed.append(runtime.touchdown)
            result.qpos.append(data.qpos.copy())
        if runtime.touchdown:
            stance = 1 - stance
            ahead = float(feet[stance].xpos[0] - feet[1 - stance].xpos[0])
            result.landings.append((tick + 1, stance, ahead))
        if (tick + 1) * dt <= _SETTLE:
            place = data.qpos[0]
        low = data.qpos[1] < lowest
        leans = abs(data.qpos[2]) > config.gait.fall_pitch
        if low or leans or elapsed * dt > config.gait.stall_seconds or not np.isfinite(data.qpos).all():
            result.seconds, result.fell = (tick + 1) * dt, True
            break
    result.speed = float((data.qpos[0] - place) / max(result.seconds - _SETTLE, dt))
    return result


@partial(jax.jit, static_argnums=0)
def start(config: Config, key: PRNGKeyArray) -> walker.Walker:
    """The walker of ``config`` at its start."""
    person = Person.of(config.gait, jnp.float32(config.body.height), jnp.float32(config.body.mass))
    return walker.start(Setup.of(config), person, key, jnp.float32(config.sensors.noise))
