"""How many packages `pip-audit` could ask about: one that its index does not know is not clean, only not asked about.

python .ci/audited.py AUDIT.json
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main() -> None:
    packages = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["dependencies"]
    audited = sum("skip_reason" not in package for package in packages)
    found = "no known vulnerability in these" if audited else "NOT AUDITED: this package index knows of no vulnerabilities"
    sys.stdout.write(f"pip-audit: {audited} of {len(packages)} packages, {found}\n")


if __name__ == "__main__":
    main()
