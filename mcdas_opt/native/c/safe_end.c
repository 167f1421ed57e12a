/* What it would mean to end at a sample of a drive: `manoeuvres.safe_end.ends`, in its order of sums. */
#include "mcdas.h"

enum { S = 1, D = 2, PSI = 3, V = 4 };             /* rows of a trajectory's table */
enum { STANDING, SAFE, FRONT_FAILS, FOLLOWER_FAILS }; /* rows of what is found */

typedef struct {
    double length, width, start_s, start_v;        /* the host, and where the plan begins */
    double twice_own, twice_front, response;       /* `safe_end.Braking` */
    double follower_response, follower_demand;     /* what may be asked of who is behind */
    double settled, in_the_way, standing, rounding, rounding_demand;
} Rule;

static double to_hold(double v, double ahead, const Rule *of)
{
    ahead = GREATER(ahead, 0.0);
    return GREATER(v * of->response + v * v / of->twice_own - ahead * ahead / of->twice_front, 0.0);
}

static double demanded(double gap, double closing, const Rule *of)
{
    if (closing <= 0.0 && gap > 0.0) return 0.0;
    closing = GREATER(closing, 0.0);
    const double left = gap - closing * of->follower_response;
    return left > 0.0 ? closing * closing / (2.0 * left) : HUGE_VAL;
}

/* A drive (9, n), looked at from a sample on, m samples: how it is turned against the road and where its lane ends (m; null: as its
 * heading says, and nowhere). Bodies: s, d, v (bodies, n), what they take along and across (bodies, each m or 1), and where they are now,
 * how fast, and what they owe, which may be unknown (3, bodies). Found (4, m); margin and demand (2, m). */
PUBLIC void mcdas_ends(whole n, whole from, const double *table, const double *turned, const double *lane_end, whole bodies,
                       const double *s, const double *d, const double *v, whole each, const double *along, const double *across,
                       const double *now, const Rule *of, unsigned char *found, double *numbers)
{
    const whole m = n - from;
    for (whole i = 0; i < m; i++) {
        const double *host = table + from + i, own_s = host[S * n], own_d = host[D * n], own_v = host[V * n];
        const int standing = own_v <= of->standing;
        int front_fails = !standing && fabs(turned ? turned[i] : host[PSI * n]) > of->settled, follower_fails = 0;
        double margin = HUGE_VAL, demand = -HUGE_VAL;
        for (whole j = 0; j < bodies; j++) {
            const whole at = j * n + from + i, size = each ? j * m : j;
            if (!(fabs(d[at] - own_d) < 0.5 * (across[size + each * i] + of->width) + of->in_the_way)) continue;
            const double lengths = 0.5 * (along[size + each * i] + of->length), before = 0.5 * (along[size] + of->length);
            const double now_s = now[j], now_v = now[bodies + j], known = now[2 * bodies + j];
            if (s[at] >= own_s) {
                const double room = s[at] - own_s - lengths - to_hold(own_v, v[at], of);
                double owed = known == known ? known : 0.0;
                if (known != known && now_s > of->start_s)
                    owed = LESSER(now_s - of->start_s - before - to_hold(of->start_v, now_v, of), 0.0);
                margin = LESSER(margin, room);
                front_fails |= !standing && room < owed - of->rounding;
            } else {
                const double asked = demanded(own_s - s[at] - lengths, v[at] - own_v, of);
                double allowed = of->follower_demand;
                if (now_s < of->start_s)
                    allowed = GREATER(demanded(of->start_s - now_s - before, now_v - of->start_v, of), allowed);
                demand = GREATER(demand, asked);
                follower_fails |= asked > allowed + of->rounding_demand;
            }
        }
        if (lane_end) {
            const double room = lane_end[i] - own_s - 0.5 * of->length - to_hold(own_v, 0.0, of);
            margin = LESSER(margin, room);
            front_fails |= !standing && room < 0.0;
        }
        numbers[i] = margin;
        numbers[m + i] = demand;
        found[STANDING * m + i] = standing;
        found[SAFE * m + i] = !front_fails && !follower_fails;
        found[FRONT_FAILS * m + i] = front_fails;
        found[FOLLOWER_FAILS * m + i] = follower_fails;
    }
}
