"""The numbers of the compliant controllers (``jaxwalk.control.compliant``), those of the reference body."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CompliantConfig:
    """Impedances, push-off and swing. Angles: hip forward, knee flexed, ankle dorsiflexed are positive."""

    hip_damping: float = 131.2
    """Servo of the stance hip's rate, N m s/rad."""
    pitch_nominal: float = 0.0997
    """phi0 of eq. 13: torso's pitch beyond `pitch_offset` at which the hip turns as the leg does, rad."""
    pitch_offset: float = -0.02588
    """Torso's pitch at which the stance hip is told to stand still, rad."""
    pitch_capture_gain: float = -0.02281
    """How much further forward the torso is to lean for each m that the capture point is too far, rad/m."""
    hip_rate_max: float = 6.177
    """Largest hip rate that the stance controller asks for, rad/s."""
    hip_speed_min: float = 1.404
    """The stance controller never takes the hip to be slower than this, m/s."""

    knee_stiffness: float = 960.8
    """Of the stance knee, N m/rad."""
    knee_damping: float = 61.66
    """Of the stance knee, N m s/rad."""
    knee_loading: float = 0.2743
    """Flexion about which the stance knee yields as it takes the load, rad."""
    knee_standing: float = 0.3088
    """The same from `knee_seconds` on, rad."""
    knee_seconds: float = 0.3929
    """Time from touch-down in which it goes from the one to the other, s."""

    ankle_stiffness: float = 481.5
    """Of the stance ankle beyond `ankle_slack`, N m/rad."""
    ankle_slack: float = 0.1071
    """Dorsiflexion from which on the stance ankle's spring acts, rad."""
    ankle_damping: float = 12.91
    """Of the stance ankle, N m s/rad."""
    ankle_capture_gain: float = 174.5
    """Plantarflexion torque for each m that the capture point will be too far at the landing, N m/m: it moves
    the centre of pressure under it."""

    push_off_angle: float = 0.09492
    """The stance leg's angle behind the vertical at which push-off begins, rad."""
    push_off_ramp: float = 0.3604
    """Angle over which it comes to its whole torque, rad."""
    push_off_torque: float = 108.9
    """Of a walker at the speed desired, N m."""
    push_off_gain: float = 135.5
    """Torque for each m/s that it is slower, N m s/m."""
    push_off_ankle: float = 0.2749
    """Plantarflexion at which push-off ends, rad."""
    push_off_share: float = 1.05
    """Share of the speed desired at which push-off is `push_off_torque`."""
    toe_off_seconds: float = 0.1073
    """Time after the other foot's touch-down in which the trailing leg still pushes, its hip limp, s."""

    swing_stiffness: float = 493.9
    """Of the swing hip about its path, N m/rad."""
    swing_damping: float = 110.2
    """Of the swing hip about its path's rate, N m s/rad."""
    swing_pitch_gain: float = 1.092
    """Share of the torso's pitch added to the swing hip's target (1: the thigh's angle to the vertical)."""
    swing_rate_max: float = 9.725
    """Largest rate of the swing hip's path, rad/s."""
    swing_knee: float = 0.7971
    """Flexion of the swing knee while the foot passes, rad."""
    swing_knee_stiffness: float = 22.46
    """Its stiffness, N m/rad."""
    swing_knee_damping: float = 1.196
    """Its damping, N m s/rad."""
    knee_stop: float = 300.0
    """Stiffness with which ligaments keep the knee in the air from bending forward, N m/rad."""
    toe_off_knee_share: float = 0.3
    """Share of `swing_knee` that the trailing knee is pulled to while it pushes."""
    landing_knee: float = 0.2127
    """Flexion with which the swing leg lands, rad."""
    landing_knee_stiffness: float = 303.8
    """Its stiffness, N m/rad."""
    landing_knee_damping: float = 11.43
    """Its damping, N m s/rad."""
    landing_seconds: float = 0.03772
    """Time before the landing in which the knee straightens, s."""
    swing_sole: float = -0.1585
    """Angle of the swing foot's sole to the floor, toes up positive, rad."""
    swing_ankle_most: float = 0.1911
    """Largest dorsiflexion that it is turned to for that, rad."""
    swing_ankle_stiffness: float = 77.0
    """Of the ankle in the air, N m/rad."""
    swing_ankle_damping: float = 1.5
    """Of the ankle in the air, N m s/rad."""

    landing_time: float = 0.5145
    """Time of a step at which the error of the capture point is told, s: that of steady walking."""
    landing_capture: float = 0.5983
    """How far ahead of the stance ankle the capture point then is in steady walking, m."""
    landing_share: float = 0.55
    """Share of the step's time before which a contact ahead is no touch-down."""
    passing_seconds: float = 0.05
    """Time after toe-off before which a contact is no touch-down, s."""
    back_ahead: float = 0.05
    """How far behind the stance ankle the foot of a step back must be to count as landed, m."""
    back_force: float = 120.0
    """Sole force with which it counts as landed, N."""
