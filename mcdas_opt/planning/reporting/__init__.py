"""What a plan says of itself: why, in which mode, on whom it relies, with which alert."""
