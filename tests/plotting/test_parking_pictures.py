"""Parking pictures are made, and closed forms have some too."""

import pytest

from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.park import park
from mcdas_opt.plotting import parking as parking_pictures
from mcdas_opt.plotting.parking import frames, save, sheet, slot_sweep


def test_a_sheet_and_an_animation(tmp_path, monkeypatch):
    monkeypatch.setattr(parking_pictures, "_MOST_FRAMES", 5)
    case = slot_case(8.5)
    answer = park(case, "two-arc")
    assert len(sheet(case, answer).axes) == 3
    pictures, milliseconds = frames(case, answer)
    assert len(pictures) == len(milliseconds)
    assert sum(milliseconds[:-1]) == pytest.approx(1e3 * (answer.duration_s or 0.0), rel=0.05)
    assert save(case, answer, tmp_path / "two.png").stat().st_size > 10_000


def test_a_refusal_cannot_be_drawn():
    case = slot_case(4.55)
    with pytest.raises(ValueError, match="refusal"):
        sheet(case, park(case))


def test_the_sweep_names_every_planner():
    rows = [
        {"case": f"{r} L", "planner": p, "status": "planned", "duration_s": str(d)}
        for r, p, d in (("1.6", "nlp", 6.5), ("1.2", "nlp", 31.0), ("1.6", "search", 13.0))
    ]
    figure = slot_sweep(rows, {"two-arc": 6.47, "closed-form": 11.7, "closed-form-corrected": None}, 4.5)
    labels = {text.get_text() for text in figure.axes[0].get_legend().get_texts()}
    assert {"nlp", "search", "two-arc needs 1.44 L"} <= labels
