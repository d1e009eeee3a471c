"""The numbers of the step that compliant legs plan by themselves (``jaxwalk.control.compliant.step_plan``),
those of the reference body."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StepPlanConfig:
    """How a step changes with the capture point, and how much of it the policy may change."""

    change_length: float = 0.4
    """Length that a policy may add or take away at most, m."""
    change_duration: float = 0.25
    """Time that a policy may add or take away at most, s."""

    length_gain: float = -0.07845
    """Length for each m that the capture point will be further ahead at the landing."""
    pitch_gain: float = 0.9385
    """Length for each rad that the torso leans forward, m/rad."""
    pitch_least: float = 0.0
    """Pitch that counts for it at least, rad: who falls forward with the torso thrown back needs the foot."""
    duration_gain: float = 0.2236
    """Time by which the step is shorter for each m that the capture point will be further ahead, s/m."""
    length_least: float = 0.15
    """Shortest step ahead that is planned, m."""
    duration_least: float = 0.2942
    """Shortest step that is planned, s."""
    duration_most: float = 0.7
    """Longest step that is planned, s."""

    back_margin: float = 0.06432
    """How far behind the stance ankle the capture point makes the walker step back, m."""
    back_reach: float = -0.01733
    """How far behind `back_gain` times the capture point the foot is put then, m."""
    back_gain: float = 0.5338
    """Share of the capture point's way from the hip."""
    back_least: float = 0.3374
    """How far behind the stance ankle it is put at least, m."""
    back_speed: float = 2.928
    """How fast the foot goes there, m/s."""
    back_beyond: float = 0.0
    """Share of its way back that counts for a foot that is further behind already: it only has to be put
    down."""
    back_time: float = 0.3663
    """Longest time that is left for it, s."""
    back_latest: float = 3.0
    """Time from the touch-down at which a step back is over at the latest, s, whatever `duration_max` is."""
    back_soonest: float = 0.03
    """Shortest time that is left for it, s."""
