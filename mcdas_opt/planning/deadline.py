"""By when a cycle has to have its answer, and what is no longer begun as that comes near."""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import Enum

_ENDING_S = 0.02  # what comes after the search takes no longer, however much time there is


class Stage(Enum):
    """What takes time in a cycle, and after which share of the deadline it is no longer begun: of its last 20 ms, where it is longer.

    The search leaves room for the ladder below it, which leaves room for its last rung: simple drives, the least severe of which is always
    an answer. That rung is never left out. Where nothing passes it takes 2 to 4 ms, as much as a whole search: hence three quarters.
    """

    MORE_CANDIDATES = 0.05  # the sampled family, beside the basic four
    SEARCH = 0.25  # a candidate's solve, and what it is compared with
    CLOSED_FORM = 0.35  # the ladder's drive of the closed form
    GRADES = 0.4  # of simple drives, those between holding and all that the grip gives
    TIME_TO_REACT = 0.45  # the assessment that goes with the answer
    FOLLOWER = 0.5  # of what does not pass, whether a follower's reaction or a slower lane change would make it less severe
    SAFE_END = 0.55  # a plan that passes, continued to a safe end
    EXACT_VERDICT = 0.6  # of the least severe that does not pass, what exactly it meets: the pre-check has said that it does


@dataclass(frozen=True, slots=True, kw_only=True)
class Deadline:
    """The answer is due `length_s` after `began_s` (of `time.perf_counter`)."""

    began_s: float
    length_s: float

    def is_over_for(self, stage: Stage) -> bool:
        left_s = self.length_s - (time.perf_counter() - self.began_s)
        return left_s < (1.0 - stage.value) * min(self.length_s, _ENDING_S)
