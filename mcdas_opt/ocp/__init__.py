"""Optimal control problems, posed with CasADi."""
