"""Doors to other formats and programs: one adapter a file, each imports its own package only when it is used."""
