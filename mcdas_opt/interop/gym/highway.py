"""Our planner as the agent in highway-env's `highway-v0`, and that environment's own IDM/MOBIL agent beside it, episode by episode."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import positive, require, whole
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.errors import MissingExtraError, ParameterError
from mcdas_opt.interop.gym.road_side import RoadSide, highway_vehicle, road_of
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.ordinary import Instant, OrdinaryDriving, Placed, instant, ordinary_driving

CYCLE_S = 0.1
LANES, WANTED_MPS = 4, 30.0  # the speed is the ego's; the others want 21 to 24
AHEAD_M, BEHIND_M = 150.0, 100.0  # how far the planner looks: highway-env tells everything
_RANGE_MPS2, _RANGE_RAD = 5.0, math.pi / 4  # of its continuous action


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeSettings:
    """`highway-v0` as it is shipped, but for these. The ego starts behind everybody: of 50 cars it never meets the last."""

    duration_s: float = 40.0
    vehicles: int = 50
    frequency_hz: int = 20  # of its simulation; a whole number of frames in a cycle

    def __post_init__(self) -> None:
        require_types(self)
        require(self, positive, "duration_s", "vehicles")
        whole("frequency_hz", self.frequency_hz, least=1)
        if self.frequency_hz % round(1.0 / CYCLE_S):
            raise ParameterError("frequency_hz", self.frequency_hz, f"must be a multiple of {1.0 / CYCLE_S:g}", "Hz")


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """`collided`: the ego touched somebody or was touched. `ordinary`: time gaps and the like. `unverified_plans` as in a simulation; None
    of an agent that is not ours."""

    seed: int
    agent: str
    collided: bool
    on_road: bool
    duration_s: float
    mean_speed_mps: float
    lane_changes: int
    ordinary: OrdinaryDriving = field(default_factory=OrdinaryDriving)
    fallbacks: int | None = None
    unavoidable: int | None = None
    unverified_plans: int | None = None


def make_highway(settings: EpisodeSettings) -> Any:
    """The environment, steered by acceleration and steering angle. Raises `MissingExtraError` without gymnasium or highway-env."""
    try:
        import gymnasium
        import highway_env
    except ImportError as error:
        raise MissingExtraError("highway-env" if "highway" in str(error) else "gymnasium", "gym") from None
    gymnasium.register_envs(highway_env)
    config = {
        "action": {
            "type": "ContinuousAction",
            "acceleration_range": [-_RANGE_MPS2, _RANGE_MPS2],
            "steering_range": [-_RANGE_RAD, _RANGE_RAD],
        },
        "simulation_frequency": settings.frequency_hz,
        "policy_frequency": round(1.0 / CYCLE_S),
        "duration": settings.duration_s,
        "vehicles_count": settings.vehicles,
        "lanes_count": LANES,
    }
    return gymnasium.make("highway-v0", config=config)


class HighwayDriver:
    """The planner as an agent: true states of the cars around in, (acceleration, steering) out, as shares of the action's ranges."""

    def __init__(self, wanted_mps: float = WANTED_MPS, method: str = "mpc", settings: Settings | None = None) -> None:
        self.planner = Planner(highway_vehicle(acceleration_mps2=_RANGE_MPS2, steering_rad=_RANGE_RAD), method, settings=settings)
        self._wanted_mps = wanted_mps
        self._side: RoadSide | None = None
        self._lane = 0
        self._now_s = 0.0
        self._applied = (0.0, 0.0)  # acceleration and steering of the host at this moment, in our signs

    def reset(self) -> None:
        """A new episode begins."""
        self.planner.reset()
        self._side, self._now_s, self._applied = None, 0.0, (0.0, 0.0)

    def __call__(self, env: Any) -> NDArray[np.float32]:
        plan = self.planner.plan(self.situation(env))
        self._now_s += CYCLE_S
        driven = plan.trajectory
        middle, end = 0.5 * CYCLE_S, CYCLE_S
        acceleration, steering = (np.interp((middle, end), driven.t_s, c) for c in (driven.acceleration_mps2, driven.steering_rad))
        self._applied = (float(acceleration[1]), float(steering[1]))
        assert self._side is not None
        asked, turned = self._side.action(float(acceleration[0]), float(steering[0]))
        return np.asarray(np.clip([asked / _RANGE_MPS2, turned / _RANGE_RAD], -1.0, 1.0), dtype=np.float32)

    def situation(self, env: Any) -> Situation:
        """What the environment says, in our frame: s and d from where the ego began, the middle of its first lane."""
        world = env.unwrapped
        ego, lanes = world.vehicle, world.road.network.all_side_lanes(world.vehicle.lane_index)
        width = float(world.road.network.get_lane(lanes[0]).width)
        if self._side is None:
            self._lane = int(ego.lane_index[2])
            self._side = RoadSide(x_m=float(ego.position[0]), y_m=self._lane * width)
        side = self._side
        tracks = [
            side.track(str(k), x=float(c.position[0]), y=float(c.position[1]), heading=float(c.heading), speed=float(c.speed))
            for k, c in enumerate(world.road.vehicles)
            if c is not ego and -BEHIND_M < float(c.position[0] - ego.position[0]) < AHEAD_M
        ]
        acceleration, steering = self._applied
        host = side.host(
            x=float(ego.position[0]),
            y=float(ego.position[1]),
            heading=float(ego.heading),
            speed=float(ego.speed),
            acceleration=acceleration,
            steering=-steering,
        )
        road = road_of(len(lanes), self._lane, width, speed_limit_mps=max(self._wanted_mps, 30.0))
        return Situation(
            time_s=round(self._now_s, 9),
            host=host,
            coverage=Coverage(),
            tracks=tuple(tracks),
            road=road,
            vehicle=self.planner.vehicle.name,
            desired_speed_mps=self._wanted_mps,
        )


def idm_mobil(env: Any, wanted_mps: float) -> None:
    """Puts highway-env's own driver (IDM along, MOBIL across) into the ego's seat; whatever action it is given it drives itself."""
    from highway_env.vehicle.behavior import IDMVehicle

    world = env.unwrapped
    ego = world.vehicle
    driver = IDMVehicle(world.road, ego.position, ego.heading, ego.speed, target_speed=wanted_mps)
    world.road.vehicles[world.road.vehicles.index(ego)] = driver
    world.controlled_vehicles = [driver]


def _instant(world: Any, time_s: float, before: Instant | None) -> Instant:
    """The ego among the cars around; accelerations are not told, the ego's is what its speed has gained."""
    ego = world.vehicle
    acceleration = 0.0 if before is None else (float(ego.speed) - before.speed_mps) / (time_s - before.time_s)
    others = [_placed(str(k), car) for k, car in enumerate(world.road.vehicles) if car is not ego]
    return instant(time_s, replace(_placed("ego", ego), acceleration_mps2=acceleration), others)


def _placed(name: str, car: Any) -> Placed:
    x, y = (float(one) for one in car.position)
    return Placed(
        id=name,
        s_m=x,
        d_m=-y,
        speed_mps=float(car.speed),
        length_m=float(car.LENGTH),
        width_m=float(car.WIDTH),
        lane=-int(car.lane_index[2]),
    )


def episode(env: Any, seed: int, driver: HighwayDriver | None) -> Episode:
    """One seeded episode with our planner, or with the environment's own agent where `driver` is None."""
    env.reset(seed=seed)
    world, plans = env.unwrapped, []
    if driver is None:
        idm_mobil(env, WANTED_MPS)
    else:
        driver.reset()
    speeds, lanes, ended = [], [int(world.vehicle.lane_index[2])], False
    instants = [_instant(world, 0.0, None)]
    while not ended:
        action = np.zeros(2, dtype=np.float32) if driver is None else driver(env)
        _, _, crashed, over, _ = env.step(action)
        ended = crashed or over
        speeds.append(float(world.vehicle.speed))
        lanes.append(int(world.vehicle.lane_index[2]))
        instants.append(_instant(world, round(CYCLE_S * len(speeds), 9), instants[-1]))
        if driver is not None and driver.planner.previous is not None:
            plans.append(driver.planner.previous)
    statuses = [plan.status.value for plan in plans]
    unverified = sum(plan.status.value != "unavoidable" and not plan.verdict.passed for plan in plans)
    return Episode(
        seed=seed,
        agent="idm-mobil" if driver is None else driver.planner.name,
        collided=bool(world.vehicle.crashed),
        on_road=bool(world.vehicle.on_road),
        duration_s=CYCLE_S * len(speeds),
        mean_speed_mps=float(np.mean(speeds)),
        lane_changes=int(np.count_nonzero(np.diff(lanes))),
        ordinary=ordinary_driving(instants),
        fallbacks=None if driver is None else statuses.count("fallback"),
        unavoidable=None if driver is None else statuses.count("unavoidable"),
        unverified_plans=None if driver is None else unverified,
    )
