"""C texts to shared libraries, compiled once and kept: the room below every room that has a compiled form of something. Knows no cars."""
