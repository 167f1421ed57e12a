"""Between plan and plant: the paper's duty cycle, and the tracking of plans."""
