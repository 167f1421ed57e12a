/* From the road into the plane and back: `FrenetFrame`, of many places. */
#include "frenet.h"

/* s, d of points (n), sought within 300 m of `near`, where the last one is again where it was found; how many are not found */
PUBLIC whole mcdas_to_road(whole n, const double *x, const double *y, double near, whole samples, const double *line, whole knots,
                           const double *bends, double *s, double *d)
{
    const Frame frame = frame_of(samples, line, knots, bends);
    const Window sought = window_near(&frame, near);
    whole lost = 0;
    for (whole i = 0; i < n; i++) {
        if (i > 0 && x[i] == x[i - 1] && y[i] == y[i - 1]) s[i] = s[i - 1], d[i] = d[i - 1];
        else if (!to_road(&frame, x[i], y[i], sought, s + i, d + i)) lost++;
    }
    return lost;
}

/* x, y, yaw of (s, d, psi), each (n); how many lie beyond what is tabulated */
PUBLIC whole mcdas_to_plane(whole n, const double *s, const double *d, const double *psi, whole samples, const double *line, whole knots,
                            const double *bends, double *x, double *y, double *yaw)
{
    const Frame frame = frame_of(samples, line, knots, bends);
    whole beyond = 0;
    for (whole i = 0; i < n; i++) beyond += !to_plane(&frame, s[i], d[i], psi[i], x + i, y + i, yaw + i);
    return beyond;
}
