"""Matrices in, matrices out: engines for stage-wise optimal control problems. They know no cars."""
