"""Gymnasium: our scenes as an environment for others' agents, and our planner as the agent in highway-env."""
