/* A trained stepping policy and the controllers around it; written by jaxwalk export, version @VERSION@.
 *
 * C99 or C++, single precision, no heap, math.h and string.h alone. One walker:
 *
 *     struct jaxwalk walker;
 *     struct jaxwalk_sensors said = ...;
 *     float joints[6];
 *     jaxwalk_init(&walker, JAXWALK_HEIGHT, JAXWALK_MASS, JAXWALK_SPEED);
 *     jaxwalk_start(&walker, &said, stance, joints);      the foot `stance` has just landed ahead
 *     every JAXWALK_TIMESTEP seconds: jaxwalk_tick(&walker, &said, joints);
 *
 * joints: @COMMANDS@; left, right.
 * A reading that is no number, or beyond what instruments can say, is left out: the last good one stands for it, for
 * JAXWALK_HOLD_TICKS ticks on end. Then walker.passive is 1, and the joints are let go until jaxwalk_start.
 * The equations, and where they come from, are in jaxwalk's modules of the names given below.
 */
#ifndef JAXWALK_POLICY_H
#define JAXWALK_POLICY_H

#include <math.h>
#include <stdint.h>
#include <string.h>

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
    float delay;                   /* by which instruments tell late, s: see jaxwalk_late */
    float history[JAXWALK_MEAN_WINDOW][2], filtered[2];
    struct jaxwalk_sensors now;    /* velocity and acceleration filtered */
    float thigh[2], shank[2], x[2], z[2]; /* angles from the vertical, ankles from the hip */
    int stance;                    /* 0 left, 1 right */
    float elapsed, length, duration, toe_off, toe_off_seconds;
    float change[2];               /* of the planned length and duration, as the policy wants it */
    float path, path_rate;         /* where the swing hip shall be; of compliant legs */
    float lag;                     /* how far it has fallen behind the speed asked for, m; likewise */
    float landed_length;           /* of the step that ended last, m */
    int ticks, windows, fresh;     /* since the last decision */
    float observation[JAXWALK_OBSERVATIONS], action[JAXWALK_ACTIONS];
    int touchdown;                 /* a foot landed in the last tick */
    struct jaxwalk_sensors heard;  /* the last reading that can be true */
    int held, passive;             /* ticks on end that it stands for later ones; the joints are let go */
};

/* The numbers of a body of `height` m and `mass` kg that aims at `speed` m/s; 0, or -1: out of range. */
static inline int jaxwalk_init(struct jaxwalk *w, float height, float mass, float speed) {
    if (!(height >= 0.5f && height <= 3.0f && mass >= 5.0f && mass <= 500.0f && speed >= 0.1f && speed <= 3.0f))
        return -1;
    memset(w, 0, sizeof *w);
    w->length_ratio = height / JAXWALK_REFERENCE_HEIGHT;
    w->mass_ratio = mass / JAXWALK_REFERENCE_MASS;
    jaxwalk_scale(&w->n, w->length_ratio, w->mass_ratio);
    w->n.speed_desired = speed;
    w->leg = w->n.thigh + w->n.shank + w->n.foot;
    return 0;
}

/* Aim at another speed from the next tick on: 1 if the policy was trained for it, 0 if not; -1: out of range, and
 * nothing is changed. */
static inline int jaxwalk_ask(struct jaxwalk *w, float speed) {
    if (!(speed >= 0.1f && speed <= 3.0f)) return -1;
    w->n.speed_desired = speed;
    return speed >= JAXWALK_SPEED_LEAST - 1e-6f && speed <= JAXWALK_SPEED_MOST + 1e-6f;
}

/* Tell the policy, after jaxwalk_init, that the instruments of torso and soles tell `seconds` late: 1 if it was trained
 * for that, 0 if not; -1: out of range, and nothing is changed. */
static inline int jaxwalk_late(struct jaxwalk *w, float seconds) {
    if (!(seconds >= 0.0f && seconds <= JAXWALK_DELAY_MOST)) return -1;
    w->delay = seconds;
    return seconds <= JAXWALK_DELAY_TRAINED + 1e-6f;
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

/* soundness: 1 if all that the instruments say can be true. Sizes are compared as bits, which grow as numbers do: a
 * compiler that is told -ffast-math takes it for granted that there are numbers only. */
static inline int jaxwalk_sound(const struct jaxwalk_sensors *said) {
    uint32_t bits[JAXWALK_INPUTS], most[JAXWALK_INPUTS];
    int sound = 1;
    memcpy(bits, said, sizeof bits);
    memcpy(most, jaxwalk_most, sizeof most);
    for (int i = 0; i < JAXWALK_INPUTS; ++i) sound &= (bits[i] & 0x7fffffffu) <= most[i];
    return sound;
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

static inline float jaxwalk_step_length(const struct jaxwalk *w) { return w->x[1 - w->stance] - w->x[w->stance]; }

static inline float jaxwalk_capture_point(const struct jaxwalk *w) {
    return w->n.torso_share * w->n.torso * sinf(w->now.pitch) +
           w->now.velocity * sqrtf(w->leg / JAXWALK_GRAVITY);
}

@LEGS@
/* footstep */
static inline void jaxwalk_observe(struct jaxwalk *w) {
    const float pace = sqrtf(w->length_ratio);
    const float ahead = w->n.torso * sinf(w->now.pitch) - w->x[w->stance];
    const float above = w->n.torso * cosf(w->now.pitch) - w->z[w->stance] + w->n.foot;
    float known[JAXWALK_SEEN];
    known[JAXWALK_SPEED_SEEN] = w->now.velocity / pace;
    known[JAXWALK_PITCH_SEEN] = w->now.pitch;
    known[JAXWALK_ZMP_SEEN] = (ahead - w->now.acceleration / JAXWALK_GRAVITY * above) / w->length_ratio;
    known[JAXWALK_STEP_LENGTH_SEEN] = w->landed_length / w->length_ratio;
    known[JAXWALK_PITCH_RATE_SEEN] = w->now.pitch_rate / (1.0f / pace);
    known[JAXWALK_ACCELERATION_SEEN] = w->now.acceleration;
    known[JAXWALK_SPEED_DESIRED_SEEN] = w->n.speed_desired / pace;
    known[JAXWALK_HEIGHT_SEEN] = w->length_ratio;
    known[JAXWALK_COM_AHEAD_SEEN] = ahead / w->length_ratio;
    known[JAXWALK_ELAPSED_SEEN] = w->elapsed / pace; /* times go as speeds do */
    known[JAXWALK_CAPTURE_AHEAD_SEEN] = (jaxwalk_capture_point(w) - w->x[w->stance]) / w->length_ratio;
    known[JAXWALK_SWING_AHEAD_SEEN] = jaxwalk_step_length(w) / w->length_ratio;
    known[JAXWALK_DELAY_SEEN] = w->delay / pace;
    for (int i = 0; i < JAXWALK_OBSERVATIONS; ++i) w->observation[i] = known[jaxwalk_seen[i]];
}

static inline void jaxwalk_decide(struct jaxwalk *w) {
    jaxwalk_observe(w);
    jaxwalk_act(w->observation, w->action);
#if JAXWALK_PLANNED
    w->change[0] = jaxwalk_clamp(w->action[0], -1.0f, 1.0f) * w->n.plan_change_length;
    w->change[1] = jaxwalk_clamp(w->action[1], -1.0f, 1.0f) * w->n.plan_change_duration;
#else
    w->length = w->n.length_min + 0.5f * (jaxwalk_clamp(w->action[0], -1.0f, 1.0f) + 1.0f) *
                                      (w->n.length_max - w->n.length_min);
    w->duration = w->n.duration_min + 0.5f * (jaxwalk_clamp(w->action[1], -1.0f, 1.0f) + 1.0f) *
                                          (w->n.duration_max - w->n.duration_min);
#endif
}

/* controller */

/* Begin, or begin again: the foot `stance` (0 left, 1 right) has just landed ahead of the other. 0; or -1: the
 * instruments say what cannot be true, and the joints are let go. */
static inline int jaxwalk_start(struct jaxwalk *w, const struct jaxwalk_sensors *said, int stance,
                                float *joints) {
    w->held = w->touchdown = 0;
    w->passive = !jaxwalk_sound(said);
    if (w->passive) {
        for (int i = 0; i < 6; ++i) joints[i] = 0.0f;
        return -1;
    }
    w->heard = *said;
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
    jaxwalk_posture(w);
    w->length = w->n.length_nominal;
    w->duration = w->n.duration_nominal;
    w->change[0] = w->change[1] = w->lag = 0.0f;
    w->ticks = w->windows = w->fresh = 0;
    jaxwalk_begin_step(w);
    w->landed_length = -jaxwalk_step_length(w);
    jaxwalk_decide(w);
    jaxwalk_joints(w, joints);
    return 0;
}

/* Whether the policy is asked in this tick: at a touch-down; or, where steps are decided anew, at the end of
 * a decision window in which a foot has landed, or of the last of so many. */
static inline int jaxwalk_asks(struct jaxwalk *w) {
    int asks;
    if (!JAXWALK_REPLAN) return w->touchdown;
    w->fresh |= w->touchdown;
    w->ticks = (w->ticks + 1) % JAXWALK_WINDOW_TICKS;
    if (w->ticks) return 0;
    asks = w->fresh || ++w->windows >= JAXWALK_REPLAN;
    if (asks) w->windows = w->fresh = 0;
    return asks;
}

/* One tick: what the instruments say now, to what the joints are to do until the next. */
static inline void jaxwalk_tick(struct jaxwalk *w, const struct jaxwalk_sensors *said, float *joints) {
    float length;
    if (jaxwalk_sound(said)) {
        w->heard = *said;
        w->held = 0;
    } else if (++w->held > JAXWALK_HOLD_TICKS) {
        w->passive = 1;
    }
    if (w->passive) {
        w->touchdown = 0;
        jaxwalk_let_go(w, joints);
        return;
    }
    jaxwalk_filter(w, &w->heard);
    jaxwalk_posture(w);
    w->elapsed += JAXWALK_TIMESTEP;
    length = jaxwalk_step_length(w);
    jaxwalk_proceed(w);
    if (w->touchdown) w->landed_length = length;
    if (jaxwalk_asks(w)) jaxwalk_decide(w);
    jaxwalk_joints(w, joints);
}

/* As far as the sensors tell: the torso too far over, the hip too low over the feet, or a stalled step; or they tell
 * nothing, and the joints are let go. */
static inline int jaxwalk_fallen(const struct jaxwalk *w) {
    return w->passive || fabsf(w->now.pitch) > w->n.fall_pitch ||
           w->n.foot - fminf(w->z[0], w->z[1]) < w->n.fall_height * w->leg || w->elapsed > w->n.stall_seconds;
}

#endif
