/* Who comes within the host's reach: `planning.reach.in_reach`, in its order of sums. */
#include "mcdas.h"

typedef struct {
    double s, v, length;                        /* of the host now [m], [m/s] */
    double brake, rate, top;                    /* the strongest that it brakes and accelerates with, up to which speed */
    double standstill, time_gap, closing;       /* what counts as near */
    double stretch;                             /* of a distance along the road */
} Reach;

/* s, v (bodies, n) at times t; near (bodies): 1 of who comes within reach at one of them, else 0 */
PUBLIC void mcdas_in_reach(whole bodies, whole n, const double *t, const double *s, const double *v, const double *lengths, const Reach *of,
                           unsigned char *near)
{
    for (whole j = 0; j < bodies; j++, s += n, v += n) {
        const double bodily = 0.5 * (lengths[j] + of->length) + of->standstill;
        near[j] = 0;
        for (whole k = 0; k < n && !near[j]; k++) {
            const double slowest = GREATER(of->v - of->brake * t[k], 0.0), fastest = LESSER(of->v + of->rate * t[k], of->top);
            const double stopping = LESSER(t[k], of->v / of->brake), rising = LESSER(t[k], (of->top - of->v) / of->rate);
            const double low = of->s + stopping * (of->v - 0.5 * of->brake * stopping);
            const double high = of->s + rising * (of->v + 0.5 * of->rate * rising) + of->top * (t[k] - rising);
            const double apart = bodily + of->stretch * fabs(s[k] - of->s);
            const double ahead = apart + of->time_gap * fastest + of->closing * GREATER(fastest - v[k], 0.0);
            const double behind = apart + of->closing * GREATER(v[k] - slowest, 0.0);
            near[j] = s[k] - high < ahead && low - s[k] < behind;
        }
    }
}
