"""Addresses for compiled libraries."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.native.binding import address


@pytest.mark.parametrize("array", [np.arange(5.0), np.zeros((3, 4))[1], np.zeros(0), np.zeros((2, 0)), np.zeros(3, dtype=np.int64)])
@pytest.mark.parametrize("writeable", [True, False])
def test_it_is_where_numpy_says_that_the_array_lies(array, writeable):
    array = array.copy()
    array.setflags(write=writeable)
    assert address(array) == array.ctypes.data
