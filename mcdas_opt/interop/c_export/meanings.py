"""What the parameters of a node mean in the exported C: as `ocp.lane_mpc` and `ocp.terms` use them."""

from __future__ import annotations

import re

MEANINGS = {
    "kappa": "the road's curvature at kappa_s, left positive [1/m]",
    "kappa_slope": "its change along the road [1/m^2]",
    "kappa_s": "where along the road both hold: the s that is guessed for the node [m]",
    "ref_start_s": "s where the path to follow begins to steer out [m]",
    "ref_start_d": "d of that path before [m]",
    "ref_amplitude": "how far it goes aside, left positive [m]",
    "ref_a": "steepness of its sigmoid, less than 0 [1/m]",
    "ref_b": "the sigmoid's b, greater than 1: where along it the middle lies [-]",
    "ref_bend": "height of a hump on top of the amplitude, left positive [m]",
    "ref_bend_s": "s of the hump's middle [m]",
    "ref_bend_width": "the hump's width [m]",
    "speed_ref": "speed to drive towards [m/s]",
    "grip": "most that tyres give, along and across together [m/s^2]",
    "braking_unloads": "load that the braked axle loses per deceleration [s^2/m]",
    "brakes_by_load": "1: braking is shared between the axles by load; 0: by braking_pull [-]",
    "braking_pull": "braking force of the axle over its share of the mass, per deceleration of the car [-]",
    "driving_unloads": "load that the driven axle loses per acceleration [s^2/m]",
    "driving_pull": "force of the driven axle over its share of the mass, per acceleration of the car [-]",
    "left_edge": "d of the road's left edge [m], at edge_s where the edges slope",
    "right_edge": "d of the road's right edge [m], at edge_s where the edges slope",
    "left_slope": "change of the left edge's d along the road [-]",
    "right_slope": "change of the right edge's d along the road [-]",
    "edge_s": "s where both edges are as given [m]",
    "road_end": "s that the front bumper stays short of; far away without [m]",
    "front_bumper": "s of the rear bumper of the vehicle ahead; far away without [m]",
    "front_speed": "speed of the vehicle ahead [m/s]",
    "rear_bumper": "s of the front bumper of the vehicle behind; far behind without [m]",
    "rear_speed": "speed of the vehicle behind [m/s]",
    "standstill": "gap to keep at rest, ahead and behind [m]",
    "time_gap": "gap to keep ahead besides, per speed [s]",
    "most_acceleration": "acceleration that is comfortable [m/s^2]",
    "most_braking": "deceleration that is comfortable, greater than 0 [m/s^2]",
    "most_jerk": "jerk that is comfortable, either way [m/s^3]",
    "weight_path_deviation": "cost of being off the path [1/m^2]",
    "weight_heading_deviation": "cost of not heading along it [1/rad^2]",
    "weight_speed_deviation": "cost of another speed than speed_ref [s^2/m^2]",
    "weight_a": "cost of acceleration [s^4/m^2]",
    "weight_jerk": "cost of jerk [s^6/m^2]",
    "weight_delta_rate": "cost of the steering rate [s^2/rad^2]",
    "weight_lateral_acceleration": "cost of lateral acceleration [s^4/m^2]",
    "steering_rate_share": "share of the steering rate's limit that may be used [-]",
    "centre": "body centre ahead of the point that moves along the car's axis [m]",
    "body_s": "s of a neighbour's body centre [m]",
    "body_d": "d of a neighbour's body centre [m]",
    "body_along": "half its length, and the room kept around it [m]",
    "body_across": "half its width, and the room kept around it [m]",
}


def meaning(parameter: str) -> str:
    """What it means, and its unit. Raises `KeyError` for a parameter that nobody described."""
    return MEANINGS[re.sub(r"^body\d+_", "body_", parameter)]
