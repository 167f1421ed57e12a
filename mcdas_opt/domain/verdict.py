"""What the judge says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Violation:
    """One broken rule: its worst value, when, and the limit that it broke (tolerance not counted in)."""

    name: str
    t_s: float
    value: float
    limit: float
    unit: str

    def __str__(self) -> str:
        if self.name.startswith("collision"):
            return f"{self.name}, {-self.value:.2g} {self.unit} deep, at {self.t_s:.2f} s"
        return f"{self.name} {self.value:.3g} {self.unit} at {self.t_s:.2f} s, limit {self.limit:.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """`passed` exactly when there is no violation."""

    violations: tuple[Violation, ...] = ()
    passed: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "passed", not self.violations)

    @property
    def reason(self) -> str:
        """The first violation in words, or 'passed'."""
        return "passed" if self.passed else "; ".join(str(v) for v in self.violations[:2])
