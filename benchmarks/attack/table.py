"""What the blocks of a campaign add up to: a line an attack, each fault once, and which commit ran how many."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from itertools import count
from typing import Any

from benchmarks.attack.tally import Tally

_SHOWN = 400  # characters of an input that showed a fault
_COUNTS = tuple(field.name for field in fields(Tally) if field.type == "int")


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """So many cases of one attack, from one seed, on one commit."""

    attack: str
    seed: int
    took_s: float
    commit: str
    tally: Tally

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def of(cls, record: dict[str, Any]) -> Block:
        return cls(**{**record, "tally": Tally(**record["tally"])})


class Table:
    """Of the attacks that are asked for, in that order."""

    def __init__(self, names: list[str], blocks: Iterable[Block], goals: dict[str, int]) -> None:
        self.names, self.goals = names, goals
        self._by_seed: dict[str, dict[int, Block]] = {name: {} for name in names}
        for block in blocks:
            if block.attack in self._by_seed:
                self.add(block)

    def add(self, block: Block) -> None:
        """The same seed again, on other code, takes the place of what it found before."""
        self._by_seed[block.attack][block.seed] = block

    def of(self, name: str) -> list[Block]:
        return list(self._by_seed[name].values())

    def tried(self, name: str) -> int:
        return sum(block.tally.tried for block in self.of(name))

    def free_seed(self, name: str, first: int) -> int:
        """The first from there on that has not been used."""
        return next(seed for seed in count(first) if seed not in self._by_seed[name])

    @property
    def wrong(self) -> int:
        return sum(block.tally.wrong for name in self.names for block in self.of(name))

    @property
    def heading(self) -> str:
        return (
            f"{'attack':13s}{'goal':>9s}"
            + "".join(f"{name:>12s}" for name in _COUNTS)
            + f"{'worst [s]':>12s}{'took [s]':>10s}  cases by commit"
        )

    def row(self, name: str) -> str:
        blocks, by_commit = self.of(name), Counter[str]()
        for block in blocks:
            by_commit[block.commit] += block.tally.tried
        counts = "".join(f"{sum(getattr(block.tally, what) for block in blocks):12d}" for what in _COUNTS)
        worst_s, took_s = max((block.tally.worst_s for block in blocks), default=0.0), sum(block.took_s for block in blocks)
        commits = ", ".join(f"{cases} {commit}" for commit, cases in by_commit.items())
        return f"{name:13s}{self.goals.get(name, 0):9d}{counts}{worst_s:12.2f}{took_s:10.1f}  {commits}"

    @property
    def closing(self) -> str:
        """What else was counted, and the faults."""
        lines = [f"{name}: {what}: {number}" for name in self.names for what, number in self._counted(name).items()]
        return "\n".join([*lines, *self._faults()])

    def _counted(self, name: str) -> Counter[str]:
        found = Counter[str]()
        for block in self.of(name):
            found.update(block.tally.counted)
        return found

    def _faults(self) -> list[str]:
        """Of each distinct one the shortest input, and the commit that showed it."""
        found: dict[tuple[str, str], tuple[str, str]] = {}
        for name in self.names:
            for block in self.of(name):
                for fault, shown in block.tally.faults.items():
                    if (name, fault) not in found or len(shown) < len(found[name, fault][0]):
                        found[name, fault] = (shown, block.commit)
        return [f"{name}: {fault} ({commit})\n    {shown[:_SHOWN]}" for (name, fault), (shown, commit) in sorted(found.items())]
