"""What plans look ahead to: poses in the plane, and what every plan would do to the limits; as the browser's scripts draw it."""

from __future__ import annotations

from itertools import accumulate
from typing import Any

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.plotting import style
from mcdas_opt.plotting.moments import HOST, Moment, Shown, View, aside, lane_colours
from mcdas_opt.plotting.plane import Ground, chart, rounded, view_document
from mcdas_opt.plotting.words import because, doing, judged, passed, sentence
from mcdas_opt.simulation.contact import clearances
from mcdas_opt.tracking.prediction import predict

BEHIND_M, AHEAD_M = 130.0, 330.0  # of road around the host
_EVERY_S = 0.1
_LONGEST_S = 8.0  # of a plan that is drawn
_SEEN_S = 4.0  # whoever comes near the road within it is in the window
_FAR_M = 30.0


class Outlook:
    """A situation in the plane; `plan` puts a plan into it."""

    def __init__(self, situation: Situation, vehicle: Vehicle) -> None:
        self.situation, self.vehicle = situation, vehicle
        host = situation.host
        self._ground = Ground(situation.road, host.s_m - BEHIND_M, host.s_m + AHEAD_M)
        self.bodies = predict(situation.tracks, None, situation.road, host.s_m).bodies
        rows = {track.id: k for k, track in enumerate(situation.tracks)}
        self._track = list(accumulate((rows.get(body.id, -1) for body in self.bodies), _or_before))
        self.supposed = [body.id not in rows for body in self.bodies]  # what the track before it may do besides

    def document(self) -> dict[str, Any]:
        """Road, bodies with their predicted poses over time, charts with their limits; and where the camera stands at those times.

        The camera goes on along the road at the host's present speed.
        """
        situation, ground, car = self.situation, self._ground, self.vehicle
        host = situation.host
        t = np.arange(0.0, _LONGEST_S + 1e-9, _EVERY_S)
        bodies = []
        for body, name, colour, supposed in zip(self.bodies, self.names(), self.colours(), self.supposed, strict=True):
            motion = body.at(t)
            poses = rounded(ground.place(motion.s_m, motion.d_m, motion.heading_rad))
            shown = {"name": name, "length": body.length_m, "width": body.width_m, "colour": colour, "poses": poses}
            bodies.append({**shown, "supposed": True} if supposed else shown)
        own = rounded(ground.place(host.s_m, host.d_m, host.heading_rad)[0], 3)
        return {
            "road": ground.document(),
            "view": view_document(self.view()),
            "cameras": rounded(ground.place(host.s_m + host.speed_mps * t, 0.0), 4),
            "host": {"name": "host", "length": car.length_m, "width": car.width_m, "colour": style.HOST, "pose": own},
            "bodies": bodies,
            "every": _EVERY_S,
            "charts": self.charts(),
        }  # fmt: skip

    def moment(self, plan: Plan, after_s: float = 0.0) -> Moment:
        """Everybody so long after now, the host as planned and the others as predicted; what the radar sees, only now."""
        car, x = self.vehicle, plan.trajectory
        s, d, psi, v = (float(np.interp(after_s, x.t_s, column)) for column in (x.s_m, x.d_m, x.heading_rad, x.speed_mps))
        others = tuple(
            Shown(
                name=name,
                pose=(float(then.s_m), float(then.d_m), float(then.heading_rad)),
                length_m=body.length_m,
                width_m=body.width_m,
                colour=colour,
                supposed=supposed,
            )
            for body, name, colour, supposed in zip(self.bodies, self.names(), self.colours(), self.supposed, strict=True)
            if after_s > 0.0 or not supposed  # now they are in one place
            for then in (body.at(np.array(after_s)),)
        )
        return Moment(
            time_s=self.situation.time_s + after_s,
            host=Shown(name=HOST, pose=(s, d, psi), length_m=car.length_m, width_m=car.width_m, colour=style.HOST),
            speed_mps=v,
            others=others,
            tracks=self.situation.tracks if after_s == 0.0 else (),
            plan=plan,
        )

    def plan(self, plan: Plan) -> dict[str, Any]:
        """A plan's poses, its quantities over time, and its words."""
        x = plan.trajectory
        known = np.flatnonzero(np.isfinite(x.s_m) & np.isfinite(x.d_m) & (x.t_s <= _LONGEST_S + 1e-9))
        t = x.t_s[known]
        marks = np.arange(1.0, float(t[-1]) + 1e-9) if known.size else np.zeros(0)
        at = [np.interp(marks, t, column[known]) for column in (x.s_m, x.d_m)] if known.size else [marks, marks]
        return {
            "t": rounded(t, 3),
            "poses": rounded(self._ground.place(x.s_m[known], x.d_m[known], x.heading_rad[known])),
            "seconds": rounded(self._ground.place(*at)[:, :2]),
            "lines": {key: rounded(values[known]) for key, values in self.quantities(x).items()},
            "passed": plan.verdict.passed,
            "end_known": plan.safe_end is not None,
            "status": plan.status.value,
            "doing": doing(plan),
            "words": sentence(plan),
            "verdict": judged(plan.verdict),
            "reason": because(plan),
            "warning": plan.alert is not Alert.NONE,
            "took_ms": round(plan.timing_ms.total, 1),
            "candidates": [
                {"name": c.name, "cost": None if c.cost is None else round(c.cost, 2), "passed": passed(c), "refusal": c.refusal}
                for c in plan.candidates
            ],
        }

    def quantities(self, x: Trajectory) -> dict[str, Array]:
        """Speed, acceleration, lateral acceleration v^2 tan(delta) / L, and the distance to the nearest predicted body."""
        lateral = x.speed_mps**2 * np.tan(x.steering_rad) / self.vehicle.wheelbase_m
        clearance = np.full(len(x), np.nan)
        finite = np.isfinite(x.states).all(axis=1)
        if self.bodies and finite.all():
            motions = tuple(body.at(x.t_s) for body in self.bodies)
            sizes = tuple((body.length_m, body.width_m) for body in self.bodies)
            clearance = clearances(x.states, (0,), motions, sizes, self.vehicle, self.situation.road)
        return {"speed": x.speed_mps, "acceleration": x.acceleration_mps2, "lateral": lateral, "clearance": clearance}

    def charts(self) -> list[dict[str, Any]]:
        """Title, unit, range and limits (value, word, whether it is a hard one) of each of the `quantities`."""
        car, grip = self.vehicle, self.situation.road.grip_mps2
        v, wanted, limit = self.situation.host.speed_mps, self.situation.wanted_speed_mps, self.situation.road.speed_limit_mps
        fastest = max([v, wanted, *(abs(body.at(0.0).speed_s_mps.item()) for body in self.bodies)])
        low, high = max(car.acceleration_min_mps2, -grip), min(car.acceleration_max_mps2, grip)
        slowest = min([v, wanted, *(abs(body.at(0.0).speed_s_mps.item()) for body in self.bodies)])
        kept = [(wanted, "desired", False), (limit, "speed limit", False)]
        return [
            chart("speed", "m/s", max(slowest - 4.0, 0.0), fastest + 4.0, kept, key="speed"),
            chart(
                "acceleration", "m/s²", 1.2 * low, 1.5 * high, [(low, "hardest braking", True), (high, "most", True)], key="acceleration"
            ),
            chart("lateral acceleration", "m/s²", -1.3 * grip, 1.3 * grip, [(grip, "grip", True), (-grip, "grip", True)], key="lateral"),
            chart("clearance, as predicted", "m", -0.12 * _FAR_M, _FAR_M, [(0.0, "touch", True)], key="clearance"),
        ]

    def view(self) -> View:
        """A window that holds the neighbours where it can, and the road's bend across its length."""
        host, road = self.situation.host, self.situation.road
        away = [track.s_m - host.s_m for track in self.situation.tracks]
        back = min(max([-s + 7.0 for s in away] + [15.0]), 60.0)
        ahead = min(max([s + 9.0 for s in away] + [3.2 * host.speed_mps, 40.0]), 85.0)
        then = [body.at(np.arange(0.0, _SEEN_S + 1e-9)) for body in self.bodies]
        near = [q.d_m[(q.s_m > host.s_m - back) & (q.s_m < host.s_m + ahead)] for q in then]
        right, left = aside(np.concatenate([*near, np.zeros(0)]), road.right_edge_m - 1.2, road.left_edge_m + 2.2)
        kappa = road.curvature_at(np.linspace(host.s_m - back, host.s_m + ahead, 100))
        for reach in (back, ahead):
            left = max(left, min(road.left_edge_m + 2.2 + 0.5 * reach**2 * float(kappa.max()), 24.0))
            right = min(right, max(road.right_edge_m - 1.2 + 0.5 * reach**2 * float(kappa.min()), -24.0))
        return View(back_m=back, ahead_m=ahead, right_m=right, left_m=left)

    def colours(self) -> list[str]:
        """Of the bodies: orange for the next ahead in the host's lane, vermilion for the next behind, grey for the rest."""
        host = self.situation.host
        away = [(track.s_m - host.s_m, track.d_m - host.d_m) for track in self.situation.tracks]
        colours = lane_colours(away, self.situation.road.lane_width_m)
        return [colours[k] for k in self._track]

    def names(self) -> list[str]:
        """What the bodies are called in a picture: a name that the situation gives, else what the track's number is to the host."""
        words = {style.FRONT: "front", style.REAR: "rear"}
        bodies = zip(self.bodies, self.colours(), strict=True)
        return [f"{words.get(colour, 'track')} {body.id}" if body.id.split(" ")[0].isdigit() else body.id for body, colour in bodies]


def _or_before(before: int, row: int) -> int:
    return before if row < 0 else row
