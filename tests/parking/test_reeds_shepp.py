"""Reeds-Shepp words: every one leads to its goal, and the shortest is as long there as back."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.parking.path import along_arc
from mcdas_opt.parking.search.reeds_shepp import WORD_TURNS, reeds_shepp

pose = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-4, 4))


@settings(max_examples=60, deadline=None)
@given(pose, pose)
def test_every_reeds_shepp_word_ends_at_its_goal(start, goal):
    radius = 4.4
    start, goal = np.array(start), np.array(goal)
    words = reeds_shepp(start[None], goal, radius)[0]
    there = np.isfinite(words[:, 0])
    assert there.any()
    at = np.broadcast_to(start, (len(words), 3))[there]
    for piece in range(5):
        at = along_arc(at, WORD_TURNS[there, piece] / radius, words[there, piece])
    assert np.abs(at[:, :2] - goal[:2]).max() < 1e-6
    assert np.abs((at[:, 2] - goal[2] + math.pi) % (2 * math.pi) - math.pi).max() < 1e-6
    shortest = np.abs(words[there]).sum(axis=1).min()
    assert shortest >= math.hypot(*(goal - start)[:2]) - 1e-9
    back = reeds_shepp(goal[None], start, radius)[0]
    assert np.nanmin(np.abs(back).sum(axis=1)) == pytest.approx(shortest, abs=1e-6)
