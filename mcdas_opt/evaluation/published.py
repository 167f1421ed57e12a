"""What the paper prints, digit by digit (y positive to the right, km/h)."""

from __future__ import annotations

from typing import NamedTuple

DUTY_OF_REAR, DUTY_OF_HOST_BEFORE, DUTY_OF_HOST = 0.25, 0.16666667, 0.25  # Table 2
REAR_KMH, FRONT_KMH, HOST_KMH, FASTEST_KMH = 60.0, 40.0, 40.0, 240.0


class FinalPosition(NamedTuple):
    """A row of Table 3, "Final Position" at x = 20 m [m]."""

    offset: float
    y_left: float
    absolute_left: float
    error_left: float
    y_right: float
    absolute_right: float
    error_right: float


TABLE_3 = (
    FinalPosition(-2.0, -5.4942056, -5.7, -0.2057944, 1.6386227, 1.7, 0.0613773),
    FinalPosition(-1.5, -5.0122578, -5.2, -0.1877422, 2.1205706, 2.2, 0.0794294),
    FinalPosition(-1.0, -4.5303099, -4.7, -0.1696901, 2.6025185, 2.7, 0.0974815),
    FinalPosition(-0.5, -4.048362, -4.2, -0.151638, 3.0844663, 3.2, 0.1155337),
    FinalPosition(0.0, -3.5664142, -3.7, -0.1335858, 3.5664142, 3.7, 0.1335858),
    FinalPosition(0.5, -3.0844663, -3.2, -0.1155337, 4.048362, 4.2, 0.151638),
    FinalPosition(1.0, -2.6025185, -2.7, -0.0974815, 4.5303099, 4.7, 0.1696901),
    FinalPosition(1.5, -2.1205706, -2.2, -0.0794294, 5.0122578, 5.2, 0.1877422),
    FinalPosition(2.0, -1.6386227, -1.7, -0.0613773, 5.4942056, 5.7, 0.2057944),
)

TABLE_4_LEFT = (-0.0613773, -0.2057944)
TABLE_4_RIGHT = (0.0613773, 0.2057944)
SLIP_IN_THE_TEXT = 0.0638  # section 3.1.5, below Table 4

TABLE_5_B = (45.0, 60.0)
TABLE_5_ERROR = (0.06, 0.08)  # at b = 60 and at b = 45

SAMPLES, SAMPLE_S = 11, 0.5
CRASH_ZONE_M = (100.0, 120.0)
SETTLED_AT_M = 250.0
FIRST_DEVIATION_M = 0.2
