"""Signed separations of the car's poses from the obstacles: `PolygonField.separation`, in C where there is a compiler."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField
from mcdas_opt.native.library import library


def separation(field: PolygonField, poses: Array, body: Body) -> Array:
    """(n, m) signed distance [m] of the body at poses (n, 3) to each of the field's m polygons.

    Sines and cosines are numpy's in both forms, so that both give the same bits.
    """
    apart = _compiled(field, poses, body, least=False)
    return field.separation(poses, body) if apart is None else apart


def clearance(field: PolygonField, poses: Array, body: Body) -> Array:
    """(n,) least of the `separation`s; infinite without polygons."""
    apart = _compiled(field, poses, body, least=True)
    return field.clearance(poses, body) if apart is None else apart


def _compiled(field: PolygonField, poses: Array, body: Body, *, least: bool) -> Array | None:
    compiled = library()
    if compiled is None:
        return None
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    n, m, heading = len(poses), len(field.polygons), np.ascontiguousarray(poses[:, 2])
    apart = np.empty(n if least else (n, m))
    given = poses, np.cos(heading), np.sin(heading), np.array(body), body.corners, field.edges
    compiled.mcdas_polygon_separations(n, m, least, field.first, *given, apart)
    return apart
