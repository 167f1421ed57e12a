"""Nonlinear programs made of many copies of a few small functions: derivatives are taken once a function and scattered.

CasADi's own derivatives of such a program colour the whole of it: one Hessian cost 3 ms there, and costs 0.3 ms here (72 intervals, 140
collision checks). What is left of an iteration is the linear solver.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from mcdas_opt.parking.program.records import Rows


class Block(NamedTuple):
    """A function of few variables. `value` is (w, q, common) -> (rows, cost).

    `slope` gives the nonzeros of the rows' Jacobian, `tilt` the cost and its gradient, and `bend` (w, q, common, row multipliers, cost
    multiplier) the nonzeros of the Hessian's upper triangle.
    """

    name: str
    variables: int
    numbers: int
    rows: int
    value: Any
    slope: Any
    tilt: Any
    bend: Any
    slope_at: tuple[Rows, Rows]  # row and column of each nonzero
    bend_at: tuple[Rows, Rows]


class Copies(NamedTuple):
    """Copies of one block: (count, variables) indices into the program's variables."""

    block: Block
    where: Rows


def block(name: str, w: Any, q: Any, common: Any, rows: Any, cost: Any) -> Block:
    """A block from its symbols (SX) and expressions."""
    multipliers, weight = ca.SX.sym("multipliers", rows.numel()), ca.SX.sym("weight")
    slope = ca.jacobian(rows, w)
    bend = ca.triu(ca.hessian(weight * cost + ca.dot(multipliers, rows), w)[0])
    return Block(
        name,
        w.numel(),
        q.numel(),
        rows.numel(),
        ca.Function(name, [w, q, common], [rows, cost]),
        ca.Function(f"{name}_slope", [w, q, common], [_nonzeros(slope)]),
        ca.Function(f"{name}_tilt", [w, q, common], [cost, ca.densify(ca.gradient(cost, w))]),
        ca.Function(f"{name}_bend", [w, q, common, multipliers, weight], [_nonzeros(bend)]),
        _places(slope),
        _places(bend),
    )


def _nonzeros(expression: Any) -> Any:
    return ca.vertcat(*expression.nonzeros()) if expression.nnz() else ca.SX.zeros(0, 1)


def _places(expression: Any) -> tuple[Rows, Rows]:
    row, column = expression.sparsity().get_triplet()
    return np.array(row, dtype=np.int64), np.array(column, dtype=np.int64)


def nlp_of(copies: Sequence[Copies], variables: int, common: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """(the program, its derivatives) for `casadi.nlpsol`: parameters are each family's numbers, one copy after another, then `common`."""
    copies = [c for c in copies if len(c.where)]
    sizes = [c.block.numbers * len(c.where) for c in copies]
    x, p = ca.MX.sym("x", variables), ca.MX.sym("p", sum(sizes) + common)
    shared = p[sum(sizes) :]
    inputs, first = [], 0
    for c, size in zip(copies, sizes, strict=True):
        n = len(c.where)
        w = ca.reshape(x[c.where.ravel().tolist()], c.block.variables, n)
        inputs.append((n, w, ca.reshape(p[first : first + size], c.block.numbers, n), ca.repmat(shared, 1, n)))
        first += size
    rows, cost, tilted = [], 0, 0
    slopes, gradients = [], []
    for c, (n, *arguments) in zip(copies, inputs, strict=True):
        row, part = c.block.value.map(n)(*arguments)
        rows.append(ca.vec(row))
        cost += ca.sum2(part)
        slopes.append(ca.vec(c.block.slope.map(n)(*arguments)))
        part, gradient = c.block.tilt.map(n)(*arguments)
        tilted += ca.sum2(part)
        gradients.append(ca.vec(gradient))
    g = ca.vertcat(*rows)
    entries = _scatter(np.concatenate([c.where.ravel() for c in copies]), variables)
    gradient = ca.mtimes(entries, ca.vertcat(*gradients))
    jacobian = _jacobian(copies, ca.vertcat(*slopes), int(g.numel()), variables)
    weight, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", g.numel())
    bends, first = [], 0
    for c, (n, *arguments) in zip(copies, inputs, strict=True):
        size = n * c.block.rows
        lam = ca.reshape(multipliers[first : first + size], c.block.rows, n)
        bends.append(ca.vec(c.block.bend.map(n)(*arguments, lam, ca.repmat(weight, 1, n))))
        first += size
    hessian = _hessian(copies, ca.vertcat(*bends), variables)
    program = {"x": x, "p": p, "f": cost, "g": g}
    derivatives = {
        "grad_f": ca.Function("nlp_grad_f", [x, p], [tilted, ca.densify(gradient)], ["x", "p"], ["f", "grad_f_x"]),
        "jac_g": ca.Function("nlp_jac_g", [x, p], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
        "hess_lag": ca.Function(
            "nlp_hess_l", [x, p, weight, multipliers], [hessian], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
        ),
    }
    return program, derivatives


def _scatter(indices: Rows, size: int) -> Any:
    """The matrix of ones that adds values at indices into a vector of `size`."""
    return ca.DM.triplet(indices.tolist(), list(range(len(indices))), ca.DM.ones(len(indices)), size, len(indices))


def _jacobian(copies: Sequence[Copies], values: Any, rows: int, variables: int) -> Any:
    row, column, first = [], [], 0
    for c in copies:
        n = len(c.where)
        at_row, at_column = c.block.slope_at
        row.append((first + c.block.rows * np.arange(n)[:, None] + at_row).ravel())
        column.append(c.where[:, at_column].ravel())
        first += n * c.block.rows
    at, order = np.concatenate(row), np.concatenate(column)
    ranked = np.lexsort((at, order))
    pattern = ca.Sparsity.triplet(rows, variables, at[ranked].tolist(), order[ranked].tolist())
    return ca.MX(pattern, values[ranked.tolist()])


def _hessian(copies: Sequence[Copies], values: Any, variables: int) -> Any:
    row, column = [], []
    for c in copies:
        at_row, at_column = c.block.bend_at
        i, j = c.where[:, at_row].ravel(), c.where[:, at_column].ravel()
        row.append(np.minimum(i, j))
        column.append(np.maximum(i, j))
    i, j = np.concatenate(row), np.concatenate(column)
    keys, place = np.unique(j * variables + i, return_inverse=True)
    pattern = ca.Sparsity.triplet(variables, variables, (keys % variables).tolist(), (keys // variables).tolist())
    return ca.MX(pattern, ca.mtimes(_scatter(np.asarray(place, dtype=np.int64), len(keys)), values))
