"""Who remembers belongs to one thread: a second one inside at the same time is refused."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from mcdas_opt.errors import SharedPlannerError


class OneThread:
    """Threads that are inside, the first of which may stay. Nobody is inside a copy."""

    def __init__(self) -> None:
        self._inside: list[int] = []

    def __reduce__(self) -> tuple[type, tuple[()]]:
        return type(self), ()

    @contextmanager
    def inside(self) -> Iterator[None]:
        """The same thread may enter again. Raises `SharedPlannerError` while another is inside."""
        me = threading.get_ident()
        self._inside.append(me)
        try:
            if self._inside[0] != me:
                raise SharedPlannerError
            yield
        finally:
            self._inside.remove(me)
