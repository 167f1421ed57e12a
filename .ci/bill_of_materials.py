"""A software bill of materials (CycloneDX 1.5, JSON) of what this environment runs the package on.

    python .ci/bill_of_materials.py [OUT]

The package, what it needs, and what that needs, as installed; extras are left out. The same environment gives the same bytes.
"""

from __future__ import annotations

import json
import re
import sys
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

ROOT = "mcdas-opt"


def normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def needs(package: Distribution) -> list[str]:
    """What it needs here, without extras."""
    asked = (Requirement(text) for text in package.requires or ())
    return sorted({normalised(one.name) for one in asked if one.marker is None or one.marker.evaluate({"extra": ""})})


def found_from(root: str) -> dict[str, Distribution]:
    """Every package that is reached from the root; raises `SystemExit` for one that is not installed."""
    found: dict[str, Distribution] = {}
    left = [root]
    while left:
        name = left.pop()
        if name in found:
            continue
        try:
            found[name] = distribution(name)
        except PackageNotFoundError:
            sys.exit(f"{name} is not installed")
        left += needs(found[name])
    return dict(sorted(found.items()))


def component(name: str, package: Distribution) -> dict[str, Any]:
    facts = package.metadata
    licence = facts.get("License-Expression") or facts.get("License") or "not said"
    known = {"type": "application" if name == ROOT else "library", "name": name, "version": package.version}
    said = {"licenses": [{"license": {"name": licence.splitlines()[0][:100]}}], "purl": f"pkg:pypi/{name}@{package.version}"}
    return {"bom-ref": said["purl"], **known, **said}


def bill() -> dict[str, Any]:
    packages = found_from(ROOT)
    parts = {name: component(name, package) for name, package in packages.items()}
    edges = [
        {"ref": parts[name]["bom-ref"], "dependsOn": [parts[other]["bom-ref"] for other in needs(package)]}
        for name, package in packages.items()
    ]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": parts.pop(ROOT)},
        "components": list(parts.values()),
        "dependencies": edges,
    }


if __name__ == "__main__":
    text = json.dumps(bill(), indent=2, ensure_ascii=False) + "\n"
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(text, "utf-8")
    else:
        sys.stdout.write(text)
