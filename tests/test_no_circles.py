"""No files of the package import each other in a loop, imports within functions and for types included."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import mcdas_opt

ROOT = Path(mcdas_opt.__file__).parent


def name_of(path: Path) -> str:
    return ".".join(("mcdas_opt", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")


FILES = {name_of(path): path for path in ROOT.rglob("*.py")}


def imported(tree: ast.AST) -> Iterator[str]:
    """What a file imports, for its types too."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                yield f"{node.module}.{alias.name}" if f"{node.module}.{alias.name}" in FILES else node.module
        yield from imported(node)


def test_no_files_import_each_other_in_a_loop() -> None:
    graph = {name: {one for one in imported(ast.parse(path.read_text("utf-8"))) if one in FILES} for name, path in FILES.items()}
    del graph["mcdas_opt"]  # the door, which hands on whatever there is
    wanted = {name: {one for one in found if one not in (name, "mcdas_opt")} for name, found in graph.items()}
    assert sum(map(len, wanted.values())) > 1000
    try:
        TopologicalSorter(wanted).prepare()
    except CycleError as error:
        raise AssertionError(" -> ".join(error.args[1])) from None
