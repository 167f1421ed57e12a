"""Every planner, kept warm between questions."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.sensors import NONE
from mcdas_opt.domain.settings import Settings, SigmoidSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import McdasError
from mcdas_opt.planning.method import build_method, known_methods
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.planner import Planner
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.plotting.web import PLANNERS
from mcdas_opt.simulation.judging import exact_tracks
from mcdas_opt.time_to_react.escapes import escapes

ORDER = tuple(PLANNERS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """A situation to answer; `name` is the scene's or the log's, `sigmoid` the closed form's numbers."""

    name: str
    situation: Situation
    vehicle: Vehicle
    sigmoid: SigmoidSettings = field(default_factory=SigmoidSettings)


def methods() -> tuple[str, ...]:
    """Our planners, as far as they are registered, then everybody else's."""
    known = known_methods()
    return (*(name for name in ORDER if name in known), *(name for name in known if name not in ORDER))


def installed(names: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the planners that can be built with what is installed."""
    found = []
    for name in names:
        with suppress(McdasError, ImportError):
            build_method(name, Vehicle(), Settings())
            found.append(name)
    return tuple(found)


def first_look(scene: Scene) -> Situation:
    """The scene at t = 0 as perfect sensors see it; a sector without a sensor stays unwatched."""
    watched = {sector.value: scene.sensors.of(sector) != NONE for sector in Sector}
    return Situation(
        host=scene.host_state,
        tracks=exact_tracks(scene),
        coverage=Coverage(**watched),
        road=scene.assumed_road,
        vehicle=scene.host.vehicle,
        desired_speed_mps=scene.desired_speed_mps,
        request=scene.request,
    )


class PlannerCache:
    """Keeps one planner of every method. Belongs to one thread, as its planners do."""

    def __init__(self) -> None:
        self._planners: dict[str, Planner] = {}

    def plan(self, name: str, question: Question) -> dict[str, Any]:
        """The part of the answer that the planner of that name gives."""
        planner = self._planner(name, question.vehicle, question.sigmoid)
        planner.reset()
        plan = planner.plan(question.situation)
        return {"part": "plan", "planner": name, **Outlook(question.situation, question.vehicle).plan(plan)}

    def escapes(self, question: Question) -> dict[str, Any]:
        """The part of the answer that tells until when each manoeuvre can begin."""
        return {"part": "escapes", "escapes": escapes(question.situation, question.vehicle).to_dict()}

    def _planner(self, name: str, vehicle: Vehicle, sigmoid: SigmoidSettings) -> Planner:
        """A warm planner; other settings of the sigmoid leave the MPC's solvers as they are, for they are parameters of its paths."""
        old = self._planners.get(name)
        if old is not None and old.vehicle == vehicle and old.settings.sigmoid == sigmoid:
            return old
        made = Planner(vehicle, name, settings=Settings(sigmoid=sigmoid))
        if old is not None and old.vehicle == vehicle and isinstance(old.method, MpcMethod) and isinstance(made.method, MpcMethod):
            made.method.solvers = old.method.solvers
        self._planners[name] = made
        return made
