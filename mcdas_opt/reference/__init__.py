"""Where the planner would like to be: the paper's sigmoid offset path, literal and corrected."""
