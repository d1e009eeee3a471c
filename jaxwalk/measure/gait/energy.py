"""Where the work of a stride goes: by joint, given and taken, and what of it cancels within a leg.

All work is divided by body weight times stride length, J/(N m): the sum is the cost of transport.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from jaxwalk.config import GRAVITY
from jaxwalk.measure.gait import signals
from jaxwalk.measure.gait.record import Ticks
from jaxwalk.measure.gait.strides import Cycle

COST = "J/(N m)"
UNITS = {
    "cost_of_transport": COST,
    "cost_of_transport_filtered": COST,
    "cost_of_transport_by_leg": COST,
    "cost_of_transport_net": COST,
    **{f"{joint}_work_{kind}": COST for joint in signals.JOINTS for kind in ("positive", "negative")},
    "swing_work_share": "%",
    "damping_loss": COST,
    "contact_loss": COST,
}
DEFINITION = (
    "Cost of transport: the actuators' positive work to body weight times stride length; filtered: that "
    "of the power curves, low-passed as a laboratory's are, passive damping included; by leg: of the "
    "summed power of a leg's three joints, so that what one gives while another takes it counts once; "
    "net: positive less negative. Work by joint: of both legs' actuators, sizes; the positive ones sum up"
    " to the cost of transport. Swing work share: of a leg's positive work what it does in the air. "
    "Damping and contact loss: what passive ankle damping, and landing, sliding and sinking take; they "
    "sum up to the net cost."
)


def of_cycle(
    ticks: Ticks,
    told: Mapping[str, Float[np.ndarray, "T 2"]],
    cycle: Cycle,
    length: float,
    timestep: float,
    mass: float,
) -> dict[str, float]:
    """Each of `UNITS`, over one cycle of ``length`` m.

    Args:
      told: `signals.of_walker`'s.
    """
    whole, off = slice(cycle.start, cycle.stop), cycle.toe_off - cycle.start
    forces = ticks.forces
    rates = np.asarray(forces.rates[whole], np.float64)
    power = np.asarray(forces.torque[whole]) * rates  # [T, 2, 3] W
    damping = np.asarray(forces.damping[whole]) * rates[..., 2]
    given, taken = np.maximum(power, 0), np.maximum(-power, 0)
    filtered = sum(np.maximum(told[f"{joint}_power"][whole], 0).sum() for joint in signals.JOINTS)
    own = given[:, cycle.side]
    per_weight = timestep / (mass * GRAVITY * length)
    by_joint = {}
    for i, joint in enumerate(signals.JOINTS):
        by_joint[f"{joint}_work_positive"] = given[..., i].sum() * per_weight
        by_joint[f"{joint}_work_negative"] = taken[..., i].sum() * per_weight
    return {
        "cost_of_transport": given.sum() * per_weight,
        "cost_of_transport_filtered": filtered * timestep / (GRAVITY * length),
        "cost_of_transport_by_leg": np.maximum(power.sum(-1), 0).sum() * per_weight,
        "cost_of_transport_net": power.sum() * per_weight,
        **by_joint,
        "swing_work_share": 100 * own[off:].sum() / own.sum(),
        "damping_loss": -damping.sum() * per_weight,
        "contact_loss": -np.asarray(forces.contact_power[whole], np.float64).sum() * per_weight,
    }
