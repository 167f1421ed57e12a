"""What may be called of the native library, each function with its signature (`binding`)."""

from __future__ import annotations

_FAMILY = {"mcdas_family_speeds": "p", "mcdas_family_score": "pw", "mcdas_family_best": "palwww", "mcdas_family_states": "pllw"}

FUNCTIONS = {
    "mcdas_digest": ">l",
    "mcdas_level": ">i",
    "mcdas_separations": "lll" + 10 * "a" + "w",
    "mcdas_polygon_separations": "lll" + 7 * "a" + "w",
    "mcdas_grown": "llaaw",
    "mcdas_in_reach": "llaaaaaw",
    "mcdas_time_gaps": "llaaadaddw",
    "mcdas_missing_headway": "lllaaaaaaaww",
    "mcdas_cost_rate": "llaaalaaaw",
    "mcdas_speeds_along": "lalalaaww",
    "mcdas_ends": "llaaalaaalaaaaww",
    "mcdas_drive": "lpadalaww",
    "mcdas_follow": "ldalaaaaww",
    "mcdas_at": "pdddp",
    "mcdas_correct": "pdddp",
    "mcdas_cost": "pdddpddd>d",
    "mcdas_fixes": "laaddlplpp",
    "mcdas_conservative_accept": "alaaallplpww>i",
    "mcdas_sharpest": "a" + 8 * "d" + ">d",
    **_FAMILY,
    **{f"{name}_any_length": signature for name, signature in _FAMILY.items()},
    "mcdas_escape_sound": "piaapww",
    "mcdas_escape_answer": "pppldpplp>l",
    "mcdas_size": "ll>l",
    "mcdas_prepare": "pllalaal",
    "mcdas_cold": "ppppdd>i",
    "mcdas_warm": "pppppppdd>i",
    "mcdas_newton": "pidddp",
    "mcdas_measure": "ppppppp",
    "mcdas_loop": "piippppppp>i",
}
