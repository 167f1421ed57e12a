"""Measurements become tracks: screening, association, filtering, track life, coverage, prediction."""
