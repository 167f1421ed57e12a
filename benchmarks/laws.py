"""Laws over whole plans: of how many situations and sequences of every family they hold.

    python benchmarks/laws.py [--plans 1000] [--families sandwich,wide] [--laws permuted,clock] [--workers 2] [--show 3]

Every law asks a planner twice: as it is, and with something changed that must not matter. The laws, and what they ask for:

| law | changed | must be |
|---|---|---|
| permuted | the order of the tracks | the same document, to the bit |
| renamed | the tracks' ids, by any bijection, cycle for cycle the same | the same document, to the bit, once the names are put back |
| clock | the origin of time: 1,000 s to Unix time (1.7e9 s) | the same decision, states to 1e-6 m and the clock's resolution |
| moved | the place of s = 0: by 1 m to 1,000 km, without rounding | the same decision, states to 1e-6 m |
| cold | warm starts thrown away before every cycle; memory of decisions kept | the same decision, states of planned answers to 2 cm |
| jitter | each cycle's time, by up to 1 us | the same decision |
| again | the planner: one that has planned something else and was reset, instead of a new one | the same document, to the bit |
| forms | compiled or interpreted (`--laws forms`: it takes its time) | the same decision, states of plans that converged to 1e-6 m |
| settled | the same, every solve carried on to a last step of 1e-8 instead of 1e-2 | the same |

A decision is status, mode, side, chosen candidate, verdict passed, kind of safe end, alert, warning, and which candidates are open. States
are those of the chosen trajectory, (s, d) in metres, at every sample. A sequence keeps
a law when every cycle does; both planners are shown the same sequence, the one that the unchanged planner drove.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import mcdas_opt
from benchmarks import law_changes
from benchmarks.law_answers import Answer, Kept, apart_m, decision, first_difference, put_back, raised, told
from benchmarks.law_changes import clock_s, other_names
from benchmarks.random_traffic import KINDS, Episode, ask, episode, episodes
from mcdas_opt import Planner
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.solvers import interior_point

STATES_M = 1e-6
SETTLED_STEP = 1e-8  # of a solve in the law `settled`, relative to the problem's scales
COLD_M = 2e-2  # two solves, each settled to within a last step of 1 cm along the road
_FAST_MPS = 36.0

Moment = tuple[Situation, Answer]


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """`change` makes the sequence that the other planner is shown; `back` undoes it in an answer.

    With `prepare` both planners are shown another sequence than the usual one.
    """

    name: str
    least: Kept
    change: Callable[[Episode, Sequence[Situation]], list[Situation]] = lambda _, situations: list(situations)
    back: Callable[[Episode, Answer], Answer] = lambda _, answer: answer
    prepare: Callable[[Situation], Situation] | None = None
    states_m: float = STATES_M
    single: bool = True  # whether it says something of a single situation


LAWS = {
    law.name: law
    for law in (
        Law(name="permuted", least=Kept.BITS, change=law_changes.permuted),
        Law(name="renamed", least=Kept.BITS, change=law_changes.renamed),
        Law(name="clock", least=Kept.STATES, change=law_changes.later, back=law_changes.earlier),
        Law(name="moved", least=Kept.STATES, change=law_changes.farther, back=law_changes.nearer, prepare=law_changes.snapped),
        Law(name="cold", least=Kept.STATES, states_m=COLD_M, single=False),
        Law(name="jitter", least=Kept.DECISION, change=law_changes.jittered, single=False),
        Law(name="again", least=Kept.BITS),
        Law(name="forms", least=Kept.STATES),
        Law(name="settled", least=Kept.STATES),
    )
}
_AS_IT_IS = Law(name="as it is", least=Kept.BITS)
IN_BOTH_FORMS = ("forms", "settled")
QUICK = tuple(name for name in LAWS if name not in IN_BOTH_FORMS)


# --- asking ----------------------------------------------------------------------------------------------------------------------------


def usual(one: Episode) -> list[Moment]:
    """What a new planner is asked and answers, cycle by cycle; an exception ends it, as the answer."""
    planner, asked = _Noting(_planner(one)), []
    try:
        for _ in ask(one, planner):
            pass
    except Exception as error:
        asked.append((planner.asked[-1], raised(error)))
    return [*zip(planner.asked, planner.answers, strict=False), *asked]


@dataclass
class _Noting:
    """A planner that keeps what it was asked and what it answered."""

    planner: Planner

    def __post_init__(self) -> None:
        self.asked: list[Situation] = []
        self.answers: list[Answer] = []

    def plan(self, situation: Situation) -> Plan:
        self.asked.append(situation)
        plan = self.planner.plan(situation)
        self.answers.append(told(plan))
        return plan


def changed(one: Episode, law: Law, asked: Sequence[Situation]) -> list[Answer]:
    """What is answered once the law's change is made: to every cycle, or up to an exception."""
    planner = _planner(one)
    if law.name == "again":
        _distract(planner, one)
    answers: list[Answer] = []
    for situation in law.change(one, asked):
        if law.name == "cold":
            forget_warm_starts(planner)
        try:
            answers.append(law.back(one, told(planner.plan(situation))))
        except Exception as error:
            answers.append(raised(error))
            break
    return answers


def forget_warm_starts(planner: Planner) -> None:
    """Throws away what the solvers keep for the next cycle, and nothing else; does nothing for a baseline, which keeps none."""
    if isinstance(planner.method, MpcMethod):
        for solver in planner.method.solvers:
            solver.forget()


def _distract(planner: Planner, one: Episode) -> None:
    """Something else is planned, in which the second engine is asked too, and forgotten."""
    for other in (episode("contradictory", 20), episode(one.family, one.number + 1)):
        planner.plan(replace(other.first, vehicle=one.vehicle))
    planner.reset()


def _planner(one: Episode) -> Planner:
    return Planner(vehicle=one.vehicle, method=one.method)


# --- comparing -------------------------------------------------------------------------------------------------------------------------


def kept(law: Law, one: Episode, before: Answer, after: Answer, names: dict[str, str] | None = None) -> tuple[Kept, str]:
    """How much stayed the same, and in words what did not."""
    if names:
        after = put_back(after, names)
    if "raised" in before or "raised" in after:
        same = before == after
        return (Kept.BITS, "") if same else (Kept.NOTHING, f"{before.get('raised', 'a plan')} | {after.get('raised', 'a plan')}")
    ours, theirs = decision(before), decision(after)
    if ours != theirs:
        name = next(name for name in ours if ours[name] != theirs[name])
        return Kept.NOTHING, f"{name}: {ours[name]} | {theirs[name]}"
    apart = apart_m(before, after)
    slack = law.states_m
    if law.name == "clock":  # what a fast car drives while that clock stands still
        slack += _FAST_MPS * math.ulp(clock_s(one))
    if law.name in IN_BOTH_FORMS and not (before["converged"] and after["converged"]):
        slack = math.inf  # a solve that was cut short has not settled: its last digits are those of its roundings
    if law.name == "cold" and before["status"] != "planned":
        slack = math.inf  # where nothing passes, several drives may be as bad as each other
    if apart > slack:
        return Kept.DECISION, f"states {apart:.2g} m apart"
    if before != after:
        return Kept.STATES, f"states {apart:.2g} m apart; {first_difference(before, after)}"
    return Kept.BITS, ""


def examine(one: Episode, law: Law, moments: Sequence[Moment]) -> tuple[Kept, str]:
    """Over all cycles, the least that stayed the same, with the first cycle in which it was so little."""
    asked, answers = [situation for situation, _ in moments], [answer for _, answer in moments]
    if law.prepare is not None:
        asked = [law.prepare(situation) for situation in asked]
        answers = changed(one, _AS_IT_IS, asked)
    names = other_names(one, asked) if law.name == "renamed" else None
    least, words = Kept.BITS, ""
    for cycle, (before, after) in enumerate(zip(answers, changed(one, law, asked), strict=False)):
        now, said = kept(law, one, json.loads(json.dumps(before)), json.loads(json.dumps(after)), names)
        if now < least:
            least, words = now, f"cycle {cycle}: {said}"
    return least, words


# --- both forms ------------------------------------------------------------------------------------------------------------------------


def interpreted(asked: list[tuple[str, str, list[str]]], law: Law) -> list[list[Answer]]:
    """What the interpreted form answers to sequences (vehicle, method, situations as JSON): in a process of its own."""
    path = os.pathsep.join(str(Path(file).resolve().parent.parent) for file in (mcdas_opt.__file__, __file__))
    done = subprocess.run(
        [sys.executable, "-c", f"from benchmarks.laws import replay; replay({law.name!r})"],
        input=json.dumps(asked),
        env=os.environ | {"MCDAS_OPT_COMPILE": "0", "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    answers: list[list[Answer]] = json.loads(done.stdout)
    return answers


def replay(law: str) -> None:
    """From sequences on stdin to answers on stdout, as `interpreted` says."""
    with _solves_of(LAWS[law]):
        json.dump([_replayed(*one) for one in json.load(sys.stdin)], sys.stdout)


@contextmanager
def _solves_of(law: Law) -> Iterator[None]:
    """Within it, solves end as the law has them end."""
    rule = interior_point.RULE
    if law.name == "settled":
        interior_point.RULE = rule._replace(step_tolerance=SETTLED_STEP)
    try:
        yield
    finally:
        interior_point.RULE = rule


def _replayed(vehicle: str, method: str, situations: list[str]) -> list[Answer]:
    planner, answers = Planner(vehicle=vehicle, method=method), []
    for text in situations:
        try:
            answers.append(told(planner.plan(Situation.from_json(text))))
        except Exception as error:
            answers.append(raised(error))
            break
    return answers


def examine_forms(some: Sequence[Episode], law: Law) -> Iterator[tuple[Episode, Kept, str]]:
    """Law 'forms' or 'settled' of each: whether the interpreted form decides as the compiled one does."""
    with _solves_of(law):
        runs = [usual(one) for one in some]
    asked = [(one.vehicle, one.method, [situation.to_json() for situation, _ in run]) for one, run in zip(some, runs, strict=True)]
    for one, run, answers in zip(some, runs, interpreted(asked, law), strict=True):
        least, words = Kept.BITS, ""
        for cycle, ((_, before), after) in enumerate(zip(run, answers, strict=False)):
            ours, theirs = ({name: value for name, value in answer.items() if name != "solver"} for answer in (before, after))
            now, said = kept(law, one, json.loads(json.dumps(ours)), theirs)
            if now < least:
                least, words = now, f"cycle {cycle}: {said}"
        yield one, least, words


# --- the program -----------------------------------------------------------------------------------------------------------------------

AT_ONCE = 25
Found = tuple[str, str, str, int, str]  # family, law, episode, what was kept, words


def _task(asked: tuple[Episode, tuple[str, ...]]) -> list[Found]:
    one, names = asked
    moments = usual(one)
    wanted = [LAWS[name] for name in names if LAWS[name].single or one.cycles > 1]
    return [(one.family, law.name, one.name, *examine(one, law, moments)) for law in wanted]


def _forms_task(asked: tuple[list[Episode], str]) -> list[Found]:
    some, name = asked
    return [(one.family, name, one.name, least, words) for one, least, words in examine_forms(some, LAWS[name])]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plans", type=int, default=1000, help="of each family")
    parser.add_argument("--families", default=",".join(KINDS))
    parser.add_argument("--laws", default=",".join(QUICK), help="default: all that need one form alone")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, metavar="FILE", help="a line of JSON for each sequence and law")
    parser.add_argument("--show", type=int, default=3, help="so many that break a law are named")
    given = parser.parse_args()
    names = tuple(given.laws.split(","))
    some = [one for family in given.families.split(",") for one in episodes(family, given.plans)]
    counts: Counter[tuple[str, str, int]] = Counter()
    broken: dict[str, list[str]] = {}
    quick = tuple(name for name in names if name in QUICK)

    def note(found: list[Found]) -> None:
        if given.out is not None:
            with given.out.open("a") as file:
                file.writelines(json.dumps(each) + "\n" for each in found)
        for family, law, name, least, words in found:
            counts[law, family, least] += 1
            if least < LAWS[law].least:
                broken.setdefault(law, []).append(f"{name} {words}")

    with multiprocessing.get_context("spawn").Pool(given.workers) as pool:
        if quick:
            for found in pool.imap_unordered(_task, [(one, quick) for one in some], chunksize=4):
                note(found)
        # the others ask another process: as many episodes at once as make its start cheap
        batches = [some[first : first + AT_ONCE] for first in range(0, len(some), AT_ONCE)]
        for found in pool.imap_unordered(_forms_task, [(batch, name) for name in names if name in IN_BOTH_FORMS for batch in batches]):
            note(found)
    for law in names:
        _tell(law, counts, broken.get(law, []), given.show)
    return 1 if broken else 0


def _tell(law: str, counts: Counter[tuple[str, str, int]], broken: list[str], show: int) -> None:
    """Of how many sequences a law holds, in all and in each family; and some that break it."""

    def line(name: str, k: list[int]) -> None:
        levels = f"bits {k[3]}, states {k[2]}, decision {k[1]}, nothing {k[0]}"
        print(f"    {name:<14} {sum(k[LAWS[law].least :]):>5} of {sum(k):<5}  {levels}")

    families = [family for family in KINDS if any(counts[law, family, level] for level in Kept)]
    print(f"\n{law}: must be {LAWS[law].least.name.lower()}")
    for family in families:
        line(family, [counts[law, family, level] for level in Kept])
    line("all together", [sum(counts[law, family, level] for family in families) for level in Kept])
    for words in sorted(broken)[:show]:
        print(f"      {words}")


if __name__ == "__main__":
    sys.exit(main())
