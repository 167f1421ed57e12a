"""The equations of parking, one small function each: an interval of driving, and a collision check in its two forms.

Half-planes (Boyd and Vandenberghe 2004, section 8.2): a line with the car on one side and the obstacle on the other; its angle and offset
are unknown. Duals (Zhang, Liniger and Borrelli, IEEE TCST 2021, eq 11): multipliers of the obstacle's and the body's faces whose
certificate is the distance. In both forms one more unknown is the clearance beyond the asked one, which the clearance cost pays for.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.cost import WANTED_M
from mcdas_opt.parking.program.block_derivatives import Block, block
from mcdas_opt.parking.program.records import CORNERS, Checks
from mcdas_opt.solvers.held_interrupts import held_interrupts

STATE = 5
COMMON = 7 + 5  # wheelbase, body, acceleration, steering rate, clearance, weights
EXTRA = {"half-planes": 3, "duals": 2 * CORNERS + 1}  # unknowns of a check
INTERVAL_LOW = np.array([0.0] * 3 + [-np.inf] * 4)
_LINE_TURN_RAD = 1.2  # how far a separating line may turn in one solution
_CHECK_S = 0.1  # of driving that a check stands for in the clearance cost


def _advance(z: Any, after: Any, h: Any, fraction: Any, wheelbase: Any) -> list[Any]:
    """Pose after a fraction of an interval, by the classical Runge-Kutta step of the bicycle.

    Written with differences of speed and steering instead of rates, so that an interval may shrink to nothing.
    """
    step = fraction * h
    v = [z[3] + share * fraction * (after[3] - z[3]) for share in (0.0, 0.5, 1.0)]
    turn = [v[i] * ca.tan(z[4] + share * fraction * (after[4] - z[4])) / wheelbase for i, share in enumerate((0.0, 0.5, 1.0))]
    heading = [z[2], z[2] + 0.5 * step * turn[0], z[2] + 0.5 * step * turn[1], z[2] + step * turn[1]]
    along = [v[0], 2.0 * v[1], 2.0 * v[1], v[2]]
    x = z[0] + step / 6.0 * sum(w * ca.cos(psi) for w, psi in zip(along, heading, strict=True))
    y = z[1] + step / 6.0 * sum(w * ca.sin(psi) for w, psi in zip(along, heading, strict=True))
    return [x, y, z[2] + step / 6.0 * (turn[0] + 4.0 * turn[1] + turn[2])]


@lru_cache(maxsize=1)
@held_interrupts()
def interval() -> Block:
    """(z_k, z_k+1, h) -> equations of motion, limits of acceleration and steering rate, cost of one interval."""
    w, common = ca.SX.sym("w", 2 * STATE + 1), ca.SX.sym("common", COMMON)
    z, after, h = w[:STATE], w[STATE : 2 * STATE], w[2 * STATE]
    wheelbase, acceleration, rate = common[0], common[4], common[5]
    dv, dd = after[3] - z[3], after[4] - z[4]
    rows = [after[i] - p for i, p in enumerate(_advance(z, after, h, 1.0, wheelbase))]
    rows += [dv - acceleration * h, -dv - acceleration * h, dd - rate * h, -dd - rate * h]
    time, path, steering, smooth = (common[7 + i] for i in range(4))
    v, delta = 0.5 * (z[3] + after[3]), 0.5 * (z[4] + after[4])
    cost = time * h + path * h * v**2 / (ca.fabs(v) + 0.05) + steering * h * delta**2 + smooth * dd**2
    return block("interval", w, ca.SX.sym("q", 0), common, ca.vertcat(*rows), cost)


def _half_planes(pose: list[Any], own: Any, data: Any, common: Any) -> list[Any]:
    """Body corners beyond the line by the clearance, obstacle vertices on its other side: all at least 0."""
    _, rear, front, half, _, _, clearance = (common[i] for i in range(7))
    angle, offset, extra = own[0], own[1], own[2]
    nx, ny = ca.cos(angle), ca.sin(angle)
    ahead, left = ca.cos(angle - pose[2]), ca.sin(angle - pose[2])
    centre = nx * pose[0] + ny * pose[1] - offset - clearance - extra
    rows = [centre + ahead * px + left * py for px in (front, rear) for py in (half, -half)]
    rows += [offset - nx * data[2 * j] - ny * data[2 * j + 1] for j in range(CORNERS)]
    return rows


def _duals(pose: list[Any], own: Any, data: Any, common: Any) -> list[Any]:
    """Distance certified, the certificate's length at most 1, and (two equations) both bodies' multipliers in balance."""
    _, rear, front, half, _, _, clearance = (common[i] for i in range(7))
    lam, mu, extra = own[:CORNERS], own[CORNERS : 2 * CORNERS], own[2 * CORNERS]
    faces = ca.reshape(data, 3, CORNERS)  # normal and offset of each face
    nx, ny = ca.dot(faces[0, :].T, lam), ca.dot(faces[1, :].T, lam)
    c, s = ca.cos(pose[2]), ca.sin(pose[2])
    ahead, left = c * nx + s * ny, c * ny - s * nx
    reach = front * mu[0] - rear * mu[1] + half * mu[2] + half * mu[3]
    gap = nx * pose[0] + ny * pose[1] - ca.dot(faces[2, :].T, lam) - reach
    return [gap - clearance - extra, 1.0 - nx**2 - ny**2, mu[0] - mu[1] + ahead, mu[2] - mu[3] + left]


@lru_cache(maxsize=4)
@held_interrupts()
def check(form: str, inside: bool) -> Block:
    """A collision check at a node, or at a fraction inside an interval."""
    extra, numbers = EXTRA[form], (2 if form == "half-planes" else 3) * CORNERS
    common = ca.SX.sym("common", COMMON)
    driven = 2 * STATE + 1 if inside else 3
    w, q = ca.SX.sym("w", driven + extra), ca.SX.sym("q", numbers + int(inside))
    pose = [w[0], w[1], w[2]]
    if inside:
        pose = _advance(w[:STATE], w[STATE : 2 * STATE], w[2 * STATE], q[numbers], common[0])
    rows = (_half_planes if form == "half-planes" else _duals)(pose, w[driven:], q[:numbers], common)
    short = 1.0 - w[driven + extra - 1] / WANTED_M
    return block(f"{'inner' if inside else 'node'}_check", w, q, common, ca.vertcat(*rows), common[11] * _CHECK_S * short**2)


def check_rows(form: str) -> tuple[Array, Array]:
    """(least, most) of a check's rows."""
    if form == "half-planes":
        return np.zeros(2 * CORNERS), np.full(2 * CORNERS, np.inf)
    return np.zeros(4), np.array([np.inf, np.inf, 0.0, 0.0])


def check_unknowns(form: str, checks: Checks, headings: Array, clearance_cost: bool) -> tuple[Array, Array, Array, Array]:
    """(guess, least, most, numbers), a row a check, from its line and vertices; `headings` (m,) of the body at each check."""
    m = len(checks.angles)
    extra = np.zeros((m, 1)), np.full((m, 1), WANTED_M if clearance_cost else 0.0)
    if form == "half-planes":
        lines = np.column_stack([checks.angles, checks.offsets])
        room = np.array([_LINE_TURN_RAD, np.inf])
        return (
            np.hstack([lines, extra[0]]),
            np.hstack([lines - room, extra[0]]),
            np.hstack([lines + room, extra[1]]),
            _flat(checks.vertices),
        )
    faces = _faces(checks.vertices)
    lam = _combined(faces[..., :2], np.column_stack([np.cos(checks.angles), np.sin(checks.angles)]))
    ahead, left = -np.cos(checks.angles - headings), -np.sin(checks.angles - headings)
    mu = np.maximum(np.column_stack([ahead, -ahead, left, -left]), 0.0)
    guess = np.hstack([lam, mu, extra[0]])
    return guess, np.zeros_like(guess), np.hstack([np.full((m, 2 * CORNERS), np.inf), extra[1]]), _flat(faces)


def _flat(values: Array) -> Array:
    return values.reshape(len(values), int(np.prod(values.shape[1:])))


def _faces(vertices: Array) -> Array:
    """(m, 4, 3): outward normal and offset of each face; a repeated vertex gives a face of zeros, whose multiplier then does nothing."""
    about = vertices - vertices.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(about[..., 1], about[..., 0]), axis=1, kind="stable")
    ring = np.take_along_axis(vertices, order[..., None], axis=1)
    edge = np.roll(ring, -1, axis=1) - ring
    size = np.linalg.norm(edge, axis=-1, keepdims=True)
    normal = np.where(size > 1e-6, np.concatenate([edge[..., 1:], -edge[..., :1]], axis=-1) / np.maximum(size, 1e-6), 0.0)
    return np.concatenate([normal, (normal * ring).sum(-1, keepdims=True)], axis=-1)


def _combined(normals: Array, wanted: Array) -> Array:
    """(m, 4) multipliers of faces whose normals combine to `wanted`: the two normals on either side of it."""
    out = np.zeros(normals.shape[:2])
    for i in range(CORNERS):
        for j in range(i + 1, CORNERS):
            a, b = normals[:, i], normals[:, j]
            det = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
            safe = np.where(np.abs(det) > 1e-9, det, np.inf)
            la = (wanted[:, 0] * b[:, 1] - wanted[:, 1] * b[:, 0]) / safe
            lb = (a[:, 0] * wanted[:, 1] - a[:, 1] * wanted[:, 0]) / safe
            good = (la >= -1e-9) & (lb >= -1e-9) & np.isfinite(safe) & ~out.any(axis=1)
            out[good, i], out[good, j] = np.maximum(la[good], 0.0), np.maximum(lb[good], 0.0)
    return out
