"""Configurations that differ from a policy's own in one setting of the physics."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, SensorConfig, validate

PARAMETERS = {  # field of the physics -> its option
    "timestep": "--timesteps",
    "iterations": "--iterations",
    "contact_timeconst": "--contact-timeconsts",
    "friction": "--frictions",
}
# White noise of one reading: the longer a tick, the more of it an instrument averages away.
_OF_A_READING = (
    "velocity_std", "acceleration_std", "pitch_std", "gyro_std", "encoder_std", "encoder_rate_std",
    "touch_std", "kalman_velocity", "kalman_acceleration",
)  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """One parameter at one value; ``own`` if that is the policy's."""

    parameter: str
    value: int | float
    own: bool
    config: Config


def settings(config: Config, values: dict[str, tuple[float, ...]]) -> list[Setting]:
    """All that are tried, parameter by parameter, ascending, the policy's own among them.

    Args:
      values: for each of `PARAMETERS`.

    Raises:
      UserError: a value that cannot be simulated.
    """
    found = []
    for parameter, option in PARAMETERS.items():
        own = getattr(config.physics, parameter)
        for value in sorted({*map(type(own), values[parameter]), own}):
            try:
                found.append(Setting(parameter, value, value == own, _changed(config, parameter, value)))
            except UserError as error:
                raise UserError(f"{option} {value:g}: {error}") from None
    return found


def _changed(config: Config, parameter: str, value: int | float) -> Config:
    if parameter == "timestep":
        config = at_timestep(config, value)
    physics = dataclasses.replace(config.physics, **{parameter: value})
    if parameter == "contact_timeconst":  # the heel goes with the toe
        heel = config.physics.heel_timeconst * value / config.physics.contact_timeconst
        physics = dataclasses.replace(physics, heel_timeconst=heel)
    changed = dataclasses.replace(config, physics=physics)
    validate.check(changed)
    return changed


def at_timestep(config: Config, timestep: float) -> Config:
    """The same walker and policy in ticks of ``timestep`` s, all else being the same in seconds.

    The decision window keeps its length. The moving mean keeps its own as nearly as ticks allow;
    noise keeps its density and the Kalman filter its time constants.

    Raises:
      UserError: the decision window is no whole number of such ticks.
    """
    ratio = timestep / config.physics.timestep
    ticks = config.train.window_ticks / ratio
    if not math.isclose(ticks, round(ticks), rel_tol=1e-6) or round(ticks) < 1:
        seconds = config.train.window_ticks * config.physics.timestep
        raise UserError(f"the decision window, {seconds:g} s, is no whole number of such ticks")
    return dataclasses.replace(
        config,
        physics=dataclasses.replace(config.physics, timestep=timestep),
        train=dataclasses.replace(config.train, window_ticks=round(ticks)),
        sensors=_sensors(config.sensors, ratio),
    )


def _sensors(sensors: SensorConfig, ratio: float) -> SensorConfig:
    noise = {name: getattr(sensors, name) / math.sqrt(ratio) for name in _OF_A_READING}
    return dataclasses.replace(
        sensors,
        **noise,
        mean_window=max(1, round(sensors.mean_window / ratio)),
        kalman_process=sensors.kalman_process * math.sqrt(ratio),  # a random walk's change in one tick
    )
