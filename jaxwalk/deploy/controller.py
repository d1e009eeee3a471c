"""The whole step controller of one walker: sensors in, joint commands out, once a tick."""

from __future__ import annotations

import dataclasses
import os

import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.config import DELAY_MOST
from jaxwalk.deploy import footstep, forms, kinematics, person, policy, sensors, soundness, step_clock
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.policy import Policy
from jaxwalk.deploy.sensors import Estimate, Filter, Sensors
from jaxwalk.deploy.step_clock import Clock


class Controller:
    """A policy, the controllers around it, and where in its step its walker is.

    Call `start` when a foot has just landed ahead of the other, then `tick` every ``timestep`` seconds.
    The policy is asked at each touch-down, within the tick; one that decides steps anew, at the end of the
    decision window, and again every so many windows until the foot lands.

    Args:
      policy: exported.
      height, mass: of the walker, m, kg; default: those that the policy was trained around.
      speed: forward speed to aim at, m/s; default: as trained.
      delay: by which the instruments of torso and soles tell late, s, as you measured it; policies whose
        observation names it are told.

    Attributes:
      timestep: s between ticks.
      touchdown: a foot landed in the last tick; ``action`` is fresh then, if steps are not decided anew.
      observation: [O] what the policy was told last. action: [2] its answer, in [-1, 1].
      clock: where in the step the walker is.
      estimate: what the filters made of the last sensors.
      held: ticks on end whose readings could not be true, see `soundness`; the last good one stands for them.
      passive: they were too many, or the first was one, and the joints are let go until the next `start`.

    Raises:
      UserError: a stature, a mass, a speed or a delay out of range.
    """

    def __init__(
        self,
        policy: Policy,
        height: float | None = None,
        mass: float | None = None,
        speed: float | None = None,
        delay: float = 0.0,
    ) -> None:
        self.policy = policy
        self.person = person.build(policy.manifest, height, mass)
        if speed is not None:
            self.ask(speed)
        self.late(delay)
        self.timestep: float = policy.manifest["timestep"]
        self._dt = np.float32(self.timestep)
        self._gravity = np.float32(policy.manifest["gravity"])
        self._names = tuple(one["name"] for one in policy.manifest["observation"])
        self._form = forms.of(self.person.gait)
        decisions = policy.manifest.get("decisions", {})
        self._replan, self._window = int(decisions.get("replan", 0)), int(decisions.get("window_ticks", 1))
        self._ticks, self._windows, self._fresh = 0, 0, False
        self._hold = soundness.hold_ticks(self.timestep)
        self._filter: Filter | None = None
        self._said = sensors.SILENT
        self.held, self.passive = 0, False
        self.clock: Clock
        self.estimate: Estimate
        self.touchdown = False
        self.observation = np.zeros(len(policy.mean), np.float32)
        self.action = np.zeros(len(policy.low), np.float32)

    def ask(self, speed: float) -> bool:
        """Aim at another forward speed, m/s, from the next tick on; whether the policy was trained for it.

        Raises:
          UserError: it is out of range.
        """
        if not 0.1 <= speed <= 3.0:
            raise UserError(f"speed {speed} m/s: give 0.1 to 3 m/s")
        numbers = dataclasses.replace(self.person.gait, speed_desired=np.float32(speed))
        self.person = dataclasses.replace(self.person, gait=numbers)
        trained = self.policy.manifest["numbers"]["speed_desired"]["value"]
        # Files of before do not tell the speeds: they have one.
        low, high = self.policy.manifest.get("speeds", (trained, trained))
        return bool(low - 1e-6 <= speed <= high + 1e-6)

    def late(self, seconds: float) -> bool:
        """Tell the policy how late instruments of torso and soles tell, s; whether it was trained for that.

        Raises:
          UserError: it is out of range.
        """
        if not 0.0 <= seconds <= DELAY_MOST:
            raise UserError(f"delay {seconds} s: give 0 to {DELAY_MOST:g} s")
        self.person = dataclasses.replace(self.person, delay=np.float32(seconds))
        # Files of before do not tell: none was told.
        return seconds <= self.policy.manifest.get("delay_trained", 0.0) + 1e-6

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        height: float | None = None,
        mass: float | None = None,
        speed: float | None = None,
        delay: float = 0.0,
    ) -> Controller:
        """The controller of an exported .safetensors or .npz file.

        Raises:
          UserError: a bad file, or a value out of range.
        """
        loaded = policy.load(path)
        try:
            return cls(loaded, height, mass, speed, delay)
        except (KeyError, TypeError, ValueError):
            raise UserError(f"policy {path}: its manifest is damaged; export it anew") from None

    def start(self, said: Sensors, stance: int) -> np.ndarray:
        """Begin, or begin again: the foot ``stance`` (0 left, 1 right) has just landed ahead of the other.

        Returns:
          The command, as of `tick`.

        Raises:
          UserError: another stance, sensors of another shape, or angles in degrees.
        """
        if stance not in (0, 1):
            raise UserError(f"stance {stance!r}: give 0 (left) or 1 (right)")
        soundness.check_angles(said)
        heard = soundness.read(said)
        self.held, self.passive, self.touchdown = 0, heard is None, False
        if heard is None:
            return np.zeros(6, np.float32)
        self._said = heard
        self._filter = sensors.start(self.policy.manifest, np.float32(heard.velocity))
        self.estimate = sensors.estimate(heard, self._filter.filtered)
        posture = self._posture()
        fresh = self._form.start(self.person, self._gravity, posture, self.estimate, stance)
        self.clock = fresh
        self._ticks, self._windows, self._fresh = 0, 0, False
        self._length = -step_clock.step_length(posture, fresh)
        self._decide(posture)
        return self._command(posture)

    def tick(self, said: Sensors) -> np.ndarray:
        """One tick: what the instruments say now, to what the joints are to do until the next.

        Returns:
          [6] rigid: hip rate (rad/s), knee angle (rad), ankle torque (N m, dorsiflexion positive);
          compliant: torques of the three, N m; left, right. Of joints that are let go: no torque, no rate,
          a knee as it was last.

        Raises:
          UserError: sensors of another shape.
          RuntimeError: not started.
        """
        if self._filter is None and not self.passive:
            raise RuntimeError("Controller.tick before Controller.start")
        heard = soundness.read(said)
        if heard is None:
            self.held += 1
        else:
            self._said, self.held = heard, 0
        self.passive |= self.held > self._hold
        if self._filter is None or self.passive:
            self.touchdown = False
            return self._form.let_go(self._said)
        self._filter, self.estimate = sensors.step(self._filter, self._said)
        posture, who = self._posture(), self.person
        clock = dataclasses.replace(self.clock, elapsed=self.clock.elapsed + self._dt)
        length = step_clock.step_length(posture, clock)
        where = who, self._gravity, posture, clock, self.estimate
        self.clock, self.touchdown = self._form.proceed(*where, self._dt)
        if self.touchdown:
            self._length = length
        if self._asks():
            self._decide(posture)
        return self._command(posture)

    def _asks(self) -> bool:
        """Whether the policy is asked in this tick."""
        if not self._replan:
            return self.touchdown
        self._ticks += 1
        self._fresh |= self.touchdown
        if self._ticks % self._window:
            return False
        self._windows += 1
        asks = self._fresh or self._windows >= self._replan
        if asks:
            self._windows, self._fresh = 0, False
        return asks

    @property
    def fallen(self) -> bool:
        """As far as the sensors tell: torso too far over, hip too low over the feet, or a stalled step; or
        they tell nothing, and the joints are let go."""
        if self.passive:
            return True
        numbers = self.person.gait
        height = self.person.foot - self._posture().z.min()
        return bool(
            abs(self.estimate.pitch) > numbers.fall_pitch
            or height < numbers.fall_height * self.person.leg
            or self.clock.elapsed > numbers.stall_seconds
        )

    def _posture(self) -> Posture:
        return kinematics.posture(self.person, self.estimate.joints, self.estimate.pitch)

    def _decide(self, posture: Posture) -> None:
        self.observation = footstep.observe(
            self._names, self.person, self._gravity, posture, self.estimate, self.clock, self._length
        )
        self.action = self.policy.act(self.observation)
        length, duration = footstep.to_command(self.person, self.action)
        if self.person.gait.steps == "planned":
            self.clock = dataclasses.replace(self.clock, change=(length, duration))
        else:
            self.clock = dataclasses.replace(self.clock, length=length, duration=duration)

    def _command(self, posture: Posture) -> np.ndarray:
        return self._form.command(self.person, self._gravity, posture, self.clock, self.estimate)
