/* `Road.curvature_at` of one place: linear between knots, as at the first or the last one beyond them. */
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

static inline double curvature_at(double s, whole knots, const double *at, const double *kappa)
{
    const whole i = knot_before(s, knots, at);
    if (s <= at[0]) return kappa[0];
    if (s >= at[knots - 1]) return kappa[knots - 1];
    return (kappa[i + 1] - kappa[i]) / (at[i + 1] - at[i]) * (s - at[i]) + kappa[i];
}

#endif
