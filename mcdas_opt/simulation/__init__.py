"""The closed loop: neighbours, sensors, plant, and the drive of a planner through a scene."""
