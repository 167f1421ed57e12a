"""How the pages of docs/ become a site: python -m sphinx -W docs site"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "mcdas-opt"
author = "The mcdas-opt authors"
extensions = ["myst_nb", "sphinx.ext.autodoc", "equations", "terms_of_the_mpc", "model_cards", "file_keys", "claims"]
exclude_patterns = ["extensions"]
html_theme = "furo"
html_title = "mcdas-opt"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks are kept with their outputs; the tests run them
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
nitpicky = False


def _plain(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are plain sentences with `code`: their signs must not be read as markup."""
    for i, line in enumerate(lines):
        parts = re.split(r"(`[^`]+`)", line)
        lines[i] = "".join(f"`{part}`" if part.startswith("`") else re.sub(r"([*|_\\])", r"\\\1", part) for part in parts)


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", _plain)
