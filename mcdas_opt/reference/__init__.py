"""The planner's reference: the paper's sigmoid offset path, literal and corrected."""
