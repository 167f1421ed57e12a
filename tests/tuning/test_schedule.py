"""The gain schedule: what is shipped is what the designer finds, the lookup is what it says, and the bound is kept by whatever is drawn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.tuning import schedule_sheet
from mcdas_opt import simulate
from mcdas_opt.catalogue.designs import load_schedule
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.planning.method import known_methods
from mcdas_opt.plotting.style import save_png
from mcdas_opt.reference.steering_demand import peak_lateral_acceleration
from mcdas_opt.reference.tuned_path import tuned_path
from mcdas_opt.tuning.schedule import build_schedule, schedule_text
from tests.plotting.pixels import coloured, pixels

SHIPPED = load_schedule("sedan")
DRAWS = 100_000


def test_100_000_random_paths_keep_the_bound_on_lateral_acceleration() -> None:
    """Speed, displacement, offset, friction, bound and the tables themselves drawn at random, far outside the grid too.

    The exact curvature of d(s) at 61 points of each path, times v^2; drawn in one piece, the path's own numbers by `tuned_path`.
    """
    rng = np.random.default_rng(7)
    v = rng.uniform(0.5, 60.0, DRAWS)
    across = rng.uniform(0.0, 9.0, DRAWS) * rng.choice([-1.0, 1.0], DRAWS)
    bound = rng.uniform(0.2, 9.0, DRAWS)
    offset, friction = rng.uniform(-4.0, 4.0, DRAWS), rng.uniform(0.05, 1.2, DRAWS)
    wild = replace(SHIPPED, a_per_m=SHIPPED.a_per_m * 5.0)  # a table that by itself breaks every bound
    a, b = np.empty(DRAWS), np.empty(DRAWS)
    for i in range(DRAWS):
        path = tuned_path(
            SHIPPED if i % 2 else wild,
            start_s_m=0.0,
            start_d_m=0.0,
            target_d_m=across[i],
            speed_mps=v[i],
            offset_m=offset[i],
            friction=friction[i],
            lateral_acceleration_mps2=bound[i],
        )
        a[i], b[i] = path.a_per_m, path.b
    gain = across * (b + 1.0) / (b - 1.0)
    worst = np.zeros(DRAWS)
    for share in np.linspace(0.0, 1.0, 61):
        start = 1.0 / (1.0 + b)
        shape = start + (1.0 - 2.0 * start) * share
        q = shape * (1.0 - shape)
        first, second = -gain * a * q, gain * a**2 * q * (1.0 - 2.0 * shape)
        worst = np.maximum(worst, v**2 * np.abs(second) / (1.0 + first**2) ** 1.5)
    assert np.all(worst <= bound * (1.0 + 1e-12))
    assert (worst > 0.9 * bound).mean() > 0.2  # the bound is reached: it is not kept by being lazy


@settings(max_examples=60)
@given(v=st.floats(3.0, 45.0), mu=st.floats(0.2, 1.0), across=st.floats(0.2, 6.0), offset=st.floats(-2.0, 2.0), share=st.floats(0.1, 1.0))
def test_no_slower_speed_on_the_same_path_asks_for_more(v: float, mu: float, across: float, offset: float, share: float) -> None:
    bound = min(4.0, 0.6 * mu * GRAVITY_MPS2)
    path = tuned_path(
        SHIPPED,
        start_s_m=5.0,
        start_d_m=-1.0,
        target_d_m=-1.0 + across,
        speed_mps=v,
        offset_m=offset,
        friction=mu,
        lateral_acceleration_mps2=bound,
    )
    assert peak_lateral_acceleration(path, share * v) <= bound + 1e-12
    assert float(path.d(path.start_s_m + path.length_m)) == pytest.approx(-1.0 + across)


def test_the_shipped_tables_are_what_the_designer_finds() -> None:
    speeds, offsets, frictions = SHIPPED.speed_mps[::5], SHIPPED.offset_m[::2], SHIPPED.friction[::2]
    again = build_schedule("again", speeds_mps=speeds, offsets_m=offsets, frictions=frictions)
    for key in ("a_per_m", "b", "y_max_m", "length_m"):
        assert np.allclose(getattr(again, key), getattr(SHIPPED, key)[::2, ::2, ::5], rtol=1e-5)


def test_at_the_crossings_the_lookup_is_the_table_and_between_them_it_is_continuous() -> None:
    for i, j, k in np.ndindex(SHIPPED.a_per_m.shape):
        point = (SHIPPED.speed_mps[k], SHIPPED.offset_m[j], SHIPPED.friction[i])
        a, b, y_max = SHIPPED.at(*point)
        assert (a, b, y_max) == pytest.approx((SHIPPED.a_per_m[i, j, k], SHIPPED.b[i, j, k], SHIPPED.y_max_m[i, j, k]), rel=1e-12)
        near = SHIPPED.at(point[0] * (1.0 + 1e-9), point[1] + 1e-9, point[2] + 1e-9)
        assert near == pytest.approx((a, b, y_max), rel=1e-6)
    beyond, end = SHIPPED.at(2.0 * SHIPPED.speed_mps[-1], 0.0, 0.9), SHIPPED.at(SHIPPED.speed_mps[-1], 0.0, 0.9)
    assert beyond[1:] == end[1:]


def test_offsets_move_y_max_alone_where_nobody_is_in_the_way() -> None:
    assert np.ptp(SHIPPED.a_per_m, axis=1).max() < 1e-6
    assert np.allclose(SHIPPED.y_max_m + np.array(SHIPPED.offset_m)[None, :, None], 3.7, atol=0.0101)


def test_the_file_gives_back_the_schedule(tmp_path: Path) -> None:
    small = build_schedule("small", speeds_mps=(10.0, 20.0), offsets_m=(0.0,), frictions=(0.5, 0.9))
    file = tmp_path / "small.toml"
    file.write_text(schedule_text(small), encoding="utf-8")
    kept = load_schedule(file)
    assert np.array_equal(kept.a_per_m, small.a_per_m)
    assert kept.speed_mps == small.speed_mps
    file.write_text(schedule_text(small).replace("    10.0,\n    20.0,", "    20.0,\n    10.0,", 1), encoding="utf-8")
    with pytest.raises(InputError, match="must increase"):
        load_schedule(file)


def test_tables_must_fit_their_axes() -> None:
    with pytest.raises(ParameterError, match="must be a finite table"):
        replace(SHIPPED, speed_mps=SHIPPED.speed_mps[:-1])
    with pytest.raises(ParameterError, match="less than 0"):
        replace(SHIPPED, a_per_m=-SHIPPED.a_per_m)
    one = GainSchedule(
        name="one",
        speed_mps=(10.0,),
        offset_m=(0.0,),
        friction=(0.9,),
        a_per_m=np.full((1, 1, 1), -0.2),
        b=np.full((1, 1, 1), 50.0),
        y_max_m=np.full((1, 1, 1), 3.7),
        length_m=np.full((1, 1, 1), 30.0),
    )
    assert one.at(20.0, 3.0, 0.1) == pytest.approx((-0.1, 50.0, 3.7))


def test_closed_form_tuned_is_a_planner_that_drives() -> None:
    assert "closed-form-tuned" in known_methods()
    run = simulate(load_scene("sandwich-60-40"), planner="closed-form-tuned")
    assert run.outcome == "safe"
    assert run.lane_change_completed
    assert run.max_lateral_acceleration_mps2 <= 4.0 * 1.02


def test_the_schedule_is_drawn(tmp_path: Path) -> None:
    figure = schedule_sheet(SHIPPED)
    assert [axes.get_ylabel() for axes in figure.axes] == ["a [1/m]", "b [-]", "length [m]"]
    j = int(np.argmin(np.abs(SHIPPED.offset_m)))
    for axes, table in zip(figure.axes, (SHIPPED.a_per_m, SHIPPED.b, SHIPPED.length_m), strict=True):
        *drawn, paper = axes.lines
        assert len(drawn) == len(SHIPPED.friction)
        for i, line in enumerate(drawn):
            np.testing.assert_array_equal(line.get_ydata(), table[i, j])
            np.testing.assert_allclose(line.get_xdata(), 3.6 * np.array(SHIPPED.speed_mps))
        assert paper.get_label().startswith("paper: ")
    shown = pixels(save_png(figure, tmp_path / "schedule.png"))
    for line in figure.axes[2].lines:
        assert coloured(shown, line.get_color()).sum() > 100, line.get_label()


@pytest.mark.parametrize("axis", [(-1e308, 1e308, -1e308), (1.0, 1.0)])
def test_an_axis_that_does_not_increase_is_refused_whatever_its_numbers(axis: tuple[float, ...]) -> None:
    with pytest.raises(ParameterError, match="must increase"):
        replace(SHIPPED, friction=axis)
