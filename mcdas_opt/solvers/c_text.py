"""CasADi functions as C99 text: straight-line code over one stage, or a loop over all of them that a compiler can vectorise.

CasADi's own C generator handles one call at a time; here the stages lie side by side in memory (entry j of stage k at [j * LD + k]),
so that the same instruction of neighbouring stages fills a vector register.
"""

from __future__ import annotations

from collections.abc import Sequence
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


def c_function(function: Any, *, loop: bool, shared: Sequence[int] = ()) -> str:
    """C text of an SX function of vectors, `static void name(int k | nothing, inputs..., outputs...)`.

    The inputs `shared` are scalars, the same for all stages, passed by value. With `loop` it runs over all LD stages.
    """
    n_in, n_out = function.n_in(), function.n_out()
    arguments = [] if loop else ["int k"]
    arguments += [f"double a{i}" if i in shared else f"const double *restrict a{i}" for i in range(n_in)]
    arguments += [f"double *restrict r{i}" for i in range(n_out)]
    lines: list[str] = []
    work: dict[int, str] = {}
    read: set[int] = set()
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_OUTPUT:
            lines.append(f"r{outputs[0]}[{outputs[1]} * LD + k] = {work[inputs[0]]};")
            continue
        name = f"v{k}"
        if op == ca.OP_CONST:
            text = _number(function.instruction_constant(k))
        elif op == ca.OP_INPUT:
            read.add(inputs[0])
            text = f"a{inputs[0]}" if inputs[0] in shared else f"a{inputs[0]}[{inputs[1]} * LD + k]"
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
        body = f"#pragma GCC ivdep\nfor (int k = 0; k < LD; k++) {{\n{body}\n}}"
    unread = "".join(f"(void)a{i};\n" for i in range(n_in) if i not in read)  # said, so that no compiler warns
    return f"static void {function.name()}({', '.join(arguments)})\n{{\n{unread}{body}\n}}\n"


def _number(value: float) -> str:
    text = repr(float(value))
    if text in ("inf", "-inf", "nan"):
        raise UnsupportedOperationError(f"the constant {text}")
    return f"({text})" if value < 0.0 else text
