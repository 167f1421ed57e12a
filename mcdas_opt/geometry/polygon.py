"""Polygons: turn, simplicity, hull, and the cut into convex parts. Vertices (n, 2) in metres, counter-clockwise is positive."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array


def signed_area(vertices: Array) -> float:
    """Area [m^2], positive for a counter-clockwise polygon (shoelace formula, about the first vertex)."""
    x, y = (vertices - vertices[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def is_simple(vertices: Array) -> bool:
    """True when no two edges that are not neighbours meet."""
    n = len(vertices)
    p, q = vertices, np.roll(vertices, -1, axis=0)
    for i in range(n):
        for j in range(i + 2, n):
            if i == 0 and j == n - 1:
                continue
            if _segments_meet(p[i], q[i], p[j], q[j]):
                return False
    return True


def convex_hull(points: Array) -> Array:
    """Counter-clockwise hull without points on its edges (Andrew's monotone chain, 1979)."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered)

    def chain(sequence: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for point in sequence:
            while len(kept) >= 2 and _turn(kept[-2], kept[-1], point) <= 0.0:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def is_convex(vertices: Array) -> bool:
    """True for a convex polygon of either turn (points along an edge are allowed)."""
    edges = np.roll(vertices, -1, axis=0) - vertices
    after = np.roll(edges, -1, axis=0)
    cross = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
    small = 1e-9 * max(1.0, float(np.abs(edges).max()) ** 2)
    return bool(np.all(cross >= -small) or np.all(cross <= small))


def convex_parts(vertices: Array) -> list[Array]:
    """A simple counter-clockwise polygon as convex counter-clockwise parts that cover exactly it.

    Ears are cut off (Meisters 1975), then parts are joined again across a shared diagonal while the union stays convex
    (Hertel and Mehlhorn 1983).
    """
    if is_convex(vertices):
        return [vertices]
    parts = [[int(i) for i in triangle] for triangle in _ears(vertices)]
    joined = True
    while joined:
        joined = False
        for a in range(len(parts)):
            for b in range(a + 1, len(parts)):
                union = _union(parts[a], parts[b])
                if union is not None and is_convex(vertices[union]):
                    parts[a] = union
                    del parts[b]
                    joined = True
                    break
            if joined:
                break
    return [vertices[part] for part in parts]


def _ears(vertices: Array) -> list[tuple[int, int, int]]:
    rest = list(range(len(vertices)))
    triangles = []
    while len(rest) > 3:
        for k in range(len(rest)):
            a, b, c = rest[k - 1], rest[k], rest[(k + 1) % len(rest)]
            corner = (vertices[a], vertices[b], vertices[c])
            if _turn(*corner) <= 0.0:
                continue
            if not any(_inside(vertices[m], corner) for m in rest if m not in (a, b, c)):
                triangles.append((a, b, c))
                del rest[k]
                break
        else:  # only slivers are left: drop the flattest corner
            flat = min(
                range(len(rest)), key=lambda k: abs(_turn(vertices[rest[k - 1]], vertices[rest[k]], vertices[rest[(k + 1) % len(rest)]]))
            )
            del rest[flat]
    triangles.append((rest[0], rest[1], rest[2]))
    return triangles


def _union(a: list[int], b: list[int]) -> list[int] | None:
    """Two counter-clockwise index rings joined across the edge that they share, None when they share none."""
    for i in range(len(a)):
        edge = (a[i], a[(i + 1) % len(a)])
        for j in range(len(b)):
            if (b[(j + 1) % len(b)], b[j]) == edge:
                after_a = [a[(i + 1 + k) % len(a)] for k in range(len(a))]
                after_b = [b[(j + 1 + k) % len(b)] for k in range(len(b))]
                return after_a + after_b[1:-1]
    return None


def _turn(a: tuple[float, float] | Array, b: tuple[float, float] | Array, c: tuple[float, float] | Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _inside(point: Array, triangle: tuple[Array, Array, Array]) -> bool:
    a, b, c = triangle
    return _turn(a, b, point) >= 0.0 and _turn(b, c, point) >= 0.0 and _turn(c, a, point) >= 0.0


def _segments_meet(a: Array, b: Array, c: Array, d: Array) -> bool:
    return _turn(a, b, c) * _turn(a, b, d) < 0.0 and _turn(c, d, a) * _turn(c, d, b) < 0.0
