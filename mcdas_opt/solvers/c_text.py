"""CasADi functions as C99 text: straight-line code over one stage, or a loop over a block of them that a compiler can vectorise.

CasADi's own C generator handles one call at a time; here LANES stages lie side by side in memory (entry j of stage k at [j * LANES + k]),
so that the same instruction of neighbouring stages fills a vector register.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from mcdas_opt.errors import McdasError

_BINARY = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_FMIN: "LESSER({0}, {1})",
    ca.OP_FMAX: "GREATER({0}, {1})",
    ca.OP_LT: "({0} < {1}) ? 1.0 : 0.0",
    ca.OP_LE: "({0} <= {1}) ? 1.0 : 0.0",
    ca.OP_EQ: "({0} == {1}) ? 1.0 : 0.0",
    ca.OP_NE: "({0} != {1}) ? 1.0 : 0.0",
    ca.OP_AND: "({0} != 0.0 && {1} != 0.0) ? 1.0 : 0.0",
    ca.OP_OR: "({0} != 0.0 || {1} != 0.0) ? 1.0 : 0.0",
    ca.OP_IF_ELSE_ZERO: "({0} != 0.0) ? {1} : 0.0",
    ca.OP_POW: "pow({0}, {1})",
    ca.OP_CONSTPOW: "pow({0}, {1})",
    ca.OP_ATAN2: "atan2({0}, {1})",
    ca.OP_HYPOT: "hypot({0}, {1})",
    ca.OP_FMOD: "fmod({0}, {1})",
}
_UNARY = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_NOT: "({0} == 0.0) ? 1.0 : 0.0",
    ca.OP_SIGN: "({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : 0.0)",
    ca.OP_FABS: "fabs({0})",
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_EXP: "exp({0})",
    ca.OP_LOG: "log({0})",
    ca.OP_SIN: "sin({0})",
    ca.OP_COS: "cos({0})",
    ca.OP_TAN: "tan({0})",
    ca.OP_ASIN: "asin({0})",
    ca.OP_ACOS: "acos({0})",
    ca.OP_ATAN: "atan({0})",
    ca.OP_SINH: "sinh({0})",
    ca.OP_COSH: "cosh({0})",
    ca.OP_TANH: "tanh({0})",
    ca.OP_FLOOR: "floor({0})",
    ca.OP_CEIL: "ceil({0})",
}


class UnsupportedOperationError(McdasError):
    """An instruction that has no C text here."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Arguments:
    """How a function's arguments lie in memory, by their positions among the inputs and among the outputs. Else they are of one stage.

    `values` are numbers, passed as such; `constants` vectors that are the same for all stages. With `repeated` the function runs so many
    times as its first argument says, and those inputs and outputs move on each time. `sums`: outputs that replace an input.
    """

    values: tuple[int, ...] = ()
    constants: tuple[int, ...] = ()
    repeated: tuple[tuple[int, ...], tuple[int, ...]] | None = None
    sums: Mapping[int, int] = field(default_factory=dict)


def c_function(function: Any, *, loop: bool, arguments: Arguments = Arguments()) -> str:
    """C text of an SX function of vectors, `static void name(inputs..., outputs...)`, entry j of a stage at [j * LANES]. With `loop` it
    runs over the LANES stages of a block.
    """
    n_in, n_out = function.n_in(), function.n_out()
    summed = {to: of for of, to in arguments.sums.items()}
    given = ["int times"] if arguments.repeated else []
    for i in range(n_in):
        kind = "double a" if i in arguments.values else "double *restrict a" if i in summed else "const double *restrict a"
        given.append(f"{kind}{i}")
    given += [f"double *restrict r{i}" for i in range(n_out) if i not in arguments.sums]
    lane = " + k" if loop else ""
    lines: list[str] = []
    work: dict[int, str] = {}
    read: set[int] = set(summed)
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_OUTPUT:
            to = f"a{arguments.sums[outputs[0]]}" if outputs[0] in arguments.sums else f"r{outputs[0]}"
            lines.append(f"{to}[{outputs[1]} * LANES{lane}] = {work[inputs[0]]};")
            continue
        name = f"v{k}"
        if op == ca.OP_CONST:
            text = _number(function.instruction_constant(k))
        elif op == ca.OP_INPUT:
            read.add(inputs[0])
            if inputs[0] in arguments.values:
                text = f"a{inputs[0]}"
            elif inputs[0] in arguments.constants:
                text = f"a{inputs[0]}[{inputs[1]}]"
            else:
                text = f"a{inputs[0]}[{inputs[1]} * LANES{lane}]"
        elif op in _BINARY:
            text = _BINARY[op].format(work[inputs[0]], work[inputs[1]])
        elif op in _UNARY:
            text = _UNARY[op].format(work[inputs[0]])
        else:
            raise UnsupportedOperationError(f"{function.name()}: CasADi operation {op}")
        lines.append(f"const double {name} = {text};")
        work[outputs[0]] = name
    body = "\n".join(lines)
    if loop:
        body = f"#pragma GCC ivdep\nfor (int k = 0; k < LANES; k++) {{\n{body}\n}}"
    if arguments.repeated:
        moved = [f"a{i} += {function.nnz_in(i)} * LANES;" for i in arguments.repeated[0]]
        moved += [f"r{i} += {function.nnz_out(i)} * LANES;" for i in arguments.repeated[1]]
        body = f"for (int i = 0; i < times; i++) {{\n{body}\n{' '.join(moved)}\n}}"
    unread = "".join(f"(void)a{i};\n" for i in range(n_in) if i not in read)  # said, so that no compiler warns
    return f"static void {function.name()}({', '.join(given)})\n{{\n{unread}{body}\n}}\n"


def _number(value: float) -> str:
    text = repr(float(value))
    if text in ("inf", "-inf", "nan"):
        raise UnsupportedOperationError(f"the constant {text}")
    return f"({text})" if value < 0.0 else text
