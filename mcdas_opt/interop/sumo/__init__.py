"""Eclipse SUMO: our planner at the wheel of one of its vehicles."""
