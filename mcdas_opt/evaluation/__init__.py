"""Measuring: the paper's tables and figures recomputed."""
