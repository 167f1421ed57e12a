/* `Road.curvature_at` of one place: linear between knots, as at the first or the last one beyond them. */
#ifndef CURVATURE_H
#define CURVATURE_H
#include "mcdas.h"

static inline double curvature_at(double s, whole knots, const double *at, const double *kappa)
{
    whole i = 0;
    if (s <= at[0]) return kappa[0];
    if (s >= at[knots - 1]) return kappa[knots - 1];
    while (s >= at[i + 1]) i++;
    return (kappa[i + 1] - kappa[i]) / (at[i + 1] - at[i]) * (s - at[i]) + kappa[i];
}

#endif
