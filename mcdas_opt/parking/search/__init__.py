"""Paths of arcs out of the tight end of a case: searches whose cells become finer until one of them finds a path."""
