"""Simulation and controller in one process, without ROS: what the nodes in lock-step must do, bit for bit."""

from __future__ import annotations

from jaxwalk.ros.simulation import Simulation
from jaxwalk.ros.watch import Keeper


def commands(simulation: Simulation, keeper: Keeper, ticks: int) -> list[tuple[float, ...]]:
    """The command that each of ``ticks`` ticks was made with, [6] N m each."""
    given = []
    for _ in range(ticks):
        given.append(keeper.answer(simulation.frame))
        simulation.tick(given[-1])
    return given
