"""The backward and forward sweep of a linear-quadratic problem, one stage at a time, in symbols.

Minimise sum 1/2 dz'G dz + gamma'dz subject to dx+ = [A B] dz + b. Source: Rawlings, Mayne, Diehl, Model Predictive Control, 2nd ed.
2017, section 8.8 (Riccati recursion).
"""

from __future__ import annotations

from typing import Any

import casadi as ca


def symmetric(lower: Any) -> Any:
    """The full matrix of a lower triangle."""
    return lower + ca.tril(lower, False).T


def inverse_positive(m: Any) -> Any:
    """Inverse of a small symmetric positive definite matrix, by LDL' without a square root."""
    n = m.size1()
    if n == 1:
        return 1.0 / m
    lower, pivots = ca.SX.eye(n), []
    rest = m
    for i in range(n):
        pivots.append(rest[i, i])
        column = rest[:, i] / rest[i, i]
        for k in range(i + 1, n):
            lower[k, i] = column[k]
        rest = rest - ca.mtimes(column, rest[i, :])
    back = ca.SX.eye(n)  # inverse of the unit lower triangle
    for i in range(n):
        for k in range(i):
            back[i, k] = -sum((lower[i, j] * back[j, k] for j in range(k, i)), ca.SX(0.0))
    return ca.mtimes(back.T, ca.mtimes(ca.diag(1.0 / ca.vertcat(*pivots)), back))


class Factor:
    """What one backward step leaves: feedback K, cross term S = M_ux, inverse input Hessian R, and P b."""

    def __init__(self, value: Any, ab: Any, b: Any, hessian: Any) -> None:
        """`value` P (nx, nx) of the node after, `ab` [A B], gap `b`, condensed Hessian (nz, nz)."""
        nx = value.size1()
        self.nx, self.ab = nx, ab
        m = hessian + ca.mtimes(ab.T, ca.mtimes(value, ab))
        self.s, self.r = m[nx:, :nx], inverse_positive(m[nx:, nx:])
        self.k = -ca.mtimes(self.r, self.s)
        self.pb = ca.mtimes(value, b)
        self.value = ca.tril(m[:nx, :nx] + ca.mtimes(self.s.T, self.k))


def backward_gradient(nx: int, ab: Any, s: Any, r: Any, pb: Any, after: Any, gradient: Any) -> tuple[Any, Any]:
    """(p of this node, constant input step kf) from p `after` of the node after and this stage's condensed gradient."""
    v = gradient + ca.mtimes(ab.T, pb + after)
    kf = -ca.mtimes(r, v[nx:])
    return v[:nx] + ca.mtimes(s.T, kf), kf


def forward(ab: Any, b: Any, k: Any, kf: Any, dx: Any) -> tuple[Any, Any]:
    """(dx of the node after, du of this one)."""
    du = ca.mtimes(k, dx) + kf
    return ca.mtimes(ab, ca.vertcat(dx, du)) + b, du
