"""After an emergency: does the car come back to ordinary driving?"""

from __future__ import annotations

from mcdas_opt.domain.vocabulary import Alert, Mode, Status
from mcdas_opt.simulation.ordinary import HEADWAYS_S, Instant
from mcdas_opt.simulation.record import Cycle, Outcome, Simulation

CALM_S = 1.0  # so long before the drive's end nothing of an emergency is left
_OFFSET_M, _HEADING_RAD = 0.3, 0.03  # from the lane's middle and its direction
_SLOWER_MPS, _GAINING_MPS2 = 3.0, 0.2  # than it might drive, or gaining speed
_HARD_MPS2 = 3.5


def ordinary_again(run: Simulation, instants: tuple[Instant, ...]) -> bool | None:
    """Whether a drive with an emergency ended in ordinary driving: calm, in the middle of a lane, as fast as desired, limit and leader
    let it (or gaining speed), and with a time gap of 0.8 s (or an opening one). None without an emergency; false where it ended in none."""
    emergencies = [cycle.time_s for cycle in run.cycles if _emergency(cycle)]
    if not emergencies:
        return None
    if run.outcome is not Outcome.SAFE or emergencies[-1] > run.duration_s - CALM_S:
        return False
    road, last = run.scene.true_road, instants[-1]
    s, d, heading = float(run.trajectory.s_m[-1]), float(run.trajectory.d_m[-1]), float(run.trajectory.heading_rad[-1])
    bend = float(road.curvature_at(run.trajectory.s_m[-1])) * run.scene.vehicle.centre_m
    settled = abs(d - road.lane_centre_m(road.lane_of(d, s), s)) < _OFFSET_M and abs(heading + bend) < _HEADING_RAD
    most = min(run.scene.desired_speed_mps, road.speed_limit_mps, *([last.leader.speed_mps] if last.leader is not None else []))
    fast = last.speed_mps > most - _SLOWER_MPS or last.acceleration_mps2 > _GAINING_MPS2
    gap = last.headway_s is None or last.headway_s >= HEADWAYS_S[-1] or (last.leader is not None and last.leader.speed_mps > last.speed_mps)
    return settled and fast and gap


def _emergency(cycle: Cycle) -> bool:
    """Somebody was alarmed, steered out, fell back on a lower rung, or braked hard."""
    plan = cycle.plan
    alarmed = plan.alert is not Alert.NONE or plan.warning or plan.status is not Status.PLANNED
    return alarmed or plan.mode is Mode.EVADE or cycle.host.acceleration_mps2 < -_HARD_MPS2
