"""The Monte Carlo study behind Figures 7-9: the paper's scenario through its own 8-state filter.

The paper gives no Q, R, P0 and no number of runs, so they are choices of ours, stated with every result: R so that 95 % of the first
estimates of y lie within the 0.2 m of its text.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array, positive, require_every
from mcdas_opt.evaluation import published
from mcdas_opt.plotting.tracking_bands import TrackingBands
from mcdas_opt.tracking.paired_filter import PairedFilter, paired_process_noise

KMH = 1.0 / 3.6


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingChoices:
    """What the paper leaves open."""

    runs: int = 300
    gap_m: float = 110.0 / 3.0  # from the rear vehicle to the host and from the host to the front vehicle, as points
    position_sd_m: tuple[float, float] = (0.25, 0.1)  # R and the positions of P0: along, across
    speed_sd_mps: tuple[float, float] = (0.5, 0.2)  # P0: along, across
    acceleration_sd_mps2: tuple[float, float] = (0.1, 0.05)  # Q: white-noise acceleration along, across

    def __post_init__(self) -> None:
        require_types(self)
        require_every(self, positive)

    def in_words(self) -> str:
        (rx, ry), (px, py), (qx, qy) = self.position_sd_m, self.speed_sd_mps, self.acceleration_sd_mps2
        return (
            f"our choice: R and P0 of positions ({rx:g}, {ry:g}) m, P0 of speeds ({px:g}, {py:g}) m/s, "
            f"Q of ({qx:g}, {qy:g}) m/s^2, {self.runs} runs"
        )


TRACKING = TrackingChoices()


def crash_position(gap_m: float, rear_mps: float, host_mps: float) -> float:
    """Where the rear vehicle meets the host, from the rear vehicle's start [m], both as points at constant speed."""
    return rear_mps * gap_m / (rear_mps - host_mps)


def study(seed: int, choices: TrackingChoices = TRACKING) -> TrackingBands:
    """Errors of the filter's estimates at t = 0 (the initial state) and at the 11 samples, and the crash positions they predict."""
    generator = np.random.default_rng(seed)
    rear, front, host = (kmh * KMH for kmh in (published.REAR_KMH, published.FRONT_KMH, published.HOST_KMH))
    step, samples = published.SAMPLE_S, published.SAMPLES
    t = step * np.arange(samples + 1, dtype=np.float64)
    truth = np.zeros((samples + 1, 8))
    truth[:, 0], truth[:, 1] = rear * t, rear
    truth[:, 4], truth[:, 5] = 2.0 * choices.gap_m + front * t, front
    position, speed = np.array(choices.position_sd_m * 2), np.array(choices.speed_sd_mps * 2)
    p0 = np.column_stack([position**2, speed**2]).ravel()
    q = paired_process_noise(step, *choices.acceleration_sd_mps2)
    error = np.empty((choices.runs, samples + 1, 8))
    for run in range(choices.runs):
        start = truth[0] + generator.normal(0.0, np.sqrt(p0))
        kalman = PairedFilter(
            state=start, state_covariance=np.diag(p0), step_s=step, process_covariance=q, measurement_covariance=np.diag(position**2)
        )
        measured = truth[1:, ::2] + generator.normal(0.0, position, (samples, 4))
        error[run] = np.vstack([start, kalman.run(measured)]) - truth
    return TrackingBands(
        t_s=t,
        rear_x_m=truth[:, 0],
        front_x_m=truth[:, 4],
        host_x_m=choices.gap_m + host * t,
        rear_error_x=error[:, :, 0],
        rear_error_y=error[:, :, 2],
        front_error_x=error[:, :, 4],
        front_error_y=error[:, :, 6],
        crash_m=_predicted_crashes(truth[:, 0:2] + error[:, :, 0:2], choices.gap_m + host * t, host),
        true_crash_m=crash_position(choices.gap_m, rear, host),
        zone_m=published.CRASH_ZONE_M,
        chosen=choices.in_words(),
    )


def _predicted_crashes(rear: Array, host_x: Array, host_speed: float) -> Array:
    """(runs, samples): where the rear vehicle as estimated then, (x, vx), will meet the host that keeps its speed."""
    x, v = rear[..., 0], rear[..., 1]
    closing = np.maximum(v - host_speed, 0.1)
    return np.asarray(x + v * (host_x - x) / closing)
