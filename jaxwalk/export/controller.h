/* A trained stepping policy and the controllers around it; written by jaxwalk export, version @VERSION@.
 *
 * C99, single precision, no heap, nothing but math.h. One walker:
 *
 *     struct jaxwalk walker;
 *     struct jaxwalk_sensors said = ...;
 *     float joints[6];
 *     jaxwalk_init(&walker, JAXWALK_HEIGHT, JAXWALK_MASS, JAXWALK_SPEED);
 *     jaxwalk_start(&walker, &said, stance, joints);      the foot `stance` has just landed ahead
 *     every JAXWALK_TIMESTEP seconds: jaxwalk_tick(&walker, &said, joints);
 *
 * joints: hip rate (rad/s), knee angle (rad), ankle torque (N m, dorsiflexion positive); left, right.
 * The equations, and where they come from, are in jaxwalk's modules of the names given below.
 */
#ifndef JAXWALK_POLICY_H
#define JAXWALK_POLICY_H

#include <math.h>

/* ---- what was exported ---- */

@DATA@

/* ---- the policy ---- */

static inline float jaxwalk_clamp(float x, float low, float high) { return fminf(fmaxf(x, low), high); }

static inline void jaxwalk_dense(const float *kernel, const float *bias, int inputs, int outputs,
                                 const float *x, float *y) {
    for (int j = 0; j < outputs; ++j) y[j] = 0.0f;
    /* Sums of eight at a time: rounded less than one long sum. */
    for (int first = 0; first < inputs; first += 8)
        for (int j = 0; j < outputs; ++j) {
            float part = 0.0f;
            for (int i = first; i < first + 8 && i < inputs; ++i) part += x[i] * kernel[i * outputs + j];
            y[j] += part;
        }
    for (int j = 0; j < outputs; ++j) y[j] += bias[j];
}

/* Raw observation [JAXWALK_OBSERVATIONS] to action [JAXWALK_ACTIONS] in [-1, 1]. */
static inline void jaxwalk_act(const float *observation, float *action) {
    float x[JAXWALK_WIDEST], y[JAXWALK_WIDEST];
    for (int i = 0; i < JAXWALK_OBSERVATIONS; ++i) {
        x[i] = (observation[i] - jaxwalk_mean[i]) / jaxwalk_std[i];
        if (JAXWALK_CLIP > 0.0f) x[i] = jaxwalk_clamp(x[i], -JAXWALK_CLIP, JAXWALK_CLIP);
    }
@LAYERS@
    for (int i = 0; i < JAXWALK_ACTIONS; ++i) action[i] = tanhf(y[i]);
}

/* Actions to (length m, duration s) of the reference body. */
static inline void jaxwalk_command(const float *action, float *command) {
    for (int i = 0; i < JAXWALK_ACTIONS; ++i)
        command[i] = jaxwalk_low[i] + 0.5f * (jaxwalk_clamp(action[i], -1.0f, 1.0f) + 1.0f) *
                                          (jaxwalk_high[i] - jaxwalk_low[i]);
}

/* ---- the walker ---- */

/* What the instruments say after a tick. Legs: left, right; joints: hip, knee, ankle, flexion positive. */
struct jaxwalk_sensors {
    float velocity, acceleration;  /* of the torso's centre, forward, m/s and m/s^2 */
    float pitch, pitch_rate;       /* of the torso, forward positive, rad and rad/s */
    float joints[2][3], rates[2][3]; /* rad, rad/s */
    float touch[2];                /* force under the soles, N */
};

struct jaxwalk {
    struct jaxwalk_numbers n;      /* of this walker's stature and mass */
    float length_ratio, mass_ratio, leg;
    float history[JAXWALK_MEAN_WINDOW][2], filtered[2];
    struct jaxwalk_sensors now;    /* velocity and acceleration filtered */
    float thigh[2], shank[2], x[2], z[2]; /* angles from the vertical, ankles from the hip */
    int stance;                    /* 0 left, 1 right */
    float elapsed, length, duration, toe_off, toe_off_seconds;
    float observation[JAXWALK_OBSERVATIONS], action[JAXWALK_ACTIONS];
    int touchdown;                 /* a foot landed in the last tick; observation and action are fresh */
};

/* The numbers of a body of `height` m and `mass` kg that aims at `speed` m/s; 0, or -1: out of range. */
static inline int jaxwalk_init(struct jaxwalk *w, float height, float mass, float speed) {
    static const struct jaxwalk zero = {0};
    if (!(height >= 0.5f && height <= 3.0f && mass >= 5.0f && mass <= 500.0f && speed >= 0.1f && speed <= 3.0f))
        return -1;
    *w = zero;
    w->length_ratio = height / JAXWALK_REFERENCE_HEIGHT;
    w->mass_ratio = mass / JAXWALK_REFERENCE_MASS;
    jaxwalk_scale(&w->n, w->length_ratio, w->mass_ratio);
    w->n.speed_desired = speed;
    w->leg = w->n.thigh + w->n.shank + w->n.foot;
    return 0;
}

/* kinematics */
static inline void jaxwalk_posture(struct jaxwalk *w) {
    for (int i = 0; i < 2; ++i) {
        w->thigh[i] = w->now.joints[i][0] - w->now.pitch;
        w->shank[i] = w->thigh[i] - w->now.joints[i][1];
        w->x[i] = w->n.thigh * sinf(w->thigh[i]) + w->n.shank * sinf(w->shank[i]);
        w->z[i] = -(w->n.thigh * cosf(w->thigh[i]) + w->n.shank * cosf(w->shank[i]));
    }
}

/* sensors: a moving mean, then a Kalman filter */
static inline void jaxwalk_filter(struct jaxwalk *w, const struct jaxwalk_sensors *said) {
    float mean[2] = {0.0f, 0.0f}, prior[2], off[2];
    for (int i = 0; i + 1 < JAXWALK_MEAN_WINDOW; ++i)
        for (int k = 0; k < 2; ++k) w->history[i][k] = w->history[i + 1][k];
    w->history[JAXWALK_MEAN_WINDOW - 1][0] = said->velocity;
    w->history[JAXWALK_MEAN_WINDOW - 1][1] = said->acceleration;
    for (int i = 0; i < JAXWALK_MEAN_WINDOW; ++i)
        for (int k = 0; k < 2; ++k) mean[k] += w->history[i][k];
    prior[0] = w->filtered[0] + JAXWALK_TIMESTEP * w->filtered[1];
    prior[1] = w->filtered[1];
    for (int k = 0; k < 2; ++k) off[k] = mean[k] / (float)JAXWALK_MEAN_WINDOW - prior[k];
    for (int k = 0; k < 2; ++k)
        w->filtered[k] = prior[k] + (jaxwalk_gain[2 * k] * off[0] + jaxwalk_gain[2 * k + 1] * off[1]);
    w->now = *said;
    w->now.velocity = w->filtered[0];
    w->now.acceleration = w->filtered[1];
}

/* gait */
enum { JAXWALK_TOE_OFF, JAXWALK_EARLY_SWING, JAXWALK_TERMINAL_SWING };

static inline int jaxwalk_phase(const struct jaxwalk *w) {
    if (w->elapsed < w->toe_off_seconds) return JAXWALK_TOE_OFF;
    return w->elapsed < w->toe_off_seconds + w->duration ? JAXWALK_EARLY_SWING : JAXWALK_TERMINAL_SWING;
}

static inline float jaxwalk_progress(const struct jaxwalk *w) {
    return (w->elapsed - w->toe_off_seconds) / w->duration;
}

static inline float jaxwalk_step_length(const struct jaxwalk *w) { return w->x[1 - w->stance] - w->x[w->stance]; }

static inline int jaxwalk_landed_ahead(const struct jaxwalk *w) {
    return jaxwalk_progress(w) > w->n.touchdown_share && jaxwalk_step_length(w) > w->n.touchdown_ahead &&
           w->now.touch[1 - w->stance] > w->n.touchdown_force && (w->now.velocity > 0.0f || !JAXWALK_BACK_STEP);
}

/* back_step */
static inline float jaxwalk_capture_point(const struct jaxwalk *w) {
    return w->n.torso_share * w->n.torso * sinf(w->now.pitch) +
           w->now.velocity * sqrtf(w->leg / JAXWALK_GRAVITY);
}

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
static inline void jaxwalk_toe_off(const struct jaxwalk *w, int trailing, float *torque, float *seconds) {
    const float angle = w->thigh[trailing], knee = w->now.joints[trailing][1], limit = w->n.ankle_limit;
    const float lost = w->n.toe_off_speed * w->n.speed_desired - w->now.velocity;
    float wanted, lasts;
    if (JAXWALK_TOE_OFF_PAPER) {
        const float half = w->leg / 2.0f, c = half * cosf(knee) + half / 2.0f, s = half * sinf(knee);
        const float inertia = w->n.torso_inertia +
                              w->n.half_leg * (half * half / 12.0f + (s * s + c * c) + half * half / 3.0f);
        const float rate = lost / (cosf(angle) * w->leg);
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

/* footstep */
static inline void jaxwalk_observe(struct jaxwalk *w, float length) {
    const float pace = sqrtf(w->length_ratio);
    const float ahead = w->n.torso * sinf(w->now.pitch) - w->x[w->stance];
    const float above = w->n.torso * cosf(w->now.pitch) - w->z[w->stance] + w->n.foot;
    float known[9];
    known[JAXWALK_SPEED_SEEN] = w->now.velocity / pace;
    known[JAXWALK_PITCH_SEEN] = w->now.pitch;
    known[JAXWALK_ZMP_SEEN] = (ahead - w->now.acceleration / JAXWALK_GRAVITY * above) / w->length_ratio;
    known[JAXWALK_STEP_LENGTH_SEEN] = length / w->length_ratio;
    known[JAXWALK_PITCH_RATE_SEEN] = w->now.pitch_rate / (1.0f / pace);
    known[JAXWALK_ACCELERATION_SEEN] = w->now.acceleration;
    known[JAXWALK_SPEED_DESIRED_SEEN] = w->n.speed_desired / pace;
    known[JAXWALK_HEIGHT_SEEN] = w->length_ratio;
    known[JAXWALK_COM_AHEAD_SEEN] = ahead / w->length_ratio;
    for (int i = 0; i < JAXWALK_OBSERVATIONS; ++i) w->observation[i] = known[jaxwalk_seen[i]];
}

static inline void jaxwalk_decide(struct jaxwalk *w, float length) {
    jaxwalk_observe(w, length);
    jaxwalk_act(w->observation, w->action);
    w->length = w->n.length_min + 0.5f * (jaxwalk_clamp(w->action[0], -1.0f, 1.0f) + 1.0f) *
                                      (w->n.length_max - w->n.length_min);
    w->duration = w->n.duration_min + 0.5f * (jaxwalk_clamp(w->action[1], -1.0f, 1.0f) + 1.0f) *
                                          (w->n.duration_max - w->n.duration_min);
}

/* controller */

/* Begin, or begin again: the foot `stance` (0 left, 1 right) has just landed ahead of the other. */
static inline void jaxwalk_start(struct jaxwalk *w, const struct jaxwalk_sensors *said, int stance,
                                 float *joints) {
    for (int i = 0; i < JAXWALK_MEAN_WINDOW; ++i) {
        w->history[i][0] = said->velocity;
        w->history[i][1] = 0.0f;
    }
    w->filtered[0] = said->velocity;
    w->filtered[1] = 0.0f;
    w->now = *said;
    w->now.acceleration = 0.0f;
    w->stance = stance != 0;
    w->elapsed = 0.0f;
    w->touchdown = 0;
    jaxwalk_posture(w);
    jaxwalk_toe_off(w, 1 - w->stance, &w->toe_off, &w->toe_off_seconds);
    jaxwalk_decide(w, -jaxwalk_step_length(w));
    jaxwalk_joints(w, joints);
}

/* One tick: what the instruments say now, to what the joints are to do until the next. */
static inline void jaxwalk_tick(struct jaxwalk *w, const struct jaxwalk_sensors *said, float *joints) {
    float torque, seconds;
    jaxwalk_filter(w, said);
    jaxwalk_posture(w);
    w->elapsed += JAXWALK_TIMESTEP;
    w->touchdown = jaxwalk_landed_ahead(w) || jaxwalk_landed_behind(w);
    /* At a touch-down the legs swap: the one that was in stance trails and pushes off. */
    jaxwalk_toe_off(w, w->touchdown ? w->stance : 1 - w->stance, &torque, &seconds);
    if (w->touchdown) {
        const float length = jaxwalk_step_length(w);
        w->stance = 1 - w->stance;
        w->elapsed = 0.0f;
        w->toe_off = torque;
        w->toe_off_seconds = seconds;
        jaxwalk_decide(w, length);
    } else if (!JAXWALK_TOE_OFF_LATCHED && w->elapsed < w->toe_off_seconds) {
        w->toe_off = fmaxf(w->toe_off, torque);
        w->toe_off_seconds = fmaxf(w->toe_off_seconds, seconds);
    }
    jaxwalk_joints(w, joints);
}

/* As far as the sensors tell: the torso too far over, the hip too low over the feet, or a stalled step. */
static inline int jaxwalk_fallen(const struct jaxwalk *w) {
    /* What is not a number stands for nothing good. */
    return !(fabsf(w->now.pitch) <= w->n.fall_pitch &&
             w->n.foot - fminf(w->z[0], w->z[1]) >= w->n.fall_height * w->leg &&
             w->elapsed <= w->n.stall_seconds && w->now.velocity - w->now.velocity == 0.0f);
}

#endif
