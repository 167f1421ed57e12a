"""While the package is built by hatchling, its native library is built too: beside the texts for an editable install, else for the wheel.

Without a compiler the package is built without it, for any platform, and says so.
"""

from __future__ import annotations

import importlib.util
import platform
import sys
import sysconfig
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_WHERE = "mcdas_opt/native"


class NativeBuildHook(BuildHookInterface):
    """`[tool.hatch.build.targets.wheel.hooks.custom]`"""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        builder = _builder(Path(self.root) / _WHERE / "build.py")
        target: Path = builder.LIBRARY
        if version != "editable":
            self._folder = tempfile.TemporaryDirectory()
            target = Path(self._folder.name) / target.name
        try:
            builder.build(target)
        except builder.BuildError as error:
            self.app.display_warning(
                f"mcdas-opt is built without its native library: {error}. The interpreted form runs, ten times slower."
            )
            return
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{_platform()}"
        if version != "editable":
            build_data["force_include"][str(target)] = f"{_WHERE}/{target.name}"


def _platform() -> str:
    """The library is called by ctypes, so that no Python's binary interface matters; it is of one processor."""
    return sysconfig.get_platform().replace("universal2", platform.machine()).replace("-", "_").replace(".", "_")


def _builder(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("mcdas_opt_native_build", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module
