"""Until when each way out can still be started: the escape map, the alert that follows from it, and what a plan says of both."""
