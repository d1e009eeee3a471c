/* compliant legs: stance; how much faster is asked for than the numbers are of, m/s */
static inline float jaxwalk_faster(const struct jaxwalk *w) {
    return w->n.speed_desired - w->n.compliant_speed_usual;
}

static inline float jaxwalk_capture_error(const struct jaxwalk *w) {
    const float more = jaxwalk_faster(w), most = 2.0f * w->leg;
    const float time = w->n.compliant_landing_time + w->n.compliant_duration_speed * more;
    const float left = fmaxf(time - w->elapsed, 0.0f);
    const float ahead = jaxwalk_capture_point(w) - w->x[w->stance];
    const float usual = w->n.compliant_landing_capture + w->n.compliant_capture_speed * more +
                        w->n.compliant_lag_capture * w->lag;
    const float grown = ahead * expf(sqrtf(JAXWALK_GRAVITY / w->leg) * left);
    return jaxwalk_clamp(grown - usual, -most, most);
}

static inline float jaxwalk_stance_hip(const struct jaxwalk *w, float error) {
    const float speed = fmaxf(w->now.velocity - w->n.torso * w->now.pitch_rate, w->n.compliant_hip_speed_min);
    const float turning = speed / -w->z[w->stance];
    const float upright = w->n.compliant_pitch_offset + w->n.compliant_lag_pitch * w->lag;
    const float off = w->now.pitch - upright - w->n.compliant_pitch_capture_gain * error;
    const float rate = jaxwalk_clamp(-turning * off / w->n.compliant_pitch_nominal, -w->n.compliant_hip_rate_max,
                                     w->n.compliant_hip_rate_max);
    return w->n.compliant_hip_damping * (rate - w->now.rates[w->stance][0]);
}

static inline float jaxwalk_stance_knee(const struct jaxwalk *w) {
    const float share = jaxwalk_clamp(w->elapsed / w->n.compliant_knee_seconds, 0.0f, 1.0f);
    const float rest =
        w->n.compliant_knee_loading + (w->n.compliant_knee_standing - w->n.compliant_knee_loading) * share;
    return w->n.compliant_knee_stiffness * (rest - w->now.joints[w->stance][1]) -
           w->n.compliant_knee_damping * w->now.rates[w->stance][1];
}

static inline float jaxwalk_push_off(const struct jaxwalk *w) {
    const float lost = w->n.compliant_push_off_share * w->n.speed_desired - w->now.velocity;
    const float usual = w->n.compliant_push_off_torque + w->n.compliant_push_off_speed * jaxwalk_faster(w);
    return fmaxf(usual + w->n.compliant_push_off_gain * lost + w->n.compliant_lag_push_off * w->lag, 0.0f);
}

static inline float jaxwalk_ankle_stop(const struct jaxwalk *w, float angle) {
    return w->n.compliant_ankle_stop * fmaxf(-w->n.compliant_ankle_end - angle, 0.0f);
}

static inline float jaxwalk_stance_ankle(const struct jaxwalk *w, float error) {
    const float angle = w->now.joints[w->stance][2], rate = w->now.rates[w->stance][2];
    const float behind = atan2f(-w->x[w->stance], -w->z[w->stance]) - w->n.compliant_push_off_angle;
    const int forward =
        jaxwalk_capture_point(w) > w->x[w->stance] && angle > -w->n.compliant_push_off_ankle;
    const float share = forward ? jaxwalk_clamp(behind / w->n.compliant_push_off_ramp, 0.0f, 1.0f) : 0.0f;
    const float left = error > 0.0f ? angle + w->n.compliant_balance_ankle
                                    : w->n.compliant_balance_sole - w->shank[w->stance] - angle;
    const float flat = jaxwalk_clamp(left / 0.1f, 0.0f, 1.0f);
    const float resting = w->n.compliant_ankle_stiffness * fminf(w->n.compliant_ankle_slack - angle, 0.0f) -
                          w->n.compliant_ankle_capture_gain * error * flat;
    return resting + share * (-jaxwalk_push_off(w) - resting) - w->n.compliant_ankle_damping * rate +
           jaxwalk_ankle_stop(w, angle);
}

/* compliant legs: swing; whether the foot is sent behind the one that stands */
static inline int jaxwalk_back(const struct jaxwalk *w) {
    return 0.5f * w->length < w->x[w->stance];
}

static inline float jaxwalk_push_seconds(const struct jaxwalk *w) {
    return w->n.compliant_toe_off_seconds * (jaxwalk_back(w) ? w->n.compliant_back_toe_off : 1.0f);
}

static inline int jaxwalk_pushes(const struct jaxwalk *w) {
    const int swing = 1 - w->stance;
    return w->elapsed < jaxwalk_push_seconds(w) && w->thigh[swing] < 0.0f &&
           jaxwalk_push_off(w) > w->n.compliant_toe_off_least * w->n.compliant_push_off_torque &&
           w->now.joints[swing][2] > -w->n.compliant_push_off_ankle;
}

static inline void jaxwalk_swing(const struct jaxwalk *w, float *torque) {
    const int swing = 1 - w->stance;
    const float *angle = w->now.joints[swing], *rate = w->now.rates[swing];
    const int limp = jaxwalk_pushes(w);
    const float bent = limp ? w->n.compliant_swing_knee * w->n.compliant_toe_off_knee_share
                            : w->n.compliant_swing_knee;
    torque[0] = limp ? 0.0f
                     : w->n.compliant_swing_stiffness * (w->path - angle[0]) +
                           w->n.compliant_swing_damping * (w->path_rate - rate[0]);
    if (!limp && w->duration - w->elapsed < w->n.compliant_landing_seconds)
        torque[1] = w->n.compliant_landing_knee_stiffness * (w->n.compliant_landing_knee - angle[1]) -
                    w->n.compliant_landing_knee_damping * rate[1];
    else if (!limp && jaxwalk_back(w))
        torque[1] = w->n.compliant_back_knee_stiffness * (w->n.compliant_back_knee - angle[1]) -
                    w->n.compliant_back_knee_damping * rate[1];
    else
        torque[1] = w->n.compliant_swing_knee_stiffness * (bent - angle[1]) -
                    w->n.compliant_swing_knee_damping * rate[1];
    torque[1] += w->n.compliant_knee_stop * fmaxf(-angle[1], 0.0f);
    torque[2] = limp ? -jaxwalk_push_off(w)
                     : w->n.compliant_swing_ankle_stiffness *
                               (fminf(w->n.compliant_swing_sole - w->shank[swing],
                                      w->n.compliant_swing_ankle_most) - angle[2]) -
                           w->n.compliant_swing_ankle_damping * rate[2];
    torque[2] += jaxwalk_ankle_stop(w, angle[2]);
}

static inline void jaxwalk_path(struct jaxwalk *w) {
    const int swing = 1 - w->stance;
    const float reach = jaxwalk_clamp(0.5f * w->length / (w->n.thigh + w->n.shank), -0.9f, 0.9f);
    const float gain = jaxwalk_back(w) ? w->n.compliant_back_pitch_gain : w->n.compliant_swing_pitch_gain;
    const float goal = asinf(reach) + gain * w->now.pitch;
    const float left = fmaxf(w->duration - w->elapsed, w->n.compliant_swing_soonest);
    const float most = w->n.compliant_swing_acceleration_most;
    const float turn = 6.0f * (goal - w->path) / (left * left) - 4.0f * w->path_rate / left;
    if (jaxwalk_pushes(w)) {
        w->path = w->now.joints[swing][0];
        w->path_rate = w->now.rates[swing][0];
        return;
    }
    w->path_rate = jaxwalk_clamp(w->path_rate + JAXWALK_TIMESTEP * jaxwalk_clamp(turn, -most, most),
                                 -w->n.compliant_swing_rate_max, w->n.compliant_swing_rate_max);
    w->path += JAXWALK_TIMESTEP * w->path_rate;
}

static inline int jaxwalk_landed(const struct jaxwalk *w) {
    const float ahead = jaxwalk_step_length(w), force = w->now.touch[1 - w->stance];
    if (!(w->elapsed > jaxwalk_push_seconds(w) + w->n.compliant_passing_seconds)) return 0;
    if (jaxwalk_back(w))
        return ahead < -w->n.compliant_back_ahead && force > w->n.compliant_back_force;
    const float foot = w->x[1 - w->stance] - w->n.compliant_landing_behind;
    return w->elapsed > w->n.compliant_landing_share * w->duration && ahead > w->n.touchdown_ahead &&
           jaxwalk_capture_point(w) > foot &&
           force > w->n.touchdown_force;
}

/* what the joints can give at the rates that they turn with */
static inline float jaxwalk_left(const float *strength, float rate) {
    const float c = strength[1], d = strength[2], r = fmaxf(rate, 0.0f);
    const float share = (2.0f * c * d + r * (d - 3.0f * c)) / (2.0f * c * d + r * (2.0f * d - 4.0f * c));
    return strength[0] * fmaxf(share, 0.0f);
}

static inline void jaxwalk_joints(const struct jaxwalk *w, float *joints) {
    const float error = jaxwalk_capture_error(w), pace = sqrtf(w->length_ratio);
    const float heavier = w->mass_ratio * w->length_ratio;
    float *standing = joints + 3 * w->stance;
    standing[0] = jaxwalk_stance_hip(w, error);
    standing[1] = jaxwalk_stance_knee(w);
    standing[2] = jaxwalk_stance_ankle(w, error);
    jaxwalk_swing(w, joints + 3 * (1 - w->stance));
    for (int leg = 0; JAXWALK_LIMITED && leg < 2; ++leg)
        for (int k = 0; k < 3; ++k) {
            const float rate = w->now.rates[leg][k] * pace; /* the reference body's */
            joints[3 * leg + k] =
                jaxwalk_clamp(joints[3 * leg + k], -heavier * jaxwalk_left(jaxwalk_strength[1][k], -rate),
                              heavier * jaxwalk_left(jaxwalk_strength[0][k], rate));
        }
}

/* A command that moves nothing. */
static inline void jaxwalk_let_go(const struct jaxwalk *w, float *joints) {
    (void)w;
    for (int i = 0; i < 6; ++i) joints[i] = 0.0f;
}

/* form: as the foot `stance` lands, and after each tick, w->touchdown */
static inline void jaxwalk_begin_step(struct jaxwalk *w) {
    w->path = w->now.joints[1 - w->stance][0];
    w->path_rate = w->now.rates[1 - w->stance][0];
    w->toe_off = jaxwalk_push_off(w);
    w->toe_off_seconds = w->n.compliant_toe_off_seconds;
}

/* The step that is planned by the capture point, with what the policy changes of it. */
static inline void jaxwalk_plan(struct jaxwalk *w) {
    const int swing = 1 - w->stance;
    const float capture = jaxwalk_capture_point(w), stance = w->x[w->stance];
    const float error = jaxwalk_capture_error(w), more = jaxwalk_faster(w);
    const float usual = w->n.length_nominal + w->n.compliant_length_speed * more;
    const float pitch = fmaxf(w->now.pitch, w->n.plan_pitch_least);
    float length = usual + w->n.plan_length_gain * error + w->n.plan_pitch_gain * pitch;
    float seconds = w->n.duration_nominal + w->n.compliant_duration_speed * more - w->n.plan_duration_gain * error;
    length = fmaxf(length, w->n.plan_length_least);
    seconds = jaxwalk_clamp(seconds, w->n.plan_duration_least, fminf(w->n.plan_duration_most, w->n.duration_max));
    if (capture - stance < -w->n.plan_back_margin) { /* a step back */
        const float place =
            fminf(w->n.plan_back_gain * capture - w->n.plan_back_reach, stance - w->n.plan_back_least);
        const float gap = w->x[swing] - place, way = fmaxf(gap, -w->n.plan_back_beyond * gap);
        length = 2.0f * place;
        seconds = w->elapsed +
                  jaxwalk_clamp(way / w->n.plan_back_speed, w->n.plan_back_soonest, w->n.plan_back_time);
    }
    w->length = jaxwalk_clamp(length + w->change[0], w->n.length_min, w->n.length_max);
    const float longest = fmaxf(w->n.duration_max, fminf(seconds, w->n.plan_back_latest));
    w->duration = jaxwalk_clamp(seconds + w->change[1], w->n.duration_min, longest);
}

/* how far it has fallen behind the speed asked for of late, m: the error, integrated with a leak */
static inline void jaxwalk_lag(struct jaxwalk *w) {
    const float fast = w->n.compliant_lag_speed, most = w->n.compliant_lag_most;
    const float off = jaxwalk_clamp(w->n.speed_desired - w->now.velocity, -fast, fast);
    w->lag = jaxwalk_clamp(w->lag + JAXWALK_TIMESTEP * (off - w->lag / w->n.compliant_lag_seconds), -most, most);
}

static inline void jaxwalk_proceed(struct jaxwalk *w) {
    w->touchdown = jaxwalk_landed(w);
    if (w->touchdown) {
        w->stance = 1 - w->stance;
        w->elapsed = 0.0f;
        jaxwalk_begin_step(w);
    }
    if (JAXWALK_PLANNED) jaxwalk_plan(w);
    jaxwalk_path(w);
    jaxwalk_lag(w);
    w->toe_off = jaxwalk_push_off(w);
}
