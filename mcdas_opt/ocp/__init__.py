"""Optimal control problems as lists of named terms, in CasADi."""
