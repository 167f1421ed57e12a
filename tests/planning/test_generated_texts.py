"""The generated C texts in the repository are what is generated now."""

from __future__ import annotations

from mcdas_opt.planning.generated_texts import FOLDER, generated_texts


def test_they_are_what_is_generated_now() -> None:
    assert {path.name: path.read_text("utf-8") for path in FOLDER.iterdir()} == generated_texts()
