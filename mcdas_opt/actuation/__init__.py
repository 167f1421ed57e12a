"""Between plan and plant: the paper's duty cycle, a speed law within limits, and the drive-by-wire loop that carries it out."""
