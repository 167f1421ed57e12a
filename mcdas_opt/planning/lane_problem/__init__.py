"""A proposal posed as the lane problem, solved, and driven."""
