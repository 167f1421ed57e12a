"""What stands in the way of the page is said before it is announced."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.studio.server import HOST, serve


def test_a_port_that_is_taken_is_named_and_nothing_announced(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(ParameterError, match=rf"port = {port}: cannot be listened on: .*--port"):
            serve(tmp_path, port, open_browser=False, announce=lambda: pytest.fail("announced"))


def test_a_folder_that_is_none_is_named_and_nothing_announced(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        serve(tmp_path / "none", 8090, open_browser=False, announce=lambda: pytest.fail("announced"))
