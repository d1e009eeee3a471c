"""The numbers of the compliant controllers (``jaxwalk.control.compliant``), those of the reference body."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CompliantConfig:
    """Impedances, push-off and swing. Angles: hip forward, knee flexed, ankle dorsiflexed are positive."""

    hip_damping: float = 173.4
    """Servo of the stance hip's rate, N m s/rad."""
    pitch_nominal: float = 0.08889
    """phi0 of eq. 13: torso's pitch beyond `pitch_offset` at which the hip turns as the leg does, rad."""
    pitch_offset: float = 0.01128
    """Torso's pitch at which the stance hip is told to stand still, rad."""
    pitch_capture_gain: float = -0.0736
    """How much further forward the torso is to lean for each m that the capture point is too far, rad/m."""
    hip_rate_max: float = 4.86
    """Largest hip rate that the stance controller asks for, rad/s."""
    hip_speed_min: float = 0.4262
    """The stance controller never takes the hip to be slower than this, m/s."""

    knee_stiffness: float = 1153.0
    """Of the stance knee, N m/rad."""
    knee_damping: float = 62.16
    """Of the stance knee, N m s/rad."""
    knee_loading: float = 0.3295
    """Flexion about which the stance knee yields as it takes the load, rad."""
    knee_standing: float = 0.356
    """The same from `knee_seconds` on, rad."""
    knee_seconds: float = 0.3313
    """Time from touch-down in which it goes from the one to the other, s."""

    ankle_stiffness: float = 311.7
    """Of the stance ankle beyond `ankle_slack`, N m/rad."""
    ankle_slack: float = 0.09385
    """Dorsiflexion from which on the stance ankle's spring acts, rad."""
    ankle_damping: float = 12.86
    """Of the stance ankle, N m s/rad."""
    ankle_capture_gain: float = 288.2
    """Plantarflexion torque for each m that the capture point will be too far at the landing, N m/m: it moves
    the centre of pressure under it."""
    balance_ankle: float = 0.6893
    """Plantarflexion at which balancing by the toes ends, rad."""
    balance_sole: float = 0.2
    """Angle of the sole to the floor, toes up, at which balancing by the heel ends, rad."""
    ankle_stop: float = 200.0
    """Stiffness with which ligaments keep the ankle from plantarflexing beyond `ankle_end`, N m/rad."""
    ankle_end: float = 0.8
    """Plantarflexion that people's ankles reach, rad."""

    push_off_angle: float = 0.1114
    """The stance leg's angle behind the vertical at which push-off begins, rad."""
    push_off_ramp: float = 0.3543
    """Angle over which it comes to its whole torque, rad."""
    push_off_torque: float = 133.4
    """Of a walker at the speed desired, N m."""
    push_off_gain: float = 67.46
    """Torque for each m/s that it is slower, N m s/m."""
    push_off_ankle: float = 0.3545
    """Plantarflexion at which push-off ends, rad."""
    push_off_share: float = 1.05
    """Share of the speed desired at which push-off is `push_off_torque`."""
    toe_off_seconds: float = 0.1051
    """Time after the other foot's touch-down in which the trailing leg still pushes, its hip limp, s."""
    toe_off_least: float = 0.4
    """Share of `push_off_torque` that it pushes with at least: who is too fast for that swings at once."""

    swing_stiffness: float = 626.9
    """Of the swing hip about its path, N m/rad."""
    swing_damping: float = 81.99
    """Of the swing hip about its path's rate, N m s/rad."""
    swing_pitch_gain: float = 1.338
    """Share of the torso's pitch added to the swing hip's target (1: the thigh's angle to the vertical)."""
    swing_rate_max: float = 9.116
    """Largest rate of the swing hip's path, rad/s."""
    swing_acceleration_most: float = 400.0
    """Largest acceleration of the path, rad/s^2."""
    swing_soonest: float = 0.03
    """Time that it is planned ahead at least, s: when the step's is over it holds the goal."""
    swing_knee: float = 1.016
    """Flexion of the swing knee while the foot passes, rad."""
    swing_knee_stiffness: float = 5.513
    """Its stiffness, N m/rad."""
    swing_knee_damping: float = 4.546
    """Its damping, N m s/rad."""
    knee_stop: float = 300.0
    """Stiffness with which ligaments keep the knee in the air from bending forward, N m/rad."""
    toe_off_knee_share: float = 0.3
    """Share of `swing_knee` that the trailing knee is pulled to while it pushes."""
    landing_knee: float = 0.2498
    """Flexion with which the swing leg lands, rad."""
    landing_knee_stiffness: float = 282.3
    """Its stiffness, N m/rad."""
    landing_knee_damping: float = 11.66
    """Its damping, N m s/rad."""
    landing_seconds: float = 0.05708
    """Time before the landing in which the knee straightens, s."""
    swing_sole: float = -0.0832
    """Angle of the swing foot's sole to the floor, toes up positive, rad."""
    swing_ankle_most: float = 0.3118
    """Largest dorsiflexion that it is turned to for that, rad."""
    swing_ankle_stiffness: float = 95.07
    """Of the ankle in the air, N m/rad."""
    swing_ankle_damping: float = 1.61
    """Of the ankle in the air, N m s/rad."""

    landing_time: float = 0.4806
    """Time of a step at which the error of the capture point is told, s: that of steady walking."""
    landing_capture: float = 0.5281
    """How far ahead of the stance ankle the capture point then is in steady walking, m."""
    speed_usual: float = 1.0
    """Speed asked for that these numbers are of, m/s; for each m/s more there are, besides:"""
    length_speed: float = 0.2717
    """Length of the step, s."""
    duration_speed: float = -0.2149
    """Its time, s^2/m."""
    capture_speed: float = 0.5145
    """`landing_capture`, s."""
    push_off_speed: float = -30.92
    """`push_off_torque`, N m s/m."""
    lag_seconds: float = 6.0
    """How soon it is forgotten that the walker has been slower or faster than asked for, s. Its lag is that
    error of speed, integrated over about so long, m: what pulls steadily, as a pack or a slope does, is told
    by it."""
    lag_speed: float = 0.3
    """Error of speed that counts for it at most, m/s: a push is an accident."""
    lag_most: float = 0.6
    """Largest lag that counts, m."""
    lag_push_off: float = 50.0
    """Push-off torque for each m of lag, N m/m."""
    lag_pitch: float = 0.1
    """Lean of the torso for each m of lag, rad/m."""
    lag_capture: float = 0.1
    """Distance of the capture point ahead at a landing, for each m of lag."""
    landing_share: float = 0.55
    """Share of the step's time before which a contact ahead is no touch-down."""
    landing_behind: float = 0.05
    """How far the capture point may be behind a foot that lands ahead, m: who stands on one that is further
    ahead falls back from it. Before that the other leg goes on."""
    passing_seconds: float = 0.07241
    """Time after toe-off before which a contact is no touch-down, s."""
    back_toe_off: float = 0.2267
    """Share of `toe_off_seconds` in which the trailing leg pushes although its foot is sent behind."""
    back_pitch_gain: float = 0.0
    """`swing_pitch_gain` of a step back: the torso that falls back is not thrown further by its leg."""
    back_knee: float = 0.7669
    """Flexion of the swing knee in a step back, rad."""
    back_knee_stiffness: float = 342.3
    """Its stiffness, N m/rad."""
    back_knee_damping: float = 4.278
    """Its damping, N m s/rad."""
    back_ahead: float = 0.00487
    """How far behind the stance ankle the foot of a step back must be to count as landed, m."""
    back_force: float = 81.31
    """Sole force with which it counts as landed, N."""
