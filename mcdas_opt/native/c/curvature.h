/* What a road tells at knots (`Road.curvature_at`, `Edges`), of one place: linear in between, as at the first or the last one beyond. */
#ifndef CURVATURE_H
#define CURVATURE_H
#include "mcdas.h"

/* the last of the knots that is not beyond s, or the first one */
static inline whole knot_before(double s, whole knots, const double *at)
{
    whole low = 0, high = knots;
    while (high - low > 1) {
        const whole middle = (low + high) / 2;
        if (s >= at[middle]) low = middle; else high = middle;
    }
    return low;
}

/* the same, sought from knot i on */
static inline whole knot_beside(whole i, double s, whole knots, const double *at)
{
    while (i > 0 && s < at[i]) i--;
    while (i < knots - 1 && s >= at[i + 1]) i++;
    return i;
}

/* of values at knots the one at s, which lies behind knot i */
static inline double value_behind(whole i, double s, whole knots, const double *at, const double *value)
{
    if (s <= at[0]) return value[0];
    if (s >= at[knots - 1]) return value[knots - 1];
    return (value[i + 1] - value[i]) / (at[i + 1] - at[i]) * (s - at[i]) + value[i];
}

static inline double curvature_at(double s, whole knots, const double *at, const double *kappa)
{
    return value_behind(knot_before(s, knots, at), s, knots, at, kappa);
}

#endif
