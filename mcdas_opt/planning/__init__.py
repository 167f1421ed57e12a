"""Composes the stages into an answer: the methods, the fallback ladder under them, the planner."""
