"""The C header's controller, compiled and called from Python: to test it, to time it, to close its loop."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from jaxwalk.deploy import Sensors, soundness
from jaxwalk.export import selftest

_SHIM = """\
#include <stddef.h>
#include <time.h>

#include "{header}"

size_t shim_size(void);
int shim_init(void *w, float height, float mass, float speed);
int shim_start(void *w, const float *said, int stance, float *joints);
void shim_tick(void *w, const float *said, float *joints);
int shim_ask(void *w, float speed);
int shim_late(void *w, float seconds);
int shim_touchdown(const void *w);
int shim_fallen(const void *w);
int shim_passive(const void *w);
void shim_told(const void *w, float *observation);
double shim_time_act(const float *observations, int count);
double shim_time_ticks(void *w, const float *said, int count);

size_t shim_size(void) {{ return sizeof(struct jaxwalk); }}
int shim_init(void *w, float height, float mass, float speed) {{
    return jaxwalk_init(w, height, mass, speed);
}}
int shim_ask(void *w, float speed) {{ return jaxwalk_ask(w, speed); }}
int shim_late(void *w, float seconds) {{ return jaxwalk_late(w, seconds); }}
int shim_start(void *w, const float *said, int stance, float *joints) {{
    return jaxwalk_start(w, (const struct jaxwalk_sensors *)said, stance, joints);
}}
void shim_tick(void *w, const float *said, float *joints) {{
    jaxwalk_tick(w, (const struct jaxwalk_sensors *)said, joints);
}}
int shim_touchdown(const void *w) {{ return ((const struct jaxwalk *)w)->touchdown; }}
int shim_fallen(const void *w) {{ return jaxwalk_fallen(w); }}
int shim_passive(const void *w) {{ return ((const struct jaxwalk *)w)->passive; }}
void shim_told(const void *w, float *observation) {{
    const float *told = ((const struct jaxwalk *)w)->observation;
    for (int i = 0; i < JAXWALK_OBSERVATIONS; ++i) observation[i] = told[i];
}}

/* Seconds for `count` decisions, and for `count` ticks. */
double shim_time_act(const float *observations, int count) {{
    float action[JAXWALK_ACTIONS];
    volatile float kept = 0.0f;
    const clock_t begun = clock();
    for (int i = 0; i < count; ++i) {{
        jaxwalk_act(observations + i * JAXWALK_OBSERVATIONS, action);
        kept = kept + action[0];
    }}
    return (double)(clock() - begun) / CLOCKS_PER_SEC;
}}
double shim_time_ticks(void *w, const float *said, int count) {{
    float joints[6];
    volatile float kept = 0.0f;
    const clock_t begun = clock();
    for (int i = 0; i < count; ++i) {{
        jaxwalk_tick(w, (const struct jaxwalk_sensors *)(said + 18 * i), joints);
        kept = kept + joints[0];
    }}
    return (double)(clock() - begun) / CLOCKS_PER_SEC;
}}
"""


def build(header: Path, folder: Path, *flags: str) -> ctypes.CDLL:
    """The header as a library, in ``folder``, compiled with ``flags`` besides.

    Raises:
      UserError: no C compiler.
    """
    source = folder / "shim.c"
    source.write_text(_SHIM.format(header=header.resolve()))
    library = selftest.compile_c(source, folder / "shim.so", "-shared", "-fPIC", *flags)
    loaded = ctypes.CDLL(str(library))
    loaded.shim_size.restype = ctypes.c_size_t
    loaded.shim_init.argtypes = [ctypes.c_void_p, *[ctypes.c_float] * 3]
    loaded.shim_ask.argtypes = loaded.shim_late.argtypes = [ctypes.c_void_p, ctypes.c_float]
    loaded.shim_time_act.restype = loaded.shim_time_ticks.restype = ctypes.c_double
    return loaded


class Controller:
    """As `jaxwalk.deploy.Controller`, by the library.

    Attributes:
      touchdown: a foot landed in the last tick.
    """

    def __init__(self, library: ctypes.CDLL, height: float, mass: float, speed: float) -> None:
        self._library = library
        self._walker = ctypes.create_string_buffer(library.shim_size())
        self._joints = np.zeros(6, np.float32)
        self.refused = library.shim_init(self._walker, height, mass, speed) != 0

    def start(self, said: Sensors, stance: int) -> np.ndarray:
        """Begin anew: the foot ``stance`` (0 left, 1 right) has just landed; gives what `tick` does."""
        told = soundness.flat(said)
        self._library.shim_start(self._walker, _pointer(told), stance, _pointer(self._joints))
        return self._joints.copy()

    def tick(self, said: Sensors) -> np.ndarray:
        """[6] hip rate (rad/s), knee angle (rad), ankle torque (N m) until the next tick; left, right."""
        told = soundness.flat(said)
        self._library.shim_tick(self._walker, _pointer(told), _pointer(self._joints))
        return self._joints.copy()

    def ask(self, speed: float) -> int:
        """Aim at another speed, m/s: 1 if the policy was trained for it, 0 if not, -1 out of range."""
        return self._library.shim_ask(self._walker, speed)

    def late(self, seconds: float) -> int:
        """Tell the policy that instruments are so late, s: 1 if trained for it, 0 if not, -1 out of range."""
        return self._library.shim_late(self._walker, seconds)

    @property
    def touchdown(self) -> bool:
        """Whether a foot landed in the last tick."""
        return bool(self._library.shim_touchdown(self._walker))

    @property
    def passive(self) -> bool:
        """Whether the joints are let go: the instruments said for too long what cannot be true."""
        return bool(self._library.shim_passive(self._walker))

    @property
    def fallen(self) -> bool:
        """As far as the sensors tell: torso too far over, hip too low over the feet, or a stalled step."""
        return bool(self._library.shim_fallen(self._walker))

    def observation(self, size: int) -> np.ndarray:
        """[size] what the policy was told last."""
        told = np.zeros(size, np.float32)
        self._library.shim_told(self._walker, _pointer(told))
        return told

    def time_ticks(self, said: list[Sensors]) -> float:
        """Seconds for one tick, over the ticks of ``said``."""
        told = np.stack([soundness.flat(one) for one in said])
        return self._library.shim_time_ticks(self._walker, _pointer(told), len(told)) / len(told)


def time_act(library: ctypes.CDLL, observations: np.ndarray) -> float:
    """Seconds for one decision, over [N, O] observations."""
    told = np.ascontiguousarray(observations, np.float32)
    return library.shim_time_act(_pointer(told), len(told)) / len(told)


def _pointer(values: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(values.ctypes.data)
