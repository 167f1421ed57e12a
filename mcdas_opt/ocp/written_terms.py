"""What a term of the lane problem writes for a stage, checked: a mistake in it is told under the term's name."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import casadi as ca

from mcdas_opt.errors import ParameterError
from mcdas_opt.ocp.terms import Constraint, Cost, Stage

_COMPARISONS = (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE)


def residual_of(cost: Cost, stage: Stage) -> Any:
    """Its residual, or a column of them. Raises `ParameterError` that names the cost."""
    residual = _written(cost.name, cost.residual, stage)
    is_column = isinstance(residual, ca.SX) and residual.is_column() and residual.numel() > 0
    for one in ca.vertsplit(residual) if is_column else [residual]:
        _expression(cost.name, one, "a residual")
    return residual


def rows_of(constraint: Constraint, stage: Stage, families: Collection[str]) -> list[Any]:
    """Its rows, a list of one expression each. Raises `ParameterError` that names the constraint."""
    if constraint.slack not in families:
        raise ParameterError(
            constraint.name, constraint.slack, f"its slack must be one of the families with a penalty: {', '.join(families)}"
        )
    rows = _written(constraint.name, constraint.rows, stage)
    if not isinstance(rows, list | tuple) or not rows:
        raise ParameterError(constraint.name, rows, "its rows must be a list of at least one expression")
    return [_expression(constraint.name, row, "a row") for row in rows]


def _written(name: str, write: Callable[[Stage], Any], stage: Stage) -> Any:
    try:
        return write(stage)
    except KeyError as error:
        raise ParameterError(name, error.args[0], "must be listed in the term's parameters") from None
    except Exception as error:
        raise ParameterError(name, f"{type(error).__name__}: {error}", "a term must give expressions of the stage") from error


def _expression(name: str, written: Any, what: str) -> Any:
    """A number or one CasADi expression that is not a comparison, which is 0 or 1."""
    is_number = isinstance(written, int | float) and not isinstance(written, bool)
    if not is_number and not (isinstance(written, ca.SX | ca.DM) and written.is_scalar() and not _is_comparison(ca.SX(written))):
        raise ParameterError(name, written, f"{what} must be one expression, and no comparison")
    return written


def _is_comparison(written: Any) -> bool:
    return not written.is_constant() and not written.is_symbolic() and written.op() in _COMPARISONS
