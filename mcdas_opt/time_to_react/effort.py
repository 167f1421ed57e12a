"""How hard the escape map looks for last moments, in numpy as in C, which gets every number of this file by its name."""

from __future__ import annotations

LEAST_ANCHORS, ANCHORS, APART_S = 3, 6, 2.0  # starts from which every member is driven: so many, more where they are farther apart
STARTS = 41  # starts in between for which its last moment is guessed
BEST, WIDER = 12, 8  # members of each kind that are looked at exactly: at first, and where that does not settle it
TRIED = (5, 3, 2, 1, 0, -1, -3, -6, -10, -16, -25, -40)  # at which steps of the lattice from their guessed last start
BEST_EASY, TRIED_EASY = 2, (2, -1, -5)  # the same for comfortable ones
DOWN, UP, BETWEEN = (7, 14, 35, 90, 220), (4, 10), (0.25, 0.5, 0.75)  # steps down where none is sound, up where all are, shares of a gap
CLOSE = 2  # steps: a gap that is left
SEARCH_ROUNDS = 6
GENTLEST = 3  # members of each kind that may begin now
FARTHER, REFINED = (3, 1), 8  # steps later that the best one is tried from when it is varied a little, and how often
IN_LANE = (  # times level, until, push
    *((0.93, 1.0, 1.0), (1.07, 1.0, 1.0), (1.0, 0.8, 1.0), (1.0, 1.25, 1.0), (0.93, 1.25, 1.0), (1.07, 0.8, 1.0)),
    *((0.97, 1.0, 1.0), (1.03, 1.0, 1.0), (1.0, 0.9, 1.0), (1.0, 1.12, 1.0)),
)
STEERED = (
    *((1.0, 1.0, 0.94), (1.0, 1.0, 1.05), (0.9, 1.0, 1.0), (1.1, 1.0, 1.0), (1.0, 0.75, 1.0), (1.0, 1.3, 1.0)),
    *((1.1, 1.0, 0.94), (0.9, 1.0, 1.05), (1.0, 0.88, 1.0), (1.0, 1.14, 1.0)),
)
STEADY = 2  # of these for one that keeps its speed
MOST, LEAST = 0.99, 0.12  # of the braking and the accelerating there is; less in the lane is none
