"""CommonRoad: scenarios in, scenes of ours; solutions out."""
