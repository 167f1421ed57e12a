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

/* at s, which lies behind knot i */
static inline double heading_behind(const Frame *f, whole i, double s)
{
    if (s < f->at[0]) return f->heading[0] + (s - f->at[0]) * f->kappa[0];
    return f->heading[i] + 0.5 * (f->kappa[i] + value_behind(i, s, f->knots, f->at, f->kappa)) * (s - f->at[i]);
}

static double road_heading(const Frame *f, double s) { return heading_behind(f, knot_before(s, f->knots, f->at), s); }

/* where on the line one was last: behind which sample, and behind which knot */
typedef struct {
    whole sample, knot;
} Place;

static inline Place place_at(const Frame *f, double s)
{
    const Place place = {knot_before(s, f->samples - 1, f->s), knot_before(s, f->knots, f->at)};
    return place;
}

/* x, y, yaw of the line at s, which is tabulated, sought from a place on */
static inline void on_line(const Frame *f, double s, Place *place, double *x, double *y, double *yaw)
{
    static const double node[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
    static const double weight[4] = {0.34785484513745385, 0.6521451548625461, 0.6521451548625461, 0.34785484513745385};
    const whole low = place->sample = knot_beside(place->sample, s, f->samples - 1, f->s);
    const double half = 0.5 * (s - f->s[low]);
    double along = 0.0, across = 0.0;
    for (int k = 0; k < 4; k++) {
        const double there = f->s[low] + half * (1.0 + node[k]);
        const double theta = heading_behind(f, place->knot = knot_beside(place->knot, there, f->knots, f->at), there);
        along += weight[k] * cos(theta);
        across += weight[k] * sin(theta);
    }
    *x = f->x[low] + half * along;
    *y = f->y[low] + half * across;
    *yaw = heading_behind(f, place->knot = knot_beside(place->knot, s, f->knots, f->at), s);
}

/* x, y, yaw of (s, d, psi); 0 where s is not tabulated */
static int to_plane(const Frame *f, double s, double d, double psi, double *x, double *y, double *yaw)
{
    double theta;
    Place place;
    if (f->samples == 0) {
        *x = s;
        *y = d;
        *yaw = psi;
        return 1;
    }
    if (!(s >= f->s[0] && s <= f->s[f->samples - 1])) return 0;
    place = place_at(f, s);
    on_line(f, s, &place, x, y, &theta);
    *x -= d * sin(theta);
    *y += d * cos(theta);
    *yaw = psi + theta;
    return 1;
}

/* the samples among which a place is sought: from the first on, before the end */
typedef struct {
    whole first, end;
} Window;

static inline whole first_from(const Frame *f, double s)
{
    whole low = 0, high = f->samples;
    while (low < high) {
        const whole middle = (low + high) / 2;
        if (f->s[middle] < s) low = middle + 1; else high = middle;
    }
    return low;
}

static inline Window window_near(const Frame *f, double s)
{
    const Window window = {first_from(f, s - 300.0), first_from(f, s + 300.0)};
    return window;
}

/* s, d of (x, y), by Newton's method from the nearest of every eighth sample of a window: `FrenetFrame.to_road` of one place. 0 where there
   is no such sample, or that is not the foot of the perpendicular, though the line goes on */
static inline int to_road(const Frame *f, double x, double y, Window sought, double *s_out, double *d_out)
{
    const double low = f->samples ? f->s[0] : 0.0, high = f->samples ? f->s[f->samples - 1] : 0.0;
    double s = low, best = HUGE_VAL, px, py, theta, c, n, along, across;
    Place place;
    if (f->samples == 0) {
        *s_out = x;
        *d_out = y;
        return 1;
    }
    for (whole i = sought.first; i < sought.end; i += 8) {
        const double apart = (x - f->x[i]) * (x - f->x[i]) + (y - f->y[i]) * (y - f->y[i]);
        if (apart < best) best = apart, s = f->s[i];
    }
    place = place_at(f, s);
    for (int round = 0; round < 12; round++) {
        double step;
        on_line(f, s, &place, &px, &py, &theta);
        c = cos(theta), n = sin(theta);
        along = (x - px) * c + (y - py) * n;
        across = -(x - px) * n + (y - py) * c;
        step = along / GREATER(1.0 - across * value_behind(place.knot, s, f->knots, f->at, f->kappa), 0.1);
        s = LESSER(GREATER(s + step, low), high);
        if (fabs(step) < 1e-12) break;
    }
    on_line(f, s, &place, &px, &py, &theta);
    c = cos(theta), n = sin(theta);
    *s_out = s;
    *d_out = -(x - px) * n + (y - py) * c;
    return sought.first < sought.end && (fabs((x - px) * c + (y - py) * n) <= 0.01 || s <= low || s >= high);
}

#endif
