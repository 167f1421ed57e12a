"""Builds of C with loops over samples that may be vectorised: no result changed; exp and sin of whole vectors where there are such."""

from __future__ import annotations

_PLAIN = "-fno-math-errno -fno-trapping-math -ffp-contract=off"
_NATIVE = f"-O3 -march=native {_PLAIN}"
_FUNCTIONS = ("exp", "sin")
_VECTORS = " ".join([*(f"-fno-builtin-{name}" for name in _FUNCTIONS), "-DVECTOR_MATH", "-lmvec", "-lm"])

BUILDS = (f"{_NATIVE} {_VECTORS}", f"{_NATIVE} -lm", "-O2 -lm")  # best first; libmvec is glibc's
DECLARED = "\n".join(
    [
        "#ifdef VECTOR_MATH",
        *(f'double {name}(double) __attribute__((simd("notinbranch"), const));' for name in _FUNCTIONS),
        "#endif",
    ]
)  # to stand after the head of a text
