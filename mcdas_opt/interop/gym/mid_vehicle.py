"""`mcdas/MidVehicle-v0`: a scene of ours as a gymnasium environment; the agent drives the car in the middle.

The plant, the traffic and what ends a drive are the closed loop's (`simulation`). A step lasts 0.1 s.

**Action** (2,) in [-1, 1]: the acceleration asked for, as a share of the vehicle's limits (braking for negative), and the lateral
acceleration asked for, as a share of the road's grip, left positive; at low speed the steering angle's limit binds first. The actuators
take both there as fast as the vehicle's jerk and steering rate allow.

**Observation** (7 + 6 slots,), each entry divided by its `SCALES` and clipped to [-1, 1]: d [m], heading [rad], speed [m/s], acceleration
[m/s^2], steering [rad], distance from the body centre to the left and to the right edge [m]; then of the nearest neighbours
who have not left, nearest first: present (0 or 1), ahead [m], left [m], speed along and across the road relative to the host [m/s],
length [m]; zeros in empty slots.

**Reward** of a step: 0.1 (1 - |v - v wanted| / v wanted) - 0.01 (a / 3)^2 - 0.01 (lateral acceleration / 3)^2; a collision or a
departure from the road ends the episode with -10. At the scene's end the episode is truncated.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.rules import Array, non_negative
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.simulation.car import Car
from mcdas_opt.simulation.contact import EDGE_SLACK_M, surroundings
from mcdas_opt.simulation.idm import STEP_S, step_times
from mcdas_opt.simulation.neighbours import Traffic, host_motion
from mcdas_opt.simulation.plant import PlantFactory
from mcdas_opt.simulation.record import Outcome
from mcdas_opt.simulation.recorded import GONE_M

CYCLE_S = 0.1
SLOTS = 4
_HOST_SCALES = (20.0, 0.5, 50.0, 10.0, 0.6, 20.0, 20.0)
_SLOT_SCALES = (1.0, 150.0, 20.0, 40.0, 10.0, 20.0)
SCALES = np.array(_HOST_SCALES + _SLOT_SCALES * SLOTS)
_ENDED_REWARD = -10.0
_DRAWS = 50  # of a first situation, until one is sound

Observation = NDArray[np.float32]


class MidVehicle(gymnasium.Env[Observation, NDArray[np.float32]]):
    """`scene` is a path, a shipped name or a `Scene`. With `spread` > 0 every reset moves the neighbours along the road and changes their
    speeds by up to `spread` times 5 m and 1.5 m/s (recorded ones are left alone); 0 is the scene itself. `plant` as in `simulate`.

    Raises `InputError` for a scene, `ParameterError` for a plant or a spread that is none.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self,
        scene: str | Scene = "sandwich-60-40",
        *,
        spread: float = 1.0,
        plant: str | PlantFactory = "kinematic",
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            raise ParameterError("render_mode", render_mode, "must be None: draw drives with `mcdas-opt simulate --out`")
        self._scene = load_scene(scene) if isinstance(scene, str) else scene
        self._spread, self._plant = non_negative("spread", spread), plant
        self.render_mode = None
        Car(plant, self._scene.vehicle, self._scene.true_road, self._scene.host_state)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, shape=(2,), dtype=np.float32)
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, shape=(SCALES.size,), dtype=np.float32)
        self._drawn = self._scene
        self._traffic, self._car = self._begin()
        self._outcome, self._steps = Outcome.SAFE, 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._drawn = self._draw()
        self._traffic, self._car = self._begin()
        self._outcome, self._steps = Outcome.SAFE, 0
        return self._observation(), self._info()

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        asked = np.asarray(action, dtype=np.float64)
        if asked.shape != (2,) or not np.all(np.isfinite(asked)):
            raise ParameterError("action", action, "must be two finite numbers")
        if self._outcome is not Outcome.SAFE:
            raise ParameterError("step", self._outcome.value, "the episode has ended: call reset")
        states, lateral = self._roll(np.clip(asked, -1.0, 1.0))
        self._check(states)
        self._steps += 1
        ended = self._outcome is not Outcome.SAFE
        truncated = not ended and self._steps * CYCLE_S >= self._drawn.duration_s - 1e-9
        return self._observation(), self._reward(lateral), ended, truncated, self._info()

    @property
    def host(self) -> HostState:
        """The plant's true state."""
        return self._car.state

    @property
    def scene(self) -> Scene:
        """The scene that is being driven, as drawn at the last reset."""
        return self._drawn

    def _begin(self) -> tuple[Traffic, Car]:
        drawn = self._drawn
        return Traffic(drawn), Car(self._plant, drawn.vehicle, drawn.true_road, drawn.host_state)

    def _draw(self) -> Scene:
        """The scene with its neighbours moved; the scene itself where no draw is sound (bodies overlap, somebody would reverse)."""
        scene = self._scene
        if self._spread == 0.0:
            return scene
        for _ in range(_DRAWS):
            moves = self.np_random.uniform(-1.0, 1.0, size=(len(scene.neighbour), 2)) * self._spread * np.array([5.0, 1.5])
            document = scene.model_dump(exclude_unset=True)
            for part, given, (ahead, faster) in zip(document.get("neighbour", []), scene.neighbour, moves.tolist(), strict=True):
                if given.s_m is not None and given.speed_mps is not None:
                    part["s_m"], part["speed_mps"] = given.s_m + ahead, max(given.speed_mps + faster, 0.0)
            try:
                return Scene.model_validate(document)
            except (ValidationError, InputError):
                continue
        return scene

    def _roll(self, asked: Array) -> tuple[Array, float]:
        """The plant and the traffic through one cycle: the host's states (n + 1, 6) and its largest lateral acceleration."""
        vehicle, road = self._drawn.vehicle, self._traffic.road
        first = self._car.state
        limit = vehicle.acceleration_max_mps2 if asked[0] > 0.0 else -vehicle.acceleration_min_mps2
        acceleration = float(asked[0]) * limit
        bend = float(asked[1]) * road.friction * GRAVITY_MPS2 / max(first.speed_mps, 1.0) ** 2
        steering = min(max(math.atan(vehicle.wheelbase_m * bend), -vehicle.steering_max_rad), vehicle.steering_max_rad)
        steps = round(CYCLE_S / STEP_S)
        states, lateral = [first.to_vector()], 0.0
        for _ in range(steps):
            state = self._car.state
            applied = self._car.step(
                (acceleration - state.acceleration_mps2) / STEP_S,
                (steering - state.steering_rad) / STEP_S,
            )
            states.append(self._car.state.to_vector())
            lateral = max(lateral, abs(applied.lateral_acceleration_mps2))
        host = np.array(states)
        self._traffic.advance(host_motion(host[:-1], self._traffic.road))
        return host, lateral

    def _check(self, host: Array) -> None:
        times = step_times(self._steps * (len(host) - 1), len(host))
        others = self._traffic.motions(times)
        around = surroundings(host, others, self._traffic.sizes, self._drawn.vehicle, self._traffic.road)
        if around.touching.any():
            self._outcome = Outcome.COLLISION
        elif np.any(around.beyond_edge_m > EDGE_SLACK_M):
            self._outcome = Outcome.LEFT_ROAD

    def _observation(self) -> Observation:
        host, road = self._car.state, self._traffic.road
        own = [host.d_m, host.heading_rad, host.speed_mps, host.acceleration_mps2, host.steering_rad]
        own += [road.left_edge_m - host.d_m, host.d_m - road.right_edge_m]
        along, across = host.speed_mps * math.cos(host.heading_rad), host.speed_mps * math.sin(host.heading_rad)
        moments = self._traffic.motions(np.array(self._steps * CYCLE_S))
        slots: list[tuple[float, ...]] = [
            (1.0, float(m.s_m) - host.s_m, float(m.d_m) - host.d_m, float(m.speed_s_mps) - along, float(m.speed_d_mps) - across, length)
            for m, (length, _) in zip(moments, self._traffic.sizes, strict=True)
            if m.d_m < GONE_M
        ]
        slots = sorted(slots, key=lambda slot: math.hypot(slot[1], slot[2]))[:SLOTS]
        slots += [(0.0,) * len(_SLOT_SCALES)] * (SLOTS - len(slots))
        values = np.array(own + [entry for slot in slots for entry in slot]) / SCALES
        return np.asarray(np.clip(values, -1.0, 1.0), dtype=np.float32)

    def _reward(self, lateral: float) -> float:
        if self._outcome is not Outcome.SAFE:
            return _ENDED_REWARD
        host, wanted = self._car.state, max(self._drawn.desired_speed_mps, 1.0)
        pace = 1.0 - abs(host.speed_mps - wanted) / wanted
        return 0.1 * pace - 0.01 * (host.acceleration_mps2 / 3.0) ** 2 - 0.01 * (lateral / 3.0) ** 2

    def _info(self) -> dict[str, Any]:
        return {"outcome": self._outcome.value, "t_s": self._steps * CYCLE_S}
