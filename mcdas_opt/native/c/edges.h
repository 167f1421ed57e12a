/* The edges of a road that are not the same all along, (3, count): s, left, right of knots; as `domain.lane_borders.Edges`. */
#ifndef EDGES_H
#define EDGES_H
#include "curvature.h"

typedef struct {
    const double *table;
    whole count; /* 0: the edges are numbers */
} Edges;

/* how far a body is beyond an edge whose flanks are at `left` and `right`, from its tail to its nose `half` before and behind s */
static inline double beyond_edges(const Edges *e, double s, double half, double left, double right)
{
    double most = -HUGE_VAL;
    for (int i = -1; i <= 1; i++) {
        const double at = s + i * half;
        const whole k = knot_before(at, e->count, e->table);
        const double over = left - value_behind(k, at, e->count, e->table, e->table + e->count);
        const double under = value_behind(k, at, e->count, e->table, e->table + 2 * e->count) - right;
        most = GREATER(most, over);
        most = GREATER(most, under);
    }
    return most;
}

#endif
