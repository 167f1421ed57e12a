"""Reads `models/` and the users' files: the only room that knows file formats."""
