"""Composes the stages into an answer: the methods, the ladder under them, the planner."""
