"""Answers that are the same for whoever asks the same: the latest are kept, so that what every page shows first is planned once."""

from __future__ import annotations

import pickle
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from typing import Any

_KEPT = 200


class KeptAnswers:
    """Of a planner, or another function of a question, by its name. A question is known by what it is sent to a process as."""

    def __init__(self, kept: int = _KEPT) -> None:
        self._most = kept
        self._answers: OrderedDict[tuple[str, bytes], Any] = OrderedDict()

    async def of(self, name: str, question: Any, work: Callable[[], Awaitable[Any]]) -> Any:
        """The answer that was kept, else what `work` gives; where that raises nothing is kept."""
        key = name, pickle.dumps(question)
        if key not in self._answers:
            self._answers[key] = await work()
        self._answers.move_to_end(key)
        answer = self._answers[key]
        while len(self._answers) > self._most:
            self._answers.popitem(last=False)
        return answer
