"""A followed manoeuvre as a moving picture and as a page: whoever stood in the way is there as long as they stood there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.errors import InputError
from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.closed_loop.record import ParkingDrive, ParkingOutcome
from mcdas_opt.parking.closed_loop.sight import Visitor
from mcdas_opt.parking.park import park
from mcdas_opt.plotting import parking as parking_pictures
from mcdas_opt.plotting import style
from mcdas_opt.plotting.export import save_picture
from mcdas_opt.plotting.player import follow_document

_VERMILION = np.array([int(style.VERMILION[k : k + 2], 16) for k in (1, 3, 5)])


@pytest.fixture(scope="module")
def driven() -> tuple[ParkingCase, ParkingDrive]:
    """The plan as if it had been driven, somebody standing aside in its first half."""
    case = slot_case(8.5)
    plan = park(case, "two-arc").trajectory
    assert plan is not None
    somebody = Visitor(x_m=4.0, y_m=3.2, from_s=0.0, until_s=0.5 * plan.duration_s)
    drive = ParkingDrive(
        name=case.name,
        planner="two-arc",
        seed=0,
        outcome=ParkingOutcome.PARKED,
        reason="",
        duration_s=plan.duration_s,
        end_position_error_m=0.0,
        end_heading_error_rad=0.0,
        min_clearance_m=0.1,
        collided_with=None,
        replans=1,
        stops_judged=0,
        stops_unsound=0,
        stops_driven=0,
        max_across_m=0.0,
        max_heading_rad=0.0,
        max_along_m=0.0,
        trajectory=plan,
        visitors=(somebody,),
        truth=case,
    )
    return case, drive


def test_the_animation_shows_a_person_while_they_are_there(
    driven: tuple[ParkingCase, ParkingDrive], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parking_pictures, "_MOST_FRAMES", 5)
    with Image.open(save_picture(driven[1], tmp_path / "follow.gif")) as gif:
        seen = []
        for k in range(gif.n_frames):
            gif.seek(k)
            off = np.abs(np.asarray(gif.convert("RGB"), dtype=int) - _VERMILION).max(axis=2)
            seen.append(bool((off < 12).sum() > 20))
    assert seen in ([True, True, False, False, False], [True, True, True, False, False])


def test_the_page_holds_people_times_and_the_last_place(driven: tuple[ParkingCase, ParkingDrive], tmp_path: Path) -> None:
    case, drive = driven
    document = follow_document(case, drive)
    (person,) = document["yard"]["people"]
    assert person["until"] == pytest.approx(0.5 * drive.duration_s)
    assert document["manoeuvre"]["poses"][-1] == pytest.approx(drive.trajectory.poses[-1].tolist(), abs=1e-4)
    assert len(document["manoeuvre"]["t"]) < 0.5 * len(drive.trajectory) or len(drive.trajectory) < 400
    assert document["words"].endswith("1 plan anew")
    assert "1 plan anew" in save_picture(drive, tmp_path / "follow.html").read_text("utf-8")


def test_other_suffixes_are_refused(driven: tuple[ParkingCase, ParkingDrive], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must end in \.png, \.svg, \.pdf, \.gif or \.html"):
        save_picture(driven[1], tmp_path / "follow.txt")
