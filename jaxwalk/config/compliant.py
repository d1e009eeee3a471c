"""The numbers of the compliant controllers (``jaxwalk.control.compliant``), those of the reference body."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CompliantConfig:
    """Impedances, push-off and swing. Angles: hip forward, knee flexed, ankle dorsiflexed are positive."""

    hip_damping: float = 143.2
    """Servo of the stance hip's rate, N m s/rad."""
    pitch_nominal: float = 0.1272
    """phi0 of eq. 13: torso's pitch beyond `pitch_offset` at which the hip turns as the leg does, rad."""
    pitch_offset: float = -0.03752
    """Torso's pitch at which the stance hip is told to stand still, rad."""
    pitch_capture_gain: float = -0.0034
    """How much further forward the torso is to lean for each m that the capture point is too far, rad/m."""
    hip_rate_max: float = 6.038
    """Largest hip rate that the stance controller asks for, rad/s."""
    hip_speed_min: float = 1.337
    """The stance controller never takes the hip to be slower than this, m/s."""

    knee_stiffness: float = 949.7
    """Of the stance knee, N m/rad."""
    knee_damping: float = 69.14
    """Of the stance knee, N m s/rad."""
    knee_loading: float = 0.299
    """Flexion about which the stance knee yields as it takes the load, rad."""
    knee_standing: float = 0.3228
    """The same from `knee_seconds` on, rad."""
    knee_seconds: float = 0.4588
    """Time from touch-down in which it goes from the one to the other, s."""

    ankle_stiffness: float = 507.5
    """Of the stance ankle beyond `ankle_slack`, N m/rad."""
    ankle_slack: float = 0.08635
    """Dorsiflexion from which on the stance ankle's spring acts, rad."""
    ankle_damping: float = 13.14
    """Of the stance ankle, N m s/rad."""
    ankle_capture_gain: float = 208.9
    """Plantarflexion torque for each m that the capture point will be too far at the landing, N m/m: it moves
    the centre of pressure under it."""

    push_off_angle: float = 0.1367
    """The stance leg's angle behind the vertical at which push-off begins, rad."""
    push_off_ramp: float = 0.3738
    """Angle over which it comes to its whole torque, rad."""
    push_off_torque: float = 103.2
    """Of a walker at the speed desired, N m."""
    push_off_gain: float = 129.8
    """Torque for each m/s that it is slower, N m s/m."""
    push_off_ankle: float = 0.2986
    """Plantarflexion at which push-off ends, rad."""
    push_off_share: float = 1.05
    """Share of the speed desired at which push-off is `push_off_torque`."""
    toe_off_seconds: float = 0.1103
    """Time after the other foot's touch-down in which the trailing leg still pushes, its hip limp, s."""

    swing_stiffness: float = 608.9
    """Of the swing hip about its path, N m/rad."""
    swing_damping: float = 110.2
    """Of the swing hip about its path's rate, N m s/rad."""
    swing_pitch_gain: float = 0.9802
    """Share of the torso's pitch added to the swing hip's target (1: the thigh's angle to the vertical)."""
    swing_rate_max: float = 9.279
    """Largest rate of the swing hip's path, rad/s."""
    swing_knee: float = 0.8011
    """Flexion of the swing knee while the foot passes, rad."""
    swing_knee_stiffness: float = 16.65
    """Its stiffness, N m/rad."""
    swing_knee_damping: float = 0.9635
    """Its damping, N m s/rad."""
    knee_stop: float = 300.0
    """Stiffness with which ligaments keep the knee in the air from bending forward, N m/rad."""
    toe_off_knee_share: float = 0.3
    """Share of `swing_knee` that the trailing knee is pulled to while it pushes."""
    landing_knee: float = 0.2108
    """Flexion with which the swing leg lands, rad."""
    landing_knee_stiffness: float = 279.4
    """Its stiffness, N m/rad."""
    landing_knee_damping: float = 11.01
    """Its damping, N m s/rad."""
    landing_seconds: float = 0.04724
    """Time before the landing in which the knee straightens, s."""
    swing_sole: float = -0.1408
    """Angle of the swing foot's sole to the floor, toes up positive, rad."""
    swing_ankle_most: float = 0.1626
    """Largest dorsiflexion that it is turned to for that, rad."""
    swing_ankle_stiffness: float = 77.0
    """Of the ankle in the air, N m/rad."""
    swing_ankle_damping: float = 1.5
    """Of the ankle in the air, N m s/rad."""

    landing_time: float = 0.478
    """Time of a step at which the error of the capture point is told, s: that of steady walking."""
    landing_capture: float = 0.5746
    """How far ahead of the stance ankle the capture point then is in steady walking, m."""
    landing_share: float = 0.55
    """Share of the step's time before which a contact ahead is no touch-down."""
    passing_seconds: float = 0.05564
    """Time after toe-off before which a contact is no touch-down, s."""
    back_ahead: float = 0.08308
    """How far behind the stance ankle the foot of a step back must be to count as landed, m."""
    back_force: float = 96.78
    """Sole force with which it counts as landed, N."""
