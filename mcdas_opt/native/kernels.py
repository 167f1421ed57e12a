"""The compiled libraries of the package: for each its C texts, its compiler flags and the signatures of its functions (`binding`).

Flags change no result but where they say so: a kernel that must give the bits of its array operations forbids fused operations.
"""

from __future__ import annotations

from mcdas_opt.native.binding import Library


def _whole_vectors(flags: str, *names: str) -> str:
    """These functions of whole vectors, of glibc's libmvec: other last bits than the C library's."""
    return " ".join([flags, *(f"-fno-builtin-{name}" for name in names), "-DVECTOR_MATH -lmvec -lm"])


# measured on AVX-512, a plain iteration with three neighbours: 14 us, 37 us, 45 us
_FAST = "-O2 -ftree-vectorize -march=native -fno-math-errno -fno-trapping-math"

INTERIOR_POINT = Library(
    texts=("interior_point.c",),
    builds=(_whole_vectors(_FAST, "sin", "cos"), f"{_FAST} -lm", "-O2 -lm"),
    functions={
        "mcdas_size": ">l",
        "mcdas_prepare": "p",
        "mcdas_cold": "ppppdd>i",
        "mcdas_warm": "pppppppdd>i",
        "mcdas_newton": "pidddp",
        "mcdas_measure": "ppppppp",
        "mcdas_loop": "piippppppp>i",
    },
)
"""Behind the stage functions of a problem, which are generated and stand before it."""
