/* Inputs driven over a horizon: `mcdas_opt.planning.roll_out`, operation by operation. The equations of motion, motion(), are generated
 * and stand before this text, which knows only their order: s d psi v a delta. Portable C99; nothing global is written. */

enum { S, D, PSI, V, A, DELTA, NX };

static double curvature(double s, int knots, const double *at, const double *kappa)
{
    int i = 0;
    if (s <= at[0]) return kappa[0];
    if (s >= at[knots - 1]) return kappa[knots - 1];
    while (s >= at[i + 1]) i++;
    return (kappa[i + 1] - kappa[i]) / (at[i + 1] - at[i]) * (s - at[i]) + kappa[i];
}

typedef struct {
    const double *u, *car, *at, *kappa;
    int knots;
} Road;

static void slope(const Road *on, const double *x, double *dx)
{
    const double kappa = curvature(x[S], on->knots, on->at, on->kappa);
    motion(0, x, on->u, &kappa, on->car, dx);
}

static void rk4(const Road *on, const double *x, double h, double *next)
{
    double k1[NX], k2[NX], k3[NX], k4[NX], y[NX];
    slope(on, x, k1);
    for (int i = 0; i < NX; i++) y[i] = x[i] + 0.5 * h * k1[i];
    slope(on, y, k2);
    for (int i = 0; i < NX; i++) y[i] = x[i] + 0.5 * h * k2[i];
    slope(on, y, k3);
    for (int i = 0; i < NX; i++) y[i] = x[i] + h * k3[i];
    slope(on, y, k4);
    for (int i = 0; i < NX; i++) next[i] = x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
}

/* first t > 0 at which v + a t + jerk t^2 / 2 falls through zero; infinite when it does not */
static double time_to_stop(double v, double a, double jerk)
{
    double best = HUGE_VAL;
    if (a >= 0.0 && jerk >= 0.0) return best;
    if (fabs(jerk) < 1e-12) return a < 0.0 ? v / -a : best;
    const double under = a * a - 2.0 * jerk * v;
    if (under <= 0.0) return best;
    for (int side = -1; side <= 1; side += 2) {
        const double t = (-a + side * sqrt(under)) / jerk;
        if (t > 0.0 && a + jerk * t < 0.0 && t < best) best = t;
    }
    return best;
}

/* x (nodes + 1, NX) with the start in its first row; u (nodes, 2) is zeroed where the car stands; planned speeds (nodes + 1) */
PUBLIC void mcdas_drive(int nodes, const double *h, const double *planned, double starts, const double *car, int knots, const double *at,
                        const double *kappa, double *u, double *x)
{
    for (int k = 0; k < nodes; k++, x += NX, u += 2) {
        double *next = x + NX;
        if (x[V] <= 1e-9 && x[A] <= 0.0 && planned[k + 1] < starts) {
            u[0] = u[1] = 0.0;
            memcpy(next, x, sizeof(double) * NX);
            next[A] = 0.0;
            continue;
        }
        const Road on = {u, car, at, kappa, knots};
        const double stop = time_to_stop(x[V], x[A], u[0]);
        rk4(&on, x, stop < h[k] ? stop : h[k], next);
        if (stop < h[k]) {
            next[V] = next[A] = 0.0;
            next[DELTA] += u[1] * (h[k] - stop);
        }
    }
}
