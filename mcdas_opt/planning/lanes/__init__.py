"""Lanes: which one is wanted, which one has to be reached, through which gap, and the lane change that is under way."""
