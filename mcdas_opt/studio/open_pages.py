"""The pages of one server that are open."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from mcdas_opt.errors import McdasError
from mcdas_opt.studio.page_session import PageSession
from mcdas_opt.studio.studio import Studio


class OpenPages:
    """Each page's session, by the key that the page sends its files with; `studio` is what they share."""

    def __init__(self, studio: Studio) -> None:
        self.studio = studio
        self._sessions: dict[str, PageSession] = {}

    def add(self, key: str, session: PageSession) -> None:
        self._sessions[key] = session

    def remove(self, key: str) -> None:
        self._sessions.pop(key, None)

    async def receive(self, key: str, name: str, body: bytes) -> dict[str, Any]:
        """A file that a page sent, opened in that page's session."""
        session = self._sessions.get(key)
        if session is None:
            return {"error": "this page is no longer known: load it again"}
        with tempfile.TemporaryDirectory(prefix="mcdas-studio-") as folder:
            suffix = Path(name).suffix.lower()
            file = Path(folder) / f"sent{suffix if suffix.isascii() and len(suffix) < 8 else ''}"
            file.write_bytes(body)
            try:
                session.waiting = await session.sent(file, Path(name).name)
            except McdasError as error:
                return {"error": self.studio.problem(error)["text"]}
        return {"name": name}

    def close(self) -> None:
        for session in self._sessions.values():
            session.stop()
        self.studio.close()
