"""What was left out of an input, by kind, and where it began."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class Tally:
    """Counts by kind with the first line of each kind; grows while a file is read."""

    counts: dict[str, int] = field(default_factory=dict)
    first_lines: dict[str, int] = field(default_factory=dict)

    def add(self, kind: str, line: int) -> None:
        self.counts[kind] = self.counts.get(kind, 0) + 1
        self.first_lines[kind] = min(line, self.first_lines.get(kind, line))

    def absorb(self, other: Tally, prefix: str = "") -> None:
        """Adds another tally; its kinds are named with `prefix`, so that lines of two files stay apart."""
        for kind, count in other.counts.items():
            name = prefix + kind
            self.counts[name] = self.counts.get(name, 0) + count
            line = other.first_lines[kind]
            self.first_lines[name] = min(line, self.first_lines.get(name, line))

    @property
    def total(self) -> int:
        return sum(self.counts.values())

    def to_document(self) -> dict[str, dict[str, int]]:
        """`{kind: {count, first_line}}`, kinds in alphabetical order."""
        return {kind: {"count": self.counts[kind], "first_line": self.first_lines[kind]} for kind in sorted(self.counts)}
