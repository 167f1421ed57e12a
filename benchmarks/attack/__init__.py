"""The attack: hostile numbers, clocks, files, kills and streams against every door, and what came of it, counted. See `__main__`."""
