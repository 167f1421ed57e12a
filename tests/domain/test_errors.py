"""Errors go from one process to another whole: a pool that cannot read one waits for it for ever."""

from __future__ import annotations

import pickle

import pytest

from mcdas_opt.errors import InputError, McdasError, MissingExtraError, ParameterError


@pytest.mark.parametrize(
    "error",
    [
        ParameterError("friction", -1.0, "must be positive", "m"),
        ParameterError("length_m", 0.0, "must be greater than 0", "m", of="track 'x7'"),
        InputError("scene.toml", "road.friction", -1.0, "must be positive"),
        MissingExtraError("pandas", "dataframe", "pip install polars"),
    ],
)
def test_an_error_that_is_pickled_comes_back(error: McdasError) -> None:
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is type(error)
    assert str(back) == str(error)
    assert vars(back) == vars(error)
