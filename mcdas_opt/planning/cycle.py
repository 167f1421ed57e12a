"""One planning cycle: what everybody in it needs, made once."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.doubt import Doubt
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import LEAST_SHARE, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.variant import names_of
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.planning.deadline import Deadline, Stage
from mcdas_opt.planning.front.blind_ahead import BlindAhead
from mcdas_opt.planning.front.front_braking import FrontBraking
from mcdas_opt.planning.front.front_deficit import front_deficits
from mcdas_opt.planning.front.front_gap import FrontGap, cut_in
from mcdas_opt.planning.lanes.arriving_gap import gets_past_somebody
from mcdas_opt.planning.lanes.best_gap import best_gap
from mcdas_opt.planning.lanes.gap import Gap
from mcdas_opt.planning.lanes.kept_offset import kept_d_m
from mcdas_opt.planning.lanes.lane_choice import lane_choice
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.lanes.merging_gap import hurries
from mcdas_opt.planning.lanes.neighbours import demanded_braking_mps2, neighbours_in
from mcdas_opt.planning.lanes.required_lane import RequiredLane, required_lane
from mcdas_opt.planning.lanes.withdrawal import is_withdrawn
from mcdas_opt.planning.memory import Memory, PreviousPlan, ReportedMode
from mcdas_opt.planning.traffic.local_situation import in_order, limit_mps, seen_locally, with_wanted_speed
from mcdas_opt.planning.traffic.observed import Observed
from mcdas_opt.planning.traffic.others import Others
from mcdas_opt.planning.traffic.reach import in_reach_ever
from mcdas_opt.situation.assess import assess
from mcdas_opt.situation.attentive_followers import attentive_followers, waits_at_a_line
from mcdas_opt.situation.doubts import believed
from mcdas_opt.situation.passed_in_lane import PassedInLane, passed_in_lane
from mcdas_opt.situation.passing_room import is_person
from mcdas_opt.tracking.follower_prediction import with_attentive_followers
from mcdas_opt.tracking.prediction import predict_for


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """A situation with what follows from it.

    `given` is the situation as it was asked. `situation` is the one that is planned in: its time counts from now and its s from near the
    host, its desired speed is within the limit, and its tracks are those that are believed (`situation/doubts.py`); `doubts` says why they
    are others. So neither a clock's origin nor a place along the road makes a difference. `given_from` brings back what is planned in it.

    In `prediction` an attentive follower (`observed.attentive`) brakes behind the host, in `unaided` he does not. `deadline` is by when
    the answer has to be there; None: work is counted, and nothing else bounds it.
    """

    given: Situation
    situation: Situation
    doubts: tuple[Doubt, ...]
    vehicle: Vehicle
    settings: Settings
    memory: Memory
    active: Manoeuvre | None
    observed: Observed
    assessment: Assessment
    front_braking: FrontBraking
    prediction: Prediction
    unaided: Prediction
    deadline: Deadline | None
    _others: dict[tuple[int, int], Others] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def of(
        cls,
        situation: Situation,
        vehicle: Vehicle,
        settings: Settings | None = None,
        memory: Memory | None = None,
        deadline: Deadline | None = None,
    ) -> Cycle:
        """Assesses and predicts. A memory that is not older than the situation is none; a manoeuvre that it holds is active until it is
        finished."""
        given, settings = situation, settings or Settings()
        memory = (memory or Memory()).seen_by(given)
        before, elapsed_s = memory.observed, memory.elapsed_s
        placed = seen_locally(given, memory.origin_m)
        plausible = believed(placed, before.tracks, elapsed_s, before.supposed, vehicle)
        waits = waits_at_a_line(plausible.situation, vehicle)
        situation = with_wanted_speed(plausible.situation, settings, vehicle)
        blind = BlindAhead.of(situation, placed.tracks, settings, before.blind_ahead, None if memory.is_empty else before.tracks, elapsed_s)
        situation = in_order(situation if blind is None else blind.driven_in(situation, settings))
        active = memory.active
        active = None if active is None or active.finished(situation) else active
        leaves_lane = active is not None and active.mode is Mode.CRUISE and not active.half_done(situation)
        choice = before.lane_choice
        passes_nobody = waits or active is not None
        choice = choice.resting if passes_nobody else lane_choice(situation, vehicle, settings, choice, elapsed_s)
        deficits = front_deficits(situation, vehicle, settings.safe_end, before.deficits, elapsed_s)
        attentive = attentive_followers(situation, vehicle, settings, before.attentive)
        in_lane = passed_in_lane(situation, vehicle, before.passed_in_lane, elapsed_s)
        assessment = assess(
            situation,
            vehicle,
            settings.selector,
            memory.assessment,
            elapsed_s,
            leaves_lane=leaves_lane,
            attentive=attentive,
            passed=in_lane.ids,
        )
        asked_m, steers = settings.headway.gap_m(situation.host.speed_mps), memory.active is not None
        unaided = predict_for(situation, settings.prediction)
        braking = with_attentive_followers(unaided, situation, attentive, settings.safe_end)
        return cls(
            given=given,
            situation=situation,
            doubts=plausible.doubts,
            vehicle=vehicle,
            settings=settings,
            memory=memory,
            active=active,
            observed=Observed(
                tracks=placed.tracks,
                supposed=plausible.supposed,
                deficits=deficits,
                cut_in=cut_in(assessment, memory.assessment, before.cut_in, elapsed_s, asked_m=asked_m, steers=steers),
                lane_choice=choice,
                attentive=attentive,
                passed_in_lane=in_lane,
                blind_ahead=blind,
            ),
            assessment=assessment,
            front_braking=FrontBraking.of(situation, assessment, vehicle, settings),
            prediction=in_reach_ever(braking, situation.host, vehicle, situation.road),
            unaided=unaided,
            deadline=deadline,
        )

    def given_from(self, plan: Plan, **signed: Any) -> Plan:
        """A plan of this cycle in the place and time of the situation as it was given, with what is doubted of that; `signed` so."""
        trajectory = plan.trajectory.seen_from(-self.origin_m)
        return replace(plan, trajectory=trajectory, time_s=self.given.time_s, doubts=self.doubts, **signed)

    def remember(self, plan: Plan, reported: ReportedMode | None = None) -> Memory:
        """What a plan of this cycle, reported so, means for the next one: the method's own part, and what holds for all of them."""
        return replace(
            plan.memory if isinstance(plan.memory, Memory) else Memory(),
            situation=self.given,
            origin_m=self.origin_m,
            elapsed_s=0.0,
            previous=PreviousPlan.of(plan),
            side=plan.side,
            alert=plan.alert,
            assessment=self.assessment,
            reported=reported,
            observed=self.observed,
        )

    @property
    def believed(self) -> Situation:
        """The situation as it was given, with the tracks that are planned around."""
        blind = self.observed.blind_ahead
        if not self.doubts and not self.observed.supposed and (blind is None or not blind.supposed):
            return self.given
        return replace(self.given, tracks=tuple(track.seen_from(-self.origin_m) for track in self.situation.tracks))

    @property
    def origin_m(self) -> float:
        """Where its s = 0 lies in the situation as it was given."""
        return self.memory.origin_m

    def others_at(self, t_s: Array, near_s_m: float) -> Others:
        """Everybody who is predicted at these times (n,), in the plane of the road's frame near there: worked out once."""
        rows, frame = self.prediction.rows_on(t_s), frame_near(self.situation.road, near_s_m)
        key = id(rows), id(frame)  # both are kept with what is found
        found = self._others.get(key)
        if found is None:
            found = self._others[key] = Others.of(self.prediction, rows, frame, self.vehicle)
        return found

    @cached_property
    def people(self) -> list[int]:
        """Which of the predicted bodies are people on foot or on two wheels."""
        names = {name for track in self.situation.tracks if is_person(track) for name in names_of(track.id)}
        return [i for i, body in enumerate(self.prediction.bodies) if body.id in names] if names else []

    def is_late_for(self, stage: Stage) -> bool:
        """Whether the deadline, where there is one, leaves no time to begin it."""
        return self.deadline is not None and self.deadline.is_over_for(stage)

    @cached_property
    def limit_mps(self) -> float:
        """The fastest that ordinary driving is."""
        return limit_mps(self.situation, self.settings)

    @cached_property
    def lane_centre_m(self) -> float:
        """The middle of the lane that holds the host's body centre."""
        road, host = self.situation.road, self.situation.host
        return road.lane_centre_m(self.situation.host_lane, host.s_m)

    @property
    def passed_in_lane(self) -> PassedInLane:
        """Who stands at the lane's side and is passed within it."""
        assert self.observed.passed_in_lane is not None
        return self.observed.passed_in_lane

    @property
    def kept_d_m(self) -> float:
        """Where the host drives in that lane now."""
        if self.passed_in_lane.bodies or self.passed_in_lane.offset_m != 0.0:
            return self.lane_centre_m + self.passed_in_lane.offset_m
        return kept_d_m(self.situation, self.vehicle, self.lane_centre_m)

    @property
    def destination(self) -> str:
        """How it stands with the destination: reached, ahead, or unreachable and why; empty without one."""
        given, wanted = self.given, self.given.destination
        if wanted is None:
            return ""
        if wanted.is_reached(given.host, given.time_s, given.road):
            return "reached"
        why = wanted.why_unreachable(given.host, given.time_s, given.road, self.vehicle)
        return f"unreachable: {why}" if why else "ahead"

    @cached_property
    def required_lane(self) -> RequiredLane | None:
        """Where to change lanes though nobody is slower; None where the host's lane leads on to where it is to go."""
        return required_lane(self.situation, self.vehicle)

    @cached_property
    def gap(self) -> Gap | None:
        """The one to go into in the lane that has to be reached; None where there is none, or no such lane, or nobody watches it."""
        required = self.required_lane
        if required is None or not self.situation.sees_lane(required.side):
            return None
        if self.slows_blindly and not required.own_lane_is_undrivable:
            return None
        return best_gap(self.situation, self.vehicle, self.settings, required, self.limit_mps)

    @cached_property
    def hurries_to_merge(self) -> bool:
        """Whether its lane ends, and those in the lane that leads on are faster: it speeds up, and brakes for the end, as hard as is
        comfortable."""
        return hurries(self.situation, self.required_lane)

    @property
    def open_gap(self) -> Gap | None:
        """The same where it can be gone into now."""
        return self.gap if self.gap is not None and self.gap.is_open else None

    @property
    def slows_blindly(self) -> bool:
        """Whether the host slows down because nobody watches ahead."""
        return self.observed.blind_ahead is not None and self.observed.blind_ahead.slows

    @property
    def is_ordinary(self) -> bool:
        """Whether nothing threatens but a front car for which gentle braking is enough."""
        return not self.assessment.threatened or (self.front_braking.is_gentle and not self.is_pressed)

    @property
    def is_pressed(self) -> bool:
        """Whether somebody closes in from behind."""
        return Sector.REAR in self.assessment.threats

    @property
    def attentive_follower(self) -> str | None:
        """Who is next behind in the host's lane, at a distance that he keeps, while driving is ordinary: expected to brake behind a host
        that keeps its lane; at the least headway, however fast, where the lane ends soon, which he has to brake for himself. None where
        there is no such follower."""
        rear, required = self.assessment.rear_id, self.required_lane
        if rear is None or not self.is_ordinary:
            return None
        ends_soon = required is not None and required.own_lane_ends
        least_m = self.settings.headway.gap_m(self.assessment.rear_speed_mps or 0.0, LEAST_SHARE)
        return rear if rear in self.observed.attentive or (ends_soon and self.assessment.rear_gap_m >= least_m) else None

    @cached_property
    def inconsiderate_sides(self) -> frozenset[Side]:
        """The sides in whose next lane somebody would have to brake harder than manners allow."""
        situation, vehicle, most = self.situation, self.vehicle, self.settings.manners.follower_braking_mps2
        lane, speed_mps = situation.host_lane, situation.host.speed_mps
        beside = {Side.LEFT: lane + 1, Side.RIGHT: lane - 1}
        return frozenset(
            side for side, other in beside.items() if demanded_braking_mps2(neighbours_in(other, situation, vehicle), speed_mps) > most
        )

    @cached_property
    def is_withdrawn(self) -> bool:
        """Whether the active manoeuvre is given up."""
        return self.active is not None and is_withdrawn(self.active, self.situation, self.vehicle, self.settings, self.required_lane)

    @cached_property
    def indicator(self) -> Side:
        """The side that the host's lane change is announced to, or goes on to."""
        if self.active is not None:
            return self.active.side if self.active.mode is Mode.CRUISE and not self.is_withdrawn else Side.NONE
        required, choice = self.required_lane, self.observed.lane_choice
        if required is not None:
            return required.side
        return choice.side if choice.is_announced else Side.NONE

    @cached_property
    def owed_m(self) -> dict[str, float]:
        """By name in the prediction: how short of the front distance that can be held (at most 0) others made it."""
        return {name: one.owed_m for one in self.observed.deficits for name in names_of(one.id)}

    @cached_property
    def front_gap(self) -> FrontGap:
        """What is asked for of the gap ahead, and how it stands with that."""
        gets_past = self.active is None and gets_past_somebody(self.required_lane, self.gap)
        speed_mps, is_pressed = self.situation.host.speed_mps, self.is_pressed
        return FrontGap.of(self.assessment, self.observed.cut_in, self.settings, speed_mps, is_pressed=is_pressed, gets_past=gets_past)
