"""A folder of results: who made it, the frozen labels, and the journal of rows."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import read_json
from mcdas_opt.errors import InputError, writing
from mcdas_opt.evaluation.running.journal import write_whole

MANIFEST, LABELS, LABELLING, JOURNAL = "run.json", "labels.json", "labelling.journal", "rows.journal"


def open_folder(folder: Path, manifest: dict[str, Any]) -> bool:
    """Makes the folder and writes its manifest; whether it was there already, with this very manifest.

    Raises `InputError`, and touches nothing, where it holds anything else.
    """
    path = folder / MANIFEST
    if not os.path.isfile(path):
        if os.path.exists(folder) and not os.path.isdir(folder):
            raise InputError(folder, "", None, "is not a folder")
        if os.path.isdir(folder) and any(not entry.name.startswith(".") for entry in folder.iterdir()):
            raise InputError(folder, "", None, "is not empty and holds no such run: name another --out")
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps(manifest, indent=1) + "\n")
        return False
    found = read_json(path)
    if not isinstance(found, dict):
        raise InputError(path, "", None, "is not the manifest of a run")
    for key in manifest:
        if found.get(key) != manifest[key]:
            raise InputError(path, key, found.get(key), f"is of another run, this one has {manifest[key]!r}: name another --out")
    return True


def frozen_labels(folder: Path, suite_hash: str) -> dict[str, Any] | None:
    """The labels as they were frozen; None before that. Raises `InputError` where they are of another suite."""
    path = folder / LABELS
    if not os.path.isfile(path):
        return None
    found = read_json(path)
    if not isinstance(found, dict) or found.get("suite_hash") != suite_hash:
        raise InputError(path, "suite_hash", None, "labels of another suite")
    return found
