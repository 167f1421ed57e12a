"""Every table and figure of the paper, recomputed: published beside computed, and the reading under which they agree."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.actuation.duty_cycle import SAMPLE_S, duty_of_speed, implied_acceleration, next_duty
from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.radar import target_speed_literal
from mcdas_opt.errors import writing
from mcdas_opt.evaluation import published
from mcdas_opt.evaluation.paper_tracking import KMH, TRACKING, TrackingChoices, crash_position, study
from mcdas_opt.reference.literal import SETTLING_X_M, Y_MAX_M, commanded_speed, literal_path, y_left, y_parking, y_right
from mcdas_opt.reference.offset_path import corrected
from mcdas_opt.reference.steering_demand import peak_lateral_acceleration, starting_heading_jump
from mcdas_opt.situation.table1 import literal_mode, literal_rows

BOUND_MPS2 = 4.0  # of the corrected path, where a figure needs one


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One comparison. `published` is None for a figure that follows from the paper but does not stand in it."""

    item: str
    published: float | str | None
    computed: float | str | None
    reading: str
    unit: str = ""

    @property
    def agreement(self) -> str:
        """`equal`, to half a unit of the last digit that the paper prints; `differs`; or `ours only`."""
        if self.published is None:
            return "ours only"
        if self.deviation is None:
            return "equal" if self.computed == self.published else "differs"
        _, _, decimals = repr(self.published).partition(".")
        return "equal" if abs(self.deviation) <= 0.5 * 0.1 ** len(decimals) + 1e-9 else "differs"

    @property
    def deviation(self) -> float | None:
        if isinstance(self.published, float) and isinstance(self.computed, float):
            return self.computed - self.published
        return None


def _row(item: str, published: float | str | None, computed: float | str | None, reading: str, unit: str = "") -> Row:
    return Row(item=item, published=published, computed=computed, reading=reading, unit=unit)


def _ours(item: str, computed: float | str | None, reading: str, unit: str = "") -> Row:
    """A figure that follows from the paper but does not stand in it."""
    return _row(item, None, computed, reading, unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reproduction:
    rows: tuple[Row, ...]
    figures: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        rows = [{**to_document(row), "deviation": row.deviation, "agreement": row.agreement} for row in self.rows]
        return {"schema_version": SCHEMA_VERSION, "rows": rows, "figures": list(self.figures)}


def reproduce(out: Path | None = None, seed: int = 1, choices: TrackingChoices = TRACKING) -> Reproduction:
    """All rows, and with `out` Figures 7-12 as PNG files in that folder (made if absent). `seed` is that of the Monte Carlo study."""
    figures = () if out is None else _draw(out, seed, choices)
    tables = (*_table_2(), *_table_3(), *_table_4(), *_table_5())
    return Reproduction(rows=(*tables, *_path_facts(), *_selector_facts(), *_crash_facts(seed, choices)), figures=figures)


def _table_2() -> Iterator[Row]:
    before = duty_of_speed(published.HOST_KMH, published.FASTEST_KMH)
    yield _row("Table 2: D_(R-1)", published.DUTY_OF_REAR, duty_of_speed(published.REAR_KMH, published.FASTEST_KMH), "eq 10, 60 / 240 km/h")
    yield _row("Table 2: D_(H-1)", published.DUTY_OF_HOST_BEFORE, before, "40 / 240 km/h, printed to eight digits")
    yield _row("Table 2: D_H", published.DUTY_OF_HOST, next_duty(before, published.REAR_KMH, published.FASTEST_KMH), "eq 11")


def _table_3() -> Iterator[Row]:
    reading = "eq 20-23 with a = -0.4, b = 50, y_max = 3.7 m, x = 20 m, y(0) = (y_max +- off) / (1 + b); y positive right"
    for row in published.TABLE_3:
        left, right = float(y_left(SETTLING_X_M, row.offset)), float(y_right(SETTLING_X_M, row.offset))
        absolute_left, absolute_right = -(Y_MAX_M - row.offset), Y_MAX_M + row.offset
        computed = (
            ("y (LSD)", row.y_left, left),
            ("absolute y (LSD)", row.absolute_left, absolute_left),
            ("y error (LSD)", row.error_left, absolute_left - left),
            ("y (RSD)", row.y_right, right),
            ("absolute y (RSD)", row.absolute_right, absolute_right),
            ("y error (RSD)", row.error_right, absolute_right - right),
        )
        off = f"{row.offset:+g}" if row.offset else "0"
        for name, value, ours in computed:
            yield _row(f"Table 3: off {off} m, {name}", value, ours, reading, "m")
    starts = [abs(float(y(0.0, row.offset))) for row in published.TABLE_3 for y in (y_left, y_right)]
    yield _row("Table 3: initial positions", 0.0, max(starts), "largest of the 18; y(0) is subtracted", "m")


def _table_4() -> Iterator[Row]:
    offsets = [row.offset for row in published.TABLE_3]
    left = [-(Y_MAX_M - off) - float(y_left(SETTLING_X_M, off)) for off in offsets]
    right = [Y_MAX_M + off - float(y_right(SETTLING_X_M, off)) for off in offsets]
    ranges = (
        ("LSD, least", published.TABLE_4_LEFT[0], max(left)),
        ("LSD, largest", published.TABLE_4_LEFT[1], min(left)),
        ("RSD, least", published.TABLE_4_RIGHT[0], min(right)),
        ("RSD, largest", published.TABLE_4_RIGHT[1], max(right)),
    )
    for name, value, ours in ranges:
        yield _row(f"Table 4: error range {name}", value, ours, "the extremes of Table 3", "m")
    yield _row("text below Table 4: least error", published.SLIP_IN_THE_TEXT, min(right), "the text's 0.0638 is a slip for 0.0613773", "m")


def _table_5() -> Iterator[Row]:
    for b, value in zip(published.TABLE_5_B, reversed(published.TABLE_5_ERROR), strict=True):
        yield _row(
            f"Table 5: error at b = {b:g}",
            value,
            Y_MAX_M / (1.0 + b),
            "the asymptotic error y_max / (1 + b) of eq 28; printed to two digits",
            "m",
        )
    for b, value in zip(published.TABLE_5_B, reversed(published.TABLE_5_ERROR), strict=True):
        yield _row(
            f"Table 5 by Table 3's criterion: error at b = {b:g}",
            value,
            Y_MAX_M + float(y_parking(-SETTLING_X_M, b=b)),
            "eq 28 at x = -20 m, as Table 3 measures it: not what is printed",
            "m",
        )


def _path_facts() -> Iterator[Row]:
    path = literal_path(Side.LEFT, 0.0)
    for kmh in (40.0, 60.0, 80.0, 100.0):
        yield _ours(
            f"literal path at {kmh:g} km/h: lateral peak",
            peak_lateral_acceleration(path, kmh * KMH) / GRAVITY_MPS2,
            "v^2 kappa at constant path speed, exact curvature, off = 0; eq 22 ignores speed",
            "g",
        )
    for kmh in (40.0, 60.0, 80.0, 100.0):
        yield _ours(
            f"literal path at K = {kmh:g} km/h: lateral peak",
            (kmh * KMH) ** 2 * Y_MAX_M * 0.4**2 / (6.0 * math.sqrt(3.0)) / GRAVITY_MPS2,
            "K^2 y'' at constant dx/dt = K, as eq 21 has it",
            "g",
        )
    unit_peak = peak_lateral_acceleration(path, 1.0)
    for share in (0.4, 0.8):
        yield _ours(
            f"literal path: fastest speed at {share:g} g",
            math.sqrt(share * GRAVITY_MPS2 / unit_peak) / KMH,
            "v^2 kappa at constant path speed, off = 0",
            "km/h",
        )
    speeds = np.linspace(20.0, 130.0, 111)
    worst = max(peak_lateral_acceleration(corrected(0.0, 0.0, Y_MAX_M, v * KMH, BOUND_MPS2), v * KMH) for v in speeds)
    yield _ours("corrected path, 20-130 km/h: peak / bound", worst / BOUND_MPS2, f"a*(v), bound {BOUND_MPS2:g} m/s^2; 1 or less is kept")
    time = 25.0 / ((published.REAR_KMH - published.HOST_KMH) * KMH)
    a = 2.0 * math.log(50.0) / (time * published.HOST_KMH * KMH)
    needed = (published.HOST_KMH * KMH) ** 2 * (Y_MAX_M * 51.0 / 49.0) * a**2 / (6.0 * math.sqrt(3.0))
    yield _ours(
        "corrected path in a 25 m gap's time: lateral peak",
        needed / GRAVITY_MPS2,
        f"60 against 40 km/h leave {time:.2g} s; the whole of them used for one lane",
        "g",
    )
    yield _ours(
        "literal path: heading jump at the start", math.degrees(starting_heading_jump(path)), "atan of the slope at x = 0, off = 0", "deg"
    )
    width = Vehicle().width_m
    yield _row(
        "largest |off| on a three-lane road",
        2.0,
        1.5 * Y_MAX_M - 0.5 * width - Y_MAX_M,
        f"from the middle lane, lanes of {Y_MAX_M:g} m, car {width:g} m wide; the paper draws up to 2 m",
        "m",
    )
    yield _ours(
        "eq 11: acceleration from 40 to 60 km/h",
        implied_acceleration(published.HOST_KMH * KMH, published.REAR_KMH * KMH) / GRAVITY_MPS2,
        f"deadbeat, within one sample of {SAMPLE_S:g} s",
        "g",
    )
    yield _ours(
        "eq 24: commanded speed",
        commanded_speed(published.REAR_KMH, published.HOST_KMH, published.FASTEST_KMH, published.HOST_KMH / published.FASTEST_KMH),
        "V_VM read as the host's speed, 40 km/h; read as V_HM it is 60 km/h",
        "km/h",
    )
    yield _ours(
        "eq 5-7: speed of a front vehicle at 40 km/h",
        float(target_speed_literal(60.0, 20.0)),
        "host 60 km/h, closing 20 km/h: V_T = V_H + V_R has the sign of the rear vehicle",
        "km/h",
    )


def _selector_facts() -> Iterator[Row]:
    yield _ours(
        "Table 1 at d_f = d_r = 25 m, 60/40/40 km/h",
        literal_mode((25.0, 40.0), (25.0, 60.0), 40.0) or "no mode",
        "the row of the curvilinear motion asks d_r < 25 m",
    )
    yield _ours(
        "Table 1 with nothing known",
        literal_mode(None, None, 40.0, known=False),
        "row 5, literally: losing every track selects reverse parking",
    )
    n, generator = 1_000_000, np.random.default_rng(1)
    d_f, d_r = generator.uniform(0.0, 100.0, (2, n))
    v_f, v_r, v_h = generator.uniform(0.0, 40.0, (3, n))
    dangerous = (d_f < 3.0 * (v_h - v_f)) | (d_r < 3.0 * (v_r - v_h))
    rows = literal_rows(True, d_f, v_f, True, d_r, v_r, v_h)
    yield _ours(
        "Table 1: share of dangerous states with a mode",
        100.0 * float(np.mean(rows[dangerous] > 0)),
        "both vehicles present, time to collision under 3 s; uniform gaps to 100 m, speeds to 40 m/s",
        "%",
    )


def _crash_facts(seed: int, choices: TrackingChoices) -> Iterator[Row]:
    for zone in published.CRASH_ZONE_M:
        gap = zone / 3.0
        yield _row(
            f"Fig 9: crash position at a gap of {gap:.1f} m",
            zone,
            crash_position(gap, published.REAR_KMH * KMH, published.HOST_KMH * KMH),
            "from the rear vehicle's start: 3 x gap at 60 against 40 km/h; so 100-120 m means a gap of 33-40 m",
            "m",
        )
    for name, kmh in (("7", published.REAR_KMH), ("8", published.FRONT_KMH)):
        yield _row(
            f"Fig {name}: distance in 11 samples at {kmh:g} km/h",
            published.SETTLED_AT_M,
            published.SAMPLES * published.SAMPLE_S * kmh * KMH,
            "the 250 m of the text cannot be reached in 11 samples of 0.5 s",
            "m",
        )
    result = study(seed, choices)
    chosen = choices.in_words()
    half = [0.5 * float(np.ptp(np.percentile(result.rear_error_y[:, k], [2.5, 97.5]))) for k in (0, -1)]
    yield _row("Fig 7: 95 % band of y at the start, half width", published.FIRST_DEVIATION_M, half[0], chosen, "m")
    yield _ours("Fig 7: 95 % band of y at the end, half width", half[1], chosen, "m")
    for name, error in (("7", result.rear_error_x), ("8", result.front_error_x)):
        yield _ours(f"Fig {name}: RMS error of x at the end", float(np.sqrt(np.mean(error[:, -1] ** 2))), chosen, "m")
    for name, share in (("2.5 %", 2.5), ("median", 50.0), ("97.5 %", 97.5)):
        yield _ours(
            f"Fig 9: crash position as predicted at 5.5 s, {name}",
            float(np.percentile(result.crash_m[:, -1], share)),
            f"published zone 100-120 m; gap {choices.gap_m:.2f} m, truth {result.true_crash_m:.0f} m; {chosen}",
            "m",
        )


def _draw(out: Path, seed: int, choices: TrackingChoices) -> tuple[str, ...]:
    from mcdas_opt.plotting.reproduction import draw_figure_10, draw_figure_11, draw_figure_12, draw_figure_12_demand
    from mcdas_opt.plotting.style import save_png
    from mcdas_opt.plotting.tracking_bands import draw_figure_9, draw_trajectory_band

    bands = study(seed, choices)
    figures = {
        "figure-07": draw_trajectory_band(bands, "rear"),
        "figure-08": draw_trajectory_band(bands, "front"),
        "figure-09": draw_figure_9(bands),
        "figure-10": draw_figure_10(),
        "figure-11": draw_figure_11(),
        "figure-12": draw_figure_12(),
        "figure-12-demand": draw_figure_12_demand(BOUND_MPS2),
    }
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
        return tuple(str(save_png(figure, out / f"{name}.png")) for name, figure in figures.items())
