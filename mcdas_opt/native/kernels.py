"""The compiled libraries of the package: for each its C texts, its compiler flags and the signatures of its functions (`binding`).

Flags change no result but where they say so: a kernel that must give the bits of its array operations forbids fused operations.
"""

from __future__ import annotations

from mcdas_opt.native.binding import Library

_EXACT = "-fno-math-errno -fno-trapping-math -ffp-contract=off"  # no result changed
_NATIVE = f"-O3 -march=native {_EXACT}"


def _whole_vectors(flags: str, *names: str) -> str:
    """These functions of whole vectors, of glibc's libmvec: other last bits than the C library's."""
    return " ".join([flags, *(f"-fno-builtin-{name}" for name in names), "-DVECTOR_MATH -lmvec -lm"])


PLAIN = Library(
    texts=("rectangle_separations.c", "polygon_separations.c", "grown_bodies.c", "drive.c", "target_filter.c"),
    builds=("-O2 -ffp-contract=off -fno-math-errno -lm",),
    functions={
        "mcdas_separations": "lll" + 10 * "a" + "w",
        "mcdas_polygon_separations": "lll" + 7 * "a" + "w",
        "mcdas_grown": "llaaw",
        "mcdas_drive": "lpadalaww",
        "mcdas_follow": "ldalaaaaww",
        "mcdas_at": "pdddp",
        "mcdas_correct": "pdddp",
        "mcdas_cost": "pdddpddd>d",
        "mcdas_fixes": "laaddlplpp",
    },
)
"""The same operations as the arrays, one by one."""

CONSERVATIVE_ACCEPT = Library(
    texts=("conservative_accept.c",),
    builds=(
        _whole_vectors("-O3 -march=native -fno-math-errno -fno-trapping-math", "sin", "cos", "tan"),
        "-O2 -fno-math-errno -lm",
    ),
    functions={"mcdas_conservative_accept": "alaaallplpw>i"},
)
"""The judge's own."""

SHARPEST_PATH = Library(
    texts=("sharpest_path.c",),
    builds=(_whole_vectors(_NATIVE, "exp", "sin"), f"{_NATIVE} -lm", "-O2 -lm"),
    functions={"mcdas_sharpest": "a" + 8 * "d" + ">d"},
)

FAMILY = Library(
    texts=("family.c",),
    builds=SHARPEST_PATH.builds,
    functions={"mcdas_family_speeds": "p", "mcdas_family_score": "pw", "mcdas_family_best": "palwww", "mcdas_family_states": "pllw"},
)

_ROLLED = "--param max-completely-peeled-insns=60"  # gcc else unrolls loops over lanes before it sees that they are vectors: a seventh more

TIME_TO_REACT = Library(
    texts=("time_to_react.c",),
    builds=(
        *(f"-O3 -march=native -mno-avx512f {_EXACT} {rolled}-lm" for rolled in (f"{_ROLLED} ", "")),
        *(f"{_NATIVE} -lm", f"-O2 {_EXACT} -lm", "-O2 -lm"),
    ),
    functions={
        "mcdas_escape_traffic": "llaadaw",
        "mcdas_escape_constant_input": "paapw",
        "mcdas_escape_needs": "piapwww",
        "mcdas_escape_guess": "piiaaawwwwww",
        "mcdas_escape_sound": "piaapww",
        "mcdas_escape_met": "piaap>i",
        "mcdas_escape_answer": "pppldpplp>l",
    },
)

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
