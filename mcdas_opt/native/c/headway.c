/* The headway that is asked of the host, and what is missing of it: `planning.headway`, in its order of sums. */
#include "mcdas.h"

typedef struct {
    double time_gap, standstill, opening;           /* that is asked for [s], [m], and how fast a gap opens up to it */
    double gentle, built_up, beginning, slowest;    /* how a host brakes that finds less */
} Headway;

/* At n times, of somebody who drives at `front`, up to whom there is `room` less so much: the time gap to keep [s]. */
static void asked(whole n, const double *t, const double *room, double less, const double *front, double v, const Headway *of,
                  double closing, double since, double *gap)
{
    double gone = 0.0, before = 0.0;
    for (whole k = 0; k < n; k++) {
        const double after = GREATER(t[k] - since, 0.0);
        const double slowest = t[k] < since ? v : LESSER(GREATER(front[k], 0.0), GREATER(v, 0.0));
        const double speed = GREATER(v - of->gentle * GREATER(after - of->built_up, 0.0), slowest);
        const double counted = GREATER(speed, front[k]);
        if (k > 0)
            gone += 0.5 * (counted + before) * (t[k] - t[k - 1]);
        before = counted;
        const double free = room[k] - less - gone - of->standstill - closing * GREATER(speed - front[k], 0.0);
        const double found = GREATER(free / GREATER(speed, of->slowest), 0.0);
        gap[k] = LESSER(of->time_gap, found + of->opening * after * after / (after + of->beginning));
    }
}

/* room, front, gap (bodies, n) */
PUBLIC void mcdas_time_gaps(whole bodies, whole n, const double *t, const double *room, const double *front, double v, const Headway *of,
                            double closing, double since, double *gap)
{
    for (whole j = 0; j < bodies; j++)
        asked(n, t, room + j * n, 0.0, front + j * n, v, of, closing, since, gap + j * n);
}

/* Of drives (drives, 9, n), the first row of each t: the most that is missing of the headway to anybody ahead, as a share (drives, n).
 * `host` is s, d, speed now; `halves` (bodies, 2) of both cars together, along and across; s, d, v and work (bodies, n). */
PUBLIC void mcdas_missing_headway(whole drives, whole bodies, whole n, const double *tables, const double *host, const double *halves,
                                  const double *s, const double *d, const double *v, const Headway *of, double *work, double *missing)
{
    for (whole j = 0; j < bodies; j++) {
        double *gap = work + j * n;
        if (fabs(d[j * n] - host[1]) < halves[2 * j + 1]) {
            for (whole k = 0; k < n; k++)
                gap[k] = s[j * n + k] - host[0];
            asked(n, tables, gap, halves[2 * j], v + j * n, host[2], of, 0.0, 0.0, gap);
        } else
            for (whole k = 0; k < n; k++)
                gap[k] = of->time_gap;
    }
    for (whole i = 0; i < drives; i++) {
        const double *own_s = tables + (9 * i + 1) * n, *own_d = own_s + n, *own_v = own_s + 3 * n;
        for (whole k = 0; k < n; k++) {
            double most = 0.0;
            for (whole j = 0, at = k; j < bodies; j++, at += n)
                if (fabs(d[at] - own_d[k]) < halves[2 * j + 1] && s[at] > own_s[k]) {
                    const double wanted = of->standstill + work[at] * GREATER(own_v[k], 0.0);
                    const double share = 1.0 - (s[at] - own_s[k] - halves[2 * j]) / wanted;
                    most = GREATER(most, LESSER(share, 1.0));
                }
            *missing++ = most;
        }
    }
}
