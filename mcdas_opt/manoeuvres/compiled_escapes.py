"""The escape map's questions in C: `escape_kernel.c`, which says what `swerves` and `parting` say, and `escape_questions.c`."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import PredictedBody, all_cruise
from mcdas_opt.domain.rules import Array
from mcdas_opt.manoeuvres import escape_effort, parting, swerves
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.escape_effort import ANCHORS, STARTS
from mcdas_opt.manoeuvres.escape_library import KINDS
from mcdas_opt.manoeuvres.held import PASSES
from mcdas_opt.manoeuvres.parting import Company, Rows
from mcdas_opt.native.kernels import c_text, defined, library, wanted

_TEXTS = ("escape_kernel.c", "escape_questions.c", "escape_guess.c", "escape_search.c")
_EFFORT: tuple[str, ...] = (
    "LEAST_ANCHORS",
    "ANCHORS",
    "APART_S",
    "STARTS",
    "BEST",
    "WIDER",
    "TRIED",
    "BEST_EASY",
    "TRIED_EASY",
    "DOWN",
    "UP",
    "BETWEEN",
    "CLOSE",
    "GENTLEST",
    "FARTHER",
    "REFINED",
    "IN_LANE",
    "STEERED",
    "STEADY",
    "MOST",
    "LEAST",
)
_LANES, _ROOM = 8, 104  # nodes come in whole lanes, and there are at most so many
_PLAIN = "-fno-math-errno -fno-trapping-math -ffp-contract=off"  # nothing that changes a result; half the time
_BUILDS = (f"-O3 -march=native -mno-avx512f {_PLAIN} -lm", f"-O3 -march=native {_PLAIN} -lm", f"-O2 {_PLAIN} -lm", "-O2 -lm")
_TABLES: tuple[str, ...] = (
    "others_s",
    "others_d",
    "others_mps",
    "half_length",
    "half_width",
    "longest",
    "table",
    "level",
    "until",
    "until_mps",
    "target",
    "lateral",
)
_TABLES += ("knots", "kappas")
_SIZES = ("bodies", "lattice", "held", "members", "in_lane", "half_steps", "count_of_knots")
_NUMBERS: tuple[str, ...] = ("wheelbase", "centre", "length", "width", "jerk_min", "jerk_max", "speed_max", "steering_max", "steering_rate")
_NUMBERS += ("limit", "steering_share", "brake", "accelerate", "left", "right", "end", "bend", "clear_m", "clear_s", "comfort", "shortest")
_NUMBERS += ("straightening",)


class _Case(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_void_p) for name in _TABLES),
        *((name, ctypes.c_longlong) for name in _SIZES),
        *((name, ctypes.c_double) for name in _NUMBERS),
    ]


def _nodes_fields(name: str) -> list[tuple[str, Any]]:
    pointers = [(f"{name}_{of}", ctypes.c_void_p) for of in ("steps", "times")]
    return [*pointers, *((f"{name}_{of}", ctypes.c_longlong) for of in ("n", "last", "middle"))]


class _Search(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("case", "kind", "times")),
        *_nodes_fields("coarse"),
        *_nodes_fields("exact"),
        *((name, ctypes.c_double) for name in ("host_d", "near_d", "latest_s")),
    ]


class Answer(NamedTuple):
    """When keeping on ends [s] and by what (a number, -1 for nothing); for each kind the last step of the lattice, of any demand and of a
    comfortable one, -1 without; what it asks that begins now, infinite without; what closes it (a number, -1: nothing before that end)."""

    end_s: float
    ender: int
    start: tuple[list[int], list[int]]
    now: list[float]
    closer: list[int]


class Nodes:
    """Times (T,) of a row on the lattice, as both sides want them: whole lanes, filled up with the last one."""

    def __init__(self, steps: Rows) -> None:
        self.steps = steps
        self.times_s = np.asarray(parting.LATTICE_S * steps, dtype=np.float64)
        missing = -steps.size % _LANES
        self._steps = np.concatenate([steps, np.repeat(steps[-1:], missing)]).astype(np.int64)
        self._times_s = np.asarray(parting.LATTICE_S * self._steps, dtype=np.float64)
        middle = min(int(np.searchsorted(self.times_s, 1.0)), steps.size - 1)
        self.record = self._steps.ctypes.data, self._times_s.ctypes.data, self._steps.size, steps.size - 1, middle
        self.arguments = (self._steps.size, steps.size - 1, self._steps.ctypes.data, self._times_s.ctypes.data, middle)


def company(library: ctypes.CDLL, bodies: Sequence[PredictedBody], until_s: float, margins: Margins) -> Company:
    """`Company.of`, in C where everybody keeps the speed, settles alike across, and nobody is grown by the prediction's own margins."""
    if not bodies or not all_cruise(bodies) or margins.share_of_prediction:
        return Company.of(bodies, until_s, margins)
    if len({b.lateral_fade_s for b in bodies}) > 1 or any(b.lateral_swell or b.acceleration_mps2 for b in bodies):
        return Company.of(bodies, until_s, margins)
    times = parting.lattice_s(round(until_s / parting.LATTICE_S) + 1)
    more = margins.along_m, margins.across_m
    begin = np.array([(b.s_m, b.d_m, b.speed_s_mps, b.speed_d_mps, b.lateral_fade_s, b.length_m, b.width_m, *more) for b in bodies])
    tables = np.empty((5, len(bodies), times.size))
    given = (q.ctypes.data for q in (begin, times, _faded(bodies[0].lateral_fade_s, times.size), tables))
    library.mcdas_escape_company(len(bodies), times.size, *given)
    s, d, speed, half_length, half_width = tables
    return Company(s_m=s, d_m=d, speed_mps=speed, half_length_m=half_length, half_width_m=half_width)


@lru_cache(maxsize=8)
def _faded(fade_s: float, count: int) -> Array:
    """What is left of a speed across at the lattice's first times."""
    return np.exp(-parting.lattice_s(count) / fade_s)


class CompiledCase:
    """One situation. `table` is contiguous: `held` writes into it."""

    def __init__(
        self, library: ctypes.CDLL, tables: Mapping[str, Array], numbers: Mapping[str, float], *, in_lane: int, half_steps: int
    ) -> None:
        self._library = library
        tables = {name: np.ascontiguousarray(table) for name, table in tables.items()}
        self._tables = tables
        sizes = {
            "bodies": tables["others_s"].shape[0],
            "lattice": tables["others_s"].shape[1],
            "held": tables["table"].shape[1],
            "members": tables["level"].size,
            "in_lane": in_lane,
            "half_steps": half_steps,
            "count_of_knots": tables["knots"].size,
        }
        self._sizes = sizes
        self._case = _Case(**{name: table.ctypes.data for name, table in tables.items()}, **sizes, **numbers)
        self._at = ctypes.addressof(self._case)

    def held(self, begin: Array, times_s: Array) -> None:
        """Fills the table with what a host does that keeps on from this state (6,), at times (H,)."""
        self._library.mcdas_escape_held(self._at, begin.ctypes.data, times_s.ctypes.data, self._tables["table"].ctypes.data)

    def needs(self, anchors: Rows, nodes: Nodes) -> tuple[Array, Array, Array]:
        """Below and above which distances (J, K, M) everybody is met by members begun at the anchors (K,); their slack (3, K, M)."""
        shape = anchors.size, self._sizes["members"]
        low, high = np.empty((self._sizes["bodies"], *shape)), np.empty((self._sizes["bodies"], *shape))
        slack = np.empty((3, *shape))
        begin = np.ascontiguousarray(anchors, dtype=np.int64)
        results = (low.ctypes.data, high.ctypes.data, slack.ctypes.data)
        self._library.mcdas_escape_needs(self._at, anchors.size, begin.ctypes.data, *nodes.arguments, *results)
        return low, high, slack

    def guess(self, starts_s: Array, weights: Array, apart_m: Array, needs: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        """The last of the starts (N,) in between, by weights (N, K) and distances (J, N), at which members are open; and comfortable.
        And by how many metres they are open at the first of them."""
        size = self._sizes["members"]
        now, last, known = np.empty(size), np.empty((2, size)), np.empty((weights.shape[1], size), dtype=np.uint8)
        apart = np.ascontiguousarray(apart_m)
        given = (q.ctypes.data for q in (starts_s, weights, apart, *needs, known))
        self._library.mcdas_escape_guess(self._at, weights.shape[1], starts_s.size, *given, now.ctypes.data, last.ctypes.data)
        return last[0], last[1], now

    def sound(self, members: Rows, starts: Rows, nodes: Nodes) -> tuple[NDArray[np.bool_], Array]:
        """Which members from these starts (R,) are ways out, and what they ask of the tyres [m/s^2]."""
        good, demand = np.empty(members.size, dtype=np.bool_), np.empty(members.size)
        member, start = np.ascontiguousarray(members, dtype=np.int64), np.ascontiguousarray(starts, dtype=np.int64)
        given, results = (member.ctypes.data, start.ctypes.data), (good.ctypes.data, demand.ctypes.data)
        self._library.mcdas_escape_sound(self._at, members.size, *given, *nodes.arguments, *results)
        return good, demand

    def map(self, kind: Rows, times_s: Array, coarse: Nodes, exact: Nodes, host_d_m: float, near_m: float, latest_s: float) -> Answer:
        """The whole map: `escape_search.c`."""
        sizes, count = self._sizes, len(KINDS)
        size, held, bodies = sizes["members"], sizes["held"], sizes["bodies"]
        work = np.empty(2 * held + STARTS * (1 + bodies) + size * (2 * bodies * ANCHORS + 3 * ANCHORS + 3))
        known = np.empty(ANCHORS * size, dtype=np.uint8)
        clock, floats, wholes = np.empty(held, dtype=np.int64), np.empty(1 + count), np.empty(1 + 3 * count, dtype=np.int64)
        kinds = np.ascontiguousarray(kind, dtype=np.int64)
        nodes = (q for each in (coarse, exact) for q in each.record)
        asked = _Search(self._at, kinds.ctypes.data, times_s.ctypes.data, *nodes, host_d_m, near_m, latest_s)
        results = work.ctypes.data, clock.ctypes.data, known.ctypes.data, floats.ctypes.data, wholes.ctypes.data
        self._library.mcdas_escape_map(ctypes.byref(asked), *results)
        end, *now = floats.tolist()
        ender, *rest = wholes.tolist()
        return Answer(end, ender, (rest[:count], rest[count : 2 * count]), now, rest[2 * count :])

    def met(self, clock: Rows, places: Array) -> tuple[int, int]:
        """When (as an index) a host that goes through these places (4, T): s, d, sine, cosine: first meets somebody, and whom; or -1."""
        moments, where = np.ascontiguousarray(clock, dtype=np.int64), np.ascontiguousarray(places)
        whom = ctypes.c_longlong(-1)
        rows = [where.ctypes.data + 8 * i * clock.size for i in range(4)]
        step = self._library.mcdas_escape_met(self._at, clock.size, moments.ctypes.data, *rows, ctypes.byref(whom))
        return int(step), whom.value


@lru_cache(maxsize=1)
def _library() -> ctypes.CDLL | None:
    numbers = {
        "LANES": _LANES,
        "ROOM": _ROOM,
        "SHARE": swerves.SHARE,
        "SLOWEST_MPS": swerves.SLOWEST_MPS,
        "STEEPEST": swerves.STEEPEST,
        "LEAST_M": swerves.LEAST_M,
        "GENTLE_S": swerves.GENTLE_S,
        "CURVIEST_1PM": swerves.CURVIEST_1PM,
        "ROUNDS": swerves.ROUNDS,
        "PASSES": PASSES,
        "EDGE_M": swerves.EDGE_M,
        "ROOM_SHARE": parting.ROOM_SHARE,
        "NOWHERE_M": parting.NOWHERE_M,
        "STEP_REACH_M": parting.STEP_REACH_M,
        "BOW": parting.BOW,
        "ARRIVED_M": parting.ARRIVED_M,
        "HELD_STEPS": parting.HELD_STEPS,
        "TURNED_STEPS": parting.TURNED_STEPS,
        "ABILITY_M": parting.ABILITY_M,
        "LATTICE_S": parting.LATTICE_S,
        **{name: getattr(escape_effort, name) for name in _EFFORT},
        "SEARCH_ROUNDS": escape_effort.ROUNDS,
    }
    found = library([defined(numbers), *(c_text("mcdas_opt.manoeuvres", name) for name in _TEXTS)], _BUILDS)
    if found is None:
        return None
    pointer, whole = ctypes.c_void_p, ctypes.c_int
    nodes: list[Any] = [whole, whole, pointer, pointer, whole]
    found.mcdas_escape_company.argtypes = [ctypes.c_longlong, ctypes.c_longlong, *[pointer] * 4]
    found.mcdas_escape_held.argtypes = [pointer] * 4
    found.mcdas_escape_needs.argtypes = [pointer, whole, pointer, *nodes, *[pointer] * 3]
    found.mcdas_escape_guess.argtypes = [pointer, whole, whole, *[pointer] * 9]
    found.mcdas_escape_sound.argtypes = [pointer, whole, pointer, pointer, *nodes, pointer, pointer]
    found.mcdas_escape_map.argtypes = [pointer] * 6
    found.mcdas_escape_met.argtypes = [pointer, whole, *[pointer] * 6]
    for name in ("company", "held", "needs", "guess", "sound", "map"):
        getattr(found, f"mcdas_escape_{name}").restype = None
    return found


def compiled_escapes() -> ctypes.CDLL | None:
    """The library, built on first use; None where there is no compiler, or MCDAS_OPT_COMPILE=0 forbids it."""
    return _library() if wanted() else None
