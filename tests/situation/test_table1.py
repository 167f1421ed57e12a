"""Table 1 as printed, and how little of the world it covers."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.situation.table1 import MODES, literal_mode, literal_rows

V = 40.0


@pytest.mark.parametrize(
    ("front", "rear", "known", "mode"),
    [
        (None, (30.0, 60.0), True, "No acceleration"),
        (None, (20.0, 60.0), True, "Acceleration"),
        (None, (20.0, 30.0), True, None),
        ((35.0, V), (25.0, V), True, "Warning"),
        ((35.0, V), (25.0, V + 1e-9), True, None),
        ((30.0, V), (20.0, 60.0), True, "CCM (Forward direction)"),
        ((30.0, 50.0), (20.0, 60.0), True, None),
        ((25.0, V), (25.0, 60.0), True, None),  # the sandwich of section 3.1.3 with 25 m on each side
        ((20.0, V), (5.0, 60.0), True, None),
        ((30.0, V), None, True, None),
        (None, None, True, None),
        (None, None, False, "CCM (Reverse direction)"),
    ],
)
def test_rows(front: tuple[float, float] | None, rear: tuple[float, float] | None, known: bool, mode: str | None) -> None:
    assert literal_mode(front, rear, V, known) == mode


def test_hardly_any_dangerous_sandwich_gets_a_mode() -> None:
    """Both vehicles there, gaps to 100 m, speeds to 40 m/s, a time to collision under 3 s: 1 %."""
    r = np.random.default_rng(1)
    n = 200_000
    d_f, d_r = r.uniform(0, 100, (2, n))
    v_f, v_r, v_h = r.uniform(0, 40, (3, n))
    dangerous = (d_f < 3 * (v_h - v_f)) | (d_r < 3 * (v_r - v_h))
    rows = literal_rows(True, d_f, v_f, True, d_r, v_r, v_h)[dangerous]
    assert 0.008 < np.mean(rows > 0) < 0.012
    assert set(rows) <= {0, 4}


def test_no_front_vehicle_nearer_than_25_m_ever_gets_a_mode() -> None:
    d_f, d_r, v_f, v_r = np.meshgrid(np.linspace(0, 24.9, 20), np.linspace(0, 60, 20), np.linspace(0, 40, 9), np.linspace(0, 40, 9))
    assert not literal_rows(True, d_f, v_f, True, d_r, v_r, 15.0).any()


def test_five_rows_five_modes() -> None:
    assert len(MODES) == 5
