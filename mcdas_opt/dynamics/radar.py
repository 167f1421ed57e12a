"""What a radar measures: the paper's eq 1-9, literally and corrected.

Scalars or arrays; `m` is the number system (numpy, math). ISO 8855 except where a function is called `literal`: there y and angles
are positive to the right, as the paper has them.
"""

from __future__ import annotations

from typing import Any

LIGHT_MPS = 299_792_458.0


def range_from_delay(delay: Any, wave_speed: float = LIGHT_MPS) -> Any:
    """R = c tau / 2 [m] (eq 1)."""
    return 0.5 * wave_speed * delay


def doppler_shift(received: Any, transmitted: Any) -> Any:
    """f_D = f_r - f_t [Hz] (eq 6): positive when the target comes nearer."""
    return received - transmitted


def closing_speed(shift: Any, carrier: Any, wave_speed: float = LIGHT_MPS) -> Any:
    """V_R = c f_D / (2 f_c) [m/s] (eq 5): positive when closing, so the range rate is its negative."""
    return 0.5 * wave_speed * shift / carrier


def position_literal(distance: Any, angle: Any, m: Any) -> tuple[Any, Any]:
    """(x, y) = R (cos theta, sin theta) (eq 2-3): y and theta positive to the right, in the sensor's own frame."""
    return distance * m.cos(angle), distance * m.sin(angle)


def distance_literal(x: Any, y: Any, sensor_x: Any, sensor_y: Any, m: Any) -> Any:
    """Euclidean distance of target and sensor (eq 4)."""
    return m.sqrt((x - sensor_x) ** 2 + (y - sensor_y) ** 2)


def target_speed_literal(host: Any, closing: Any) -> Any:
    """V_T = V_H + V_R (eq 7). With eq 5's sign right behind the host, reversed ahead of it; and a radial speed is called a total one."""
    return host + closing


def velocity_literal(speed: Any, angle: Any, m: Any) -> tuple[Any, Any]:
    """(v_x, v_y) = V_T (sin theta, cos theta) (eq 8-9): the angle now counts from y, though eq 2-3 count it from x."""
    return speed * m.sin(angle), speed * m.cos(angle)


def position(distance: Any, azimuth: Any, x: Any, y: Any, yaw: Any, m: Any) -> tuple[Any, Any]:
    """Eq 2-3 corrected: the point seen at (distance, azimuth) by a sensor at (x, y, yaw), in the frame of that pose."""
    return x + distance * m.cos(yaw + azimuth), y + distance * m.sin(yaw + azimuth)


def target_speed(host: Any, closing: Any, bearing: Any, direction: Any, m: Any) -> Any:
    """Eq 7 corrected: speed [m/s] over ground of a target that moves in `direction`, seen at `bearing` by a host moving along x.

    The range rate -closing is the component of the relative velocity on the line of sight u = (cos, sin) bearing, so that
    V_T = (V_H cos bearing - closing) / cos(bearing - direction). Straight ahead it is V_H - V_R, straight behind V_H + V_R.
    Useless where the target moves across the line of sight (the denominator vanishes): there a radar does not see its speed.
    """
    return (host * m.cos(bearing) - closing) / m.cos(bearing - direction)


def velocity(speed: Any, direction: Any, m: Any) -> tuple[Any, Any]:
    """Eq 8-9 corrected: (v_x, v_y); the angle is the direction of motion, from x, and not the bearing."""
    return speed * m.cos(direction), speed * m.sin(direction)


def position_covariance(distance: Any, bearing: Any, distance_sd: Any, bearing_sd: Any, m: Any) -> tuple[Any, Any, Any]:
    """(xx, xy, yy) [m^2] of eq 2-3 by their Jacobian.

    First order: the converted mean is then too near by R sd^2 / 2, which matters once R sd_bearing^2 / sd_distance > 0.4 (Lerro and
    Bar-Shalom, IEEE Trans. AES 29, 1993). For the ESR at 174 m, 0.5 degrees and 0.25 m this is 0.05 (7 mm), so nothing is debiased.
    """
    c, s = m.cos(bearing), m.sin(bearing)
    along, across = distance_sd**2, (distance * bearing_sd) ** 2
    return c * c * along + s * s * across, c * s * (along - across), s * s * along + c * c * across


def sensor_velocity(speed: Any, yaw_rate: Any, yaw: Any, ahead: Any, left: Any, m: Any) -> tuple[Any, Any]:
    """Velocity in the plane of a point of the host `ahead` and `left` [m] of its rear axle, which moves at `speed` along `yaw`."""
    c, s = m.cos(yaw), m.sin(yaw)
    forward, leftward = speed - yaw_rate * left, yaw_rate * ahead
    return forward * c - leftward * s, forward * s + leftward * c
