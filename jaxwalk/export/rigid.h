/* rigid legs: phases */
enum { JAXWALK_TOE_OFF, JAXWALK_EARLY_SWING, JAXWALK_TERMINAL_SWING };

static inline int jaxwalk_phase(const struct jaxwalk *w) {
    if (w->elapsed < w->toe_off_seconds) return JAXWALK_TOE_OFF;
    return w->elapsed < w->toe_off_seconds + w->duration ? JAXWALK_EARLY_SWING : JAXWALK_TERMINAL_SWING;
}

static inline float jaxwalk_progress(const struct jaxwalk *w) {
    return (w->elapsed - w->toe_off_seconds) / w->duration;
}

static inline int jaxwalk_landed_ahead(const struct jaxwalk *w) {
    return jaxwalk_progress(w) > w->n.touchdown_share && jaxwalk_step_length(w) > w->n.touchdown_ahead &&
           w->now.touch[1 - w->stance] > w->n.touchdown_force && (w->now.velocity > 0.0f || !JAXWALK_BACK_STEP);
}

/* back_step */
static inline int jaxwalk_back_needed(const struct jaxwalk *w) {
    return JAXWALK_BACK_STEP && jaxwalk_phase(w) != JAXWALK_TOE_OFF &&
           jaxwalk_capture_point(w) < w->x[w->stance] - w->n.back_step_margin;
}

static inline int jaxwalk_landed_behind(const struct jaxwalk *w) {
    return jaxwalk_step_length(w) < -w->n.back_step_least &&
           w->now.touch[1 - w->stance] > w->n.back_step_force && jaxwalk_back_needed(w);
}

static inline void jaxwalk_back_swing(const struct jaxwalk *w, float *rate, float *knee) {
    const float place = fminf(jaxwalk_capture_point(w) - w->n.back_step_reach,
                              w->x[w->stance] - w->n.back_step_least);
    const float target = asinf(jaxwalk_clamp(place / w->leg, -0.6f, 0.6f)) + w->now.pitch;
    const float off = target - w->now.joints[1 - w->stance][0];
    *rate = jaxwalk_clamp(w->n.terminal_hip_gain * off, -w->n.swing_rate_max, w->n.swing_rate_max);
    *knee = off < -w->n.back_step_near ? w->n.back_step_knee : 0.0f;
}

/* controllers */
static inline float jaxwalk_rods_inertia(float mass, float length, float apart) {
    const float s = length * sinf(apart), c = length * cosf(apart) - length / 2.0f;
    return mass * (length * length / 12.0f + (s * s + c * c) + length * length / 3.0f);
}

static inline void jaxwalk_toe_off(const struct jaxwalk *w, int trailing, float *torque, float *seconds) {
    const float angle = w->thigh[trailing], knee = w->now.joints[trailing][1], limit = w->n.ankle_limit;
    const float lost = w->n.toe_off_speed * w->n.speed_desired - w->now.velocity;
    float wanted, lasts;
    if (JAXWALK_TOE_OFF_LEGS) {
        const float leg = JAXWALK_TOE_OFF_LEGS == 2 ? w->n.thigh + w->n.shank : w->leg;
        const float legs = JAXWALK_TOE_OFF_LEGS == 2
                               ? jaxwalk_rods_inertia(2.0f * w->n.half_leg, leg, w->thigh[1 - trailing] - angle)
                               : jaxwalk_rods_inertia(w->n.half_leg, w->leg / 2.0f, 3.14159265f - knee);
        const float inertia = w->n.torso_inertia + legs;
        const float rate = lost / (cosf(angle) * leg);
        wanted = w->n.ankle_damping * rate + inertia * rate / w->n.toe_off_duration;
    } else {
        wanted = w->n.toe_off_gain * lost;
    }
    wanted = fmaxf(wanted, 0.0f);
    /* After a step back the leg that would push is ahead, and would push further back. */
    if (JAXWALK_BACK_STEP && angle >= 0.0f) wanted = 0.0f;
    lasts = w->n.toe_off_duration * fminf(wanted / w->n.toe_off_full, 1.0f) * fmaxf(1.0f, wanted / limit);
    *seconds = jaxwalk_clamp(lasts, w->n.toe_off_duration_min, w->n.toe_off_duration_max);
    *torque = fminf(wanted, limit);
}

static inline float jaxwalk_stance_hip_rate(const struct jaxwalk *w) {
    const float speed = fmaxf(w->now.velocity - w->n.torso * w->now.pitch_rate, w->n.stance_speed_min);
    const float rate = -speed / (w->leg * cosf(w->thigh[w->stance])) * w->now.pitch / w->n.pitch_nominal;
    return jaxwalk_clamp(rate, -w->n.stance_rate_max, w->n.stance_rate_max);
}

static inline void jaxwalk_joints(const struct jaxwalk *w, float *joints) {
    const int swing = 1 - w->stance, phase = jaxwalk_phase(w);
    const float hip = w->now.joints[swing][0], ankle = w->now.joints[swing][2];
    const float target = asinf(jaxwalk_clamp(0.5f * w->length / w->leg, -0.95f, 0.95f)) +
                         w->n.swing_pitch_gain * w->now.pitch;
    float rate = 0.0f, knee = 0.0f, level = -w->shank[swing], torque;
    float *standing = joints + 3 * w->stance, *swinging = joints + 3 * swing;
    if (jaxwalk_back_needed(w)) {
        jaxwalk_back_swing(w, &rate, &knee);
    } else if (phase == JAXWALK_EARLY_SWING) {
        const float progress = jaxwalk_progress(w), left = (1.0f - progress) * w->duration;
        rate = jaxwalk_clamp((target - hip) / fmaxf(left, 1e-3f), -w->n.swing_rate_max, w->n.swing_rate_max);
        knee = progress < w->n.swing_knee_share ? w->n.swing_knee : 0.0f;
        level = w->n.swing_ankle;
    } else if (phase == JAXWALK_TERMINAL_SWING) {
        rate = w->n.terminal_hip_gain * (target - hip);
    }
    if (phase == JAXWALK_TOE_OFF && ankle > -w->n.toe_off_ankle)
        torque = -w->toe_off;
    else
        torque = w->n.ankle_stiffness * (level - ankle) - w->n.ankle_rate_gain * w->now.rates[swing][2];
    swinging[0] = rate;
    swinging[1] = knee;
    swinging[2] = torque;
    standing[0] = jaxwalk_stance_hip_rate(w);
    standing[1] = 0.0f;
    standing[2] = w->elapsed > w->n.restart_seconds ? w->n.restart_torque : 0.0f;
}

/* A command that moves nothing. */
static inline void jaxwalk_let_go(const struct jaxwalk *w, float *joints) {
    for (int i = 0; i < 6; ++i) joints[i] = i % 3 == 1 ? w->heard.joints[i / 3][1] : 0.0f;
}

/* form: as the foot `stance` lands, and after each tick, w->touchdown */
static inline void jaxwalk_begin_step(struct jaxwalk *w) {
    jaxwalk_toe_off(w, 1 - w->stance, &w->toe_off, &w->toe_off_seconds);
}

static inline void jaxwalk_proceed(struct jaxwalk *w) {
    float torque, seconds;
    w->touchdown = jaxwalk_landed_ahead(w) || jaxwalk_landed_behind(w);
    /* At a touch-down the legs swap: the one that was in stance trails and pushes off. */
    jaxwalk_toe_off(w, w->touchdown ? w->stance : 1 - w->stance, &torque, &seconds);
    if (w->touchdown) {
        w->stance = 1 - w->stance;
        w->elapsed = 0.0f;
        w->toe_off = torque;
        w->toe_off_seconds = seconds;
    } else if (!JAXWALK_TOE_OFF_LATCHED && w->elapsed < w->toe_off_seconds) {
        w->toe_off = fmaxf(w->toe_off, torque);
        w->toe_off_seconds = fmaxf(w->toe_off_seconds, seconds);
    }
}
