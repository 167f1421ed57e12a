"""The paper's Table 1, read literally: five rows, and no mode wherever none of them matches."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.situation import one_state

D_PR_M = 25.0
D_SPF_M = 25.0
D_LPF_M = 35.0
MODES = ("No acceleration", "Acceleration", "Warning", "CCM (Forward direction)", "CCM (Reverse direction)")
UNKNOWN = np.nan


def literal_rows(
    front_present: Any, d_f: Any, v_f: Any, rear_present: Any, d_r: Any, v_r: Any, v_h: Any, known: Any = True
) -> NDArray[np.int8]:
    """Row number 1..5 of Table 1 for each state, 0 where no row matches. Distances [m] bumper to bumper, speeds in one unit.

    Readings: "No" front vehicle means that none is there (d_f > d_lpf then holds of itself); "between" includes both ends; the
    equalities of the Warning row are equalities of numbers; the last row, all "None" (unknown value), is nothing known of front and rear.
    Entries of an absent vehicle are not looked at (`UNKNOWN` will do).
    """
    front, d_f, v_f, rear, d_r, v_r, v_h, known = np.broadcast_arrays(front_present, d_f, v_f, rear_present, d_r, v_r, v_h, known)
    rows = _rows(front, d_f, v_f, rear, d_r, v_r, v_h, known, np)
    result = np.zeros(d_f.shape, dtype=np.int8)
    for number, matches in enumerate(rows, start=1):
        result[matches] = number
    return result


def literal_mode(front: tuple[float, float] | None, rear: tuple[float, float] | None, v_h: float, known: bool = True) -> str | None:
    """The mode of Table 1 in the paper's words, None where it has no row. `front`, `rear`: (distance, speed), None when absent."""
    d_f, v_f = front or (UNKNOWN, UNKNOWN)
    d_r, v_r = rear or (UNKNOWN, UNKNOWN)
    rows = _rows(front is not None, d_f, v_f, rear is not None, d_r, v_r, v_h, known, one_state)
    return next((mode for mode, matches in zip(MODES, rows, strict=True) if matches), None)


def _rows(front: Any, d_f: Any, v_f: Any, rear: Any, d_r: Any, v_r: Any, v_h: Any, known: Any, m: Any) -> tuple[Any, ...]:
    """Which rows match, at most one of them; vectors or scalars, by the number system."""
    nobody = m.logical_not(front)
    return (
        known & nobody & rear & (d_r > D_PR_M),
        known & nobody & rear & (d_r <= D_PR_M) & (v_r > v_h),
        known & front & (d_f == D_LPF_M) & (v_f == v_h) & rear & (d_r == D_PR_M) & (v_r == v_h),
        known & front & (d_f >= D_SPF_M) & (d_f <= D_LPF_M) & (v_f <= v_h) & rear & (d_r < D_PR_M) & (v_r > v_h),
        m.logical_not(known),
    )
