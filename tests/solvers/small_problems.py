"""Problems small enough to know their answer."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem

INF = np.inf


def problem(
    *,
    nx: int,
    nu: int,
    dynamics: Any,
    residual: Any,
    terminal: Any,
    rows: Any = None,
    slack_of: tuple[int, ...] = (),
    slack_linear: tuple[float, ...] = (),
    slack_quadratic: tuple[float, ...] = (),
    x_bound: tuple[float, float] = (-INF, INF),
    u_bound: tuple[float, float] = (-INF, INF),
    parameters: tuple[str, ...] = ("target",),
) -> StageProblem:
    """From functions of (x, u, p, h), (x, u, p), (x, p), (x, u, p); every x and u has the same bound."""
    x, u, p, h = ca.SX.sym("x", nx), ca.SX.sym("u", nu), ca.SX.sym("p", len(parameters)), ca.SX.sym("h")
    ns = len(slack_linear)
    return StageProblem(
        name="small",
        dynamics=ca.Function("dynamics", [x, u, p, h], [dynamics(x, u, p, h)]),
        residual=ca.Function("residual", [x, u, p], [residual(x, u, p)]),
        terminal_residual=ca.Function("terminal_residual", [x, p], [terminal(x, p)]),
        inequality=ca.Function("inequality", [x, u, p], [ca.SX(0, 1) if rows is None else rows(x, u, p)]),
        slack_of=slack_of,
        slack_linear=np.array(slack_linear),
        slack_quadratic=np.array(slack_quadratic),
        x_lower=np.full(nx, x_bound[0]),
        x_upper=np.full(nx, x_bound[1]),
        u_lower=np.full(nu, u_bound[0]),
        u_upper=np.full(nu, u_bound[1]),
        x_scale=np.ones(nx),
        u_scale=np.ones(nu),
        s_scale=np.ones(ns),
        states=tuple(f"x{i}" for i in range(nx)),
        inputs=tuple(f"u{i}" for i in range(nu)),
        parameters=parameters,
        rows=tuple(f"row{i}" for i in range(len(slack_of))),
        slacks=tuple(f"s{i}" for i in range(ns)),
    )


def one_step(weight: float, u_bound: tuple[float, float]) -> StageProblem:
    """x+ = x + u, minimise u^2 / 2 + weight (x_N - target)^2 / 2: over one step u = clip(weight (target - x0) / (1 + weight))."""
    return problem(
        nx=1,
        nu=1,
        dynamics=lambda x, u, p, h: x + u,
        residual=lambda x, u, p: u,
        terminal=lambda x, p: np.sqrt(weight) * (x - p[0]),
        u_bound=u_bound,
    )


def wall(price: float, *, at: float) -> StageProblem:
    """The same with a soft wall x <= at: beyond it the price is paid, and nothing else."""
    return problem(
        nx=1,
        nu=1,
        dynamics=lambda x, u, p, h: x + u,
        residual=lambda x, u, p: u,
        terminal=lambda x, p: x - p[0],
        rows=lambda x, u, p: x - at,
        slack_of=(0,),
        slack_linear=(price,),
        slack_quadratic=(0.0,),
    )


def double_integrator(*, x_bound: tuple[float, float] = (-INF, INF), u_bound: tuple[float, float] = (-INF, INF)) -> StageProblem:
    """(position, speed) driven by an acceleration towards (target, 0)."""
    return problem(
        nx=2,
        nu=1,
        dynamics=lambda x, u, p, h: ca.vertcat(x[0] + h * x[1] + 0.5 * h**2 * u[0], x[1] + h * u[0]),
        residual=lambda x, u, p: ca.vertcat(x[0] - p[0], 0.3 * x[1], 0.2 * u[0]),
        terminal=lambda x, p: ca.vertcat(3.0 * (x[0] - p[0]), x[1]),
        x_bound=x_bound,
        u_bound=u_bound,
    )


def chain(rng: np.random.Generator, nx: int, nu: int) -> tuple[StageProblem, dict[str, np.ndarray]]:
    """A random linear-quadratic problem, and its matrices."""
    a = np.eye(nx) + 0.3 * rng.standard_normal((nx, nx)) / np.sqrt(nx)
    b, q, w = rng.standard_normal((nx, nu)), rng.standard_normal((nx, nx)), 3.0 * np.eye(nx)
    linear = problem(
        nx=nx,
        nu=nu,
        dynamics=lambda x, u, p, h: ca.mtimes(ca.DM(a), x) + ca.mtimes(ca.DM(b), u),
        residual=lambda x, u, p: ca.vertcat(ca.mtimes(ca.DM(q), x - p[0]), u),
        terminal=lambda x, p: ca.mtimes(ca.DM(w), x - p[0]),
    )
    return linear, {"a": a, "b": b, "q": q, "w": w}


def idle_guess(small: StageProblem, nodes: int, x0: Any = 0.0) -> StageGuess:
    return StageGuess(
        x=np.tile(np.broadcast_to(np.asarray(x0, dtype=np.float64), (small.nx,)), (nodes + 1, 1)),
        u=np.zeros((nodes, small.nu)),
        s=np.zeros((nodes + 1, small.ns)),
    )


def parameters(small: StageProblem, nodes: int, value: float) -> np.ndarray:
    return np.full((nodes + 1, len(small.parameters)), value)
