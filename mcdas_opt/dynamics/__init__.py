"""Equations, written once; the number system `m` is passed in (numpy, CasADi, math)."""
