"""Whom a plan relies on is told in one text, and read from it again."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.safe_end import in_one_text, named_in


@given(st.lists(st.text(st.characters(exclude_characters=" "), min_size=1), unique=True))
def test_who_is_told_is_read_again(ids: list[str]) -> None:
    assert named_in(in_one_text(ids), ids) == ids


@pytest.mark.parametrize("told", [["salt and pepper"], ["a", "salt and pepper"], ["salt and pepper", "a"], ["salt", "a"]])
def test_an_id_may_hold_the_word_between_two(told: list[str]) -> None:
    assert named_in(in_one_text(told), ["a", "salt", "pepper", "salt and pepper"]) == told


def test_who_is_not_there_is_left_out() -> None:
    assert named_in("gone and a", ["a"]) == ["a"]
    assert named_in("gone", ["a"]) == []
