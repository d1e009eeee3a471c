"""What walkers of training meet beside pushes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CircumstancesConfig:
    """Circumstances of which walkers draw one for their life, up to these. Of the speed asked for they are
    told, and of the delay; weak motors come with that alone, the weaker the later."""

    share: float = 0.6
    """Share of the walkers that draw one; the others walk as configured."""
    late: int = 4
    """How many times as often as another they draw late instruments on weak motors: bold answers to what is
    told late are wrong ones."""
    speed: float = 0.4
    """Another speed asked for, by so much at most, m/s."""
    pack: float = 25.0
    """A pack on the back or in front, kg."""
    slope: float = 3.0
    """A slope of the floor, up or down, degrees."""
    friction: float = 0.4
    """A floor between this friction and the configured one."""
    noise: float = 4.0
    """Noise of the sensors, times the configured."""
    delay: float = 0.02
    """Instruments of torso and soles told late, s; together with weak motors."""
    strength: float = 0.8
    """Least share of their strength that those motors have."""
