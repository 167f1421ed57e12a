"""Between plan and plant: the paper's duty cycle, a speed law within limits, the drive-by-wire loop, and the tracking of plans."""
