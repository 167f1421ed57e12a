"""The roll-out and the following of paths as a compiled library: the equations of motion's own C text in a loop over the horizon."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.bicycle import INPUTS, STATES, road_bicycle
from mcdas_opt.native.addresses import address
from mcdas_opt.native.kernels import c_text, defined, library, wanted
from mcdas_opt.solvers.c_text import c_function
from mcdas_opt.solvers.held_interrupts import held_interrupts

_BUILDS = ("-O2 -lm",)  # no fused operations: the same bits as the interpreted roll-out, where both have the same libm


class CompiledDrive:
    """`mcdas_opt.planning.roll_out` in C (12 us instead of 400 for 40 steps), and `mcdas_opt.actuation.path_following`."""

    def __init__(self, library: ctypes.CDLL) -> None:
        pointer, number, whole = ctypes.c_void_p, ctypes.c_double, ctypes.c_int
        self._steps: tuple[Array, int] = np.empty(0), 0  # the last, and where they lie: a grid's stay the same
        self._drive = library.mcdas_drive
        self._drive.restype = None
        self._drive.argtypes = [whole, pointer, pointer, number, pointer, whole, *[pointer] * 4]
        self._follow = library.mcdas_follow
        self._follow.restype = None
        self._follow.argtypes = [whole, number, pointer, whole, *[pointer] * 7]

    def __call__(
        self, states: Array, planned_speed_mps: Array, inputs: Array, steps_s: Array, car: Array, road: Array, starts: float
    ) -> None:
        """Fills `states` (N + 1, 6) from its first row; `inputs` (N, 2) are zeroed where the car stands. `car` = (wheelbase, centre) [m],
        `road` (2, knots) = s and curvature. All of them contiguous floats.
        """
        steps = self._steps
        if steps[0] is not steps_s:
            steps = self._steps = steps_s, address(steps_s)
        knots, at = road.shape[1], address(road)
        given = address(planned_speed_mps), starts, address(car), knots, at, at + 8 * knots
        self._drive(len(steps_s), steps[1], *given, address(inputs), address(states))

    def follow(self, states: Array, inputs: Array, step_s: float, car: Array, road: Array, path: Array, law: Array, driver: Array) -> None:
        """Fills `states` (N + 1, 6) from its first row, and `inputs` (N, 2). `path`, `law` and `driver` as the C text has them."""
        of, at, way, rule, who, u, x = map(address, (car, road, path, law, driver, inputs, states))
        knots = road.shape[1]
        self._follow(len(inputs), step_s, of, knots, at, at + 8 * knots, way, rule, who, u, x)


def compiled_drive() -> CompiledDrive | None:
    """The library, built on first use; None where there is no compiler, or MCDAS_OPT_COMPILE=0 forbids it."""
    return _built() if wanted() else None


@lru_cache(maxsize=1)
@held_interrupts()
def _built() -> CompiledDrive | None:
    x, u = ca.SX.sym("x", len(STATES)), ca.SX.sym("u", len(INPUTS))
    kappa: Any = ca.SX.sym("kappa")
    car: Any = ca.SX.sym("car", 2)
    slope = road_bicycle(ca.vertsplit(x), ca.vertsplit(u), kappa, car[0], car[1], ca)
    motion = ca.Function("motion", [x, u, kappa, car], [ca.cse(ca.densify(ca.vertcat(*slope)))])
    found = library([defined({"LD": 1}), c_function(motion, loop=False), c_text("mcdas_opt.ocp", "drive.c")], _BUILDS)
    return None if found is None else CompiledDrive(found)
