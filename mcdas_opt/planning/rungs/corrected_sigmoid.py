"""The corrected sigmoid, driven by the bicycle without an optimiser."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mcdas_opt.domain.plan import Candidate
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.planning.candidate import Checked
from mcdas_opt.planning.candidates.driven_closed_form import closed_form, groups
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage

NAME = "the corrected sigmoid"


def corrected_sigmoid(cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    """What the closed form chooses; nothing where the driver asks to park, or the deadline is near."""
    if cycle.situation.request is Request.PARK or cycle.is_late_for(Stage.CLOSED_FORM):
        return
    found = closed_form(cycle, groups(cycle))
    rows += [one.row() for one in found.tried]
    checked = found.chosen.checked
    yield checked.proposed_as(replace(checked.proposed, name=NAME))
