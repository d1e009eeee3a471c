"""ODE's C API by ctypes: as much of it as a tree of hinged bodies on a floor needs.

Debian builds ``libode.so.8`` (ODE 0.16) for doubles. The layouts are those of ``ode/contact.h`` and
``ode/common.h``; the numbers those of ``D_ALL_PARAM_NAMES`` and of ``dContact...``.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_char_p, c_double, c_int, c_ulong, c_void_p
from functools import cache
from typing import Any

import numpy as np

from jaxwalk.common.errors import UserError

NAME = "libode.so.8"
VEL, FMAX, CFM = 2, 5, 8  # dParamVel, dParamFMax, dParamCFM: of a hinge's motor
SURFACE = 0x001 | 0x002 | 0x008 | 0x010 | 0x7000  # Mu2, FDir1, SoftERP, SoftCFM, Approx1
_Vector3 = c_double * 4  # of which ODE uses three


class Contact(ctypes.Structure):
    """``dContact``."""

    _fields_ = (
        ("mode", c_int),
        *((name, c_double) for name in "mu mu2 rho rho2 rhoN bounce bounce_vel soft_erp soft_cfm".split()),
        *((name, c_double) for name in "motion1 motion2 motionN slip1 slip2".split()),
        ("pos", _Vector3),
        ("normal", _Vector3),
        ("depth", c_double),
        ("g1", c_void_p),
        ("g2", c_void_p),
        ("side1", c_int),
        ("side2", c_int),
        ("fdir1", _Vector3),
    )


class Feedback(ctypes.Structure):
    """``dJointFeedback``: what a joint did to its bodies in the last step, N and N m."""

    _fields_ = tuple((name, _Vector3) for name in ("f1", "t1", "f2", "t2"))


class Mass(ctypes.Structure):
    """``dMass``."""

    _fields_ = (("mass", c_double), ("centre", _Vector3), ("inertia", c_double * 12))


_REAL, _ID, _FLAG, _NONE, _SEEN = c_double, c_void_p, c_int, None, POINTER(c_double)
_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "dInitODE2": (_FLAG, (ctypes.c_uint,)),
    "dGetConfiguration": (c_char_p, ()),
    "dRandSetSeed": (_NONE, (c_ulong,)),
    "dWorldCreate": (_ID, ()),
    "dWorldDestroy": (_NONE, (_ID,)),
    "dWorldSetGravity": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dWorldSetQuickStepNumIterations": (_NONE, (_ID, _FLAG)),
    "dWorldStep": (_FLAG, (_ID, _REAL)),
    "dWorldQuickStep": (_FLAG, (_ID, _REAL)),
    "dMassSetParameters": (_NONE, (POINTER(Mass), *[_REAL] * 10)),
    "dBodyCreate": (_ID, (_ID,)),
    "dBodySetMass": (_NONE, (_ID, POINTER(Mass))),
    "dBodySetFiniteRotationMode": (_NONE, (_ID, _FLAG)),
    "dBodySetPosition": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dBodySetQuaternion": (_NONE, (_ID, _Vector3)),
    "dBodySetLinearVel": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dBodySetAngularVel": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dBodyAddForce": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dBodyAddTorque": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    **{f"dBodyGet{what}": (_SEEN, (_ID,)) for what in ("Position", "Quaternion", "LinearVel", "AngularVel")},
    "dJointGroupCreate": (_ID, (_FLAG,)),
    "dJointGroupEmpty": (_NONE, (_ID,)),
    "dJointCreateContact": (_ID, (_ID, _ID, POINTER(Contact))),
    "dJointCreateHinge": (_ID, (_ID, _ID)),
    "dJointCreatePlane2D": (_ID, (_ID, _ID)),
    "dJointAttach": (_NONE, (_ID, _ID, _ID)),
    "dJointSetFeedback": (_NONE, (_ID, POINTER(Feedback))),
    "dJointSetHingeAnchor": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dJointSetHingeAxis": (_NONE, (_ID, _REAL, _REAL, _REAL)),
    "dJointSetHingeParam": (_NONE, (_ID, _FLAG, _REAL)),
    "dJointAddHingeTorque": (_NONE, (_ID, _REAL)),
}


@cache
def load() -> Any:
    """The library, made ready.

    It keeps Python's lock while it works: its worlds are not to be entered by two threads.

    Raises:
      UserError: there is none, or it is built for floats.
    """
    try:
        ode = ctypes.PyDLL(NAME)
    except OSError:
        raise UserError(f"--engine ode: {NAME} is not here: apt-get install libode8") from None
    for name, (gives, takes) in _FUNCTIONS.items():
        function = getattr(ode, name)
        function.restype, function.argtypes = gives, takes
    if b"ODE_double_precision" not in ode.dGetConfiguration():
        raise UserError(
            f"--engine ode: {NAME} is built for floats: give one for doubles, as Debian's libode8"
        )
    ode.dInitODE2(0)
    return ode


def seen(pointer: Any, count: int) -> np.ndarray:
    """[count] what ``pointer`` of a body shows, now and whenever it is read."""
    return np.ctypeslib.as_array(pointer, (count,))
