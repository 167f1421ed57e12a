/* The road's Frenet frame, as `geometry.frenet`, of one place at a time. */
#ifndef FRENET_H
#define FRENET_H
#include "curvature.h"

typedef struct {
    whole samples, knots;         /* no samples: a straight road */
    const double *s, *x, *y;      /* the tabulated reference line */
    const double *at, *kappa, *heading; /* of the knots */
} Frame;

/* from what `FrenetFrame.addresses` says: (3, samples) and (3, knots) */
static Frame frame_of(whole samples, const double *line, whole knots, const double *bends)
{
    const Frame frame = {samples, knots, line, line + samples, line + 2 * samples, bends, bends + knots, bends + 2 * knots};
    return frame;
}

static double road_curvature(const Frame *f, double s) { return curvature_at(s, f->knots, f->at, f->kappa); }

static double road_heading(const Frame *f, double s)
{
    const whole i = knot_before(s, f->knots, f->at);
    if (s < f->at[0]) return f->heading[0] + (s - f->at[0]) * f->kappa[0];
    return f->heading[i] + 0.5 * (f->kappa[i] + road_curvature(f, s)) * (s - f->at[i]);
}

/* x, y, yaw of (s, d, psi); 0 where s is not tabulated */
static int to_plane(const Frame *f, double s, double d, double psi, double *x, double *y, double *yaw)
{
    static const double node[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
    static const double weight[4] = {0.34785484513745385, 0.6521451548625461, 0.6521451548625461, 0.34785484513745385};
    const whole last = f->samples - 1;
    whole low;
    double half, theta, along = 0.0, across = 0.0;
    if (f->samples == 0) {
        *x = s;
        *y = d;
        *yaw = psi;
        return 1;
    }
    if (!(s >= f->s[0] && s <= f->s[last])) return 0;
    low = knot_before(s, last, f->s);
    half = 0.5 * (s - f->s[low]);
    for (int k = 0; k < 4; k++) {
        theta = road_heading(f, f->s[low] + half * (1.0 + node[k]));
        along += weight[k] * cos(theta);
        across += weight[k] * sin(theta);
    }
    theta = road_heading(f, s);
    *x = f->x[low] + half * along - d * sin(theta);
    *y = f->y[low] + half * across + d * cos(theta);
    *yaw = psi + theta;
    return 1;
}

#endif
