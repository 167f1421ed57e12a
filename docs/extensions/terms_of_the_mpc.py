"""The directive `terms-of-the-mpc`: every cost and constraint of the lane problem as it is built, so that the page cannot go stale."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> nodes.table:
    """A plain table of texts."""
    group = nodes.tgroup(cols=len(headings))
    group += [nodes.colspec(colwidth=1) for _ in headings]

    def row(cells: Sequence[str]) -> nodes.row:
        made = nodes.row()
        for cell in cells:
            made += nodes.entry("", nodes.paragraph(text=cell))
        return made

    head, body = nodes.thead("", row(headings)), nodes.tbody()
    body += [row(cells) for cells in rows]
    group += [head, body]
    return nodes.table("", group)


class Terms(Directive):
    """Two tables: costs with their weights, constraints with what violating them costs."""

    def run(self) -> list[nodes.Node]:
        from mcdas_opt.catalogue.vehicles import load_vehicle
        from mcdas_opt.ocp.lane_mpc import LaneProblem

        lane = LaneProblem(vehicle=load_vehicle("sedan"), neighbours=1)
        costs = [(c.name, f"{c.weight:g}", f"{c.terminal_weight:g}" if c.terminal_weight else "-") for c in lane.costs]
        constraints = []
        for constraint in lane.constraints:
            penalty = lane.penalties[constraint.slack]
            constraints.append((constraint.name, f"{penalty.linear:g} s + {penalty.quadratic:g} s^2"))
        problem = lane.stage_problem()
        bounds = [
            (name, _number(low), _number(high))
            for name, low, high in (
                *zip(problem.states, problem.x_lower, problem.x_upper, strict=True),
                *zip(problem.inputs, problem.u_lower, problem.u_upper, strict=True),
            )
        ]
        return [
            table(("cost: residual", "weight at a node of 0.1 s", "at the last node"), costs),
            table(("constraint (soft, by an exact penalty)", "penalty of a violation s"), constraints),
            table(("bound (hard), here of the sedan", "from", "to"), bounds),
        ]


def _number(value: Any) -> str:
    return "-" if abs(value) == float("inf") else f"{value:.4g}"


def setup(app: Any) -> dict[str, Any]:
    app.add_directive("terms-of-the-mpc", Terms)
    return {"parallel_read_safe": True}
