/* Inputs driven over a horizon (`mcdas_opt.planning.roll_out`) and a path followed (`mcdas_opt.actuation.path_following`),
 * operation by operation. */
#include "curvature.h"

#define HELD 1e-6 /* `planning.roll_out` [m/s^2] */

enum { S, D, PSI, V, A, DELTA, NX };
enum { WHEELBASE, CENTRE, INSET }; /* of a car; the last where a path is followed */

typedef struct {
    const double *u, *car, *at, *kappa;
    whole knots;
} Road;

/* `dynamics.bicycle.road_bicycle` */
static void slope(const Road *on, const double *x, double *dx)
{
    const double kappa = curvature_at(x[S], on->knots, on->at, on->kappa), cosine = cos(x[PSI]), sine = sin(x[PSI]);
    const double turn = tan(x[DELTA]) / on->car[WHEELBASE], aside = on->car[CENTRE] * turn;
    dx[S] = x[V] * (cosine - aside * sine) / (1.0 - x[D] * kappa);
    dx[D] = x[V] * (sine + aside * cosine);
    dx[PSI] = x[V] * turn - kappa * dx[S];
    dx[V] = x[A];
    dx[A] = on->u[0];
    dx[DELTA] = on->u[1];
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

/* one step; where the car stops within it, the brakes hold it */
static void step(const Road *on, const double *x, double h, double *next)
{
    const double stop = time_to_stop(x[V], x[A], on->u[0]);
    rk4(on, x, stop < h ? stop : h, next);
    if (stop < h) {
        next[V] = next[A] = 0.0;
        next[DELTA] += on->u[1] * (h - stop);
    }
}

/* x (nodes + 1, NX) with the start in its first row; planned speeds (nodes + 1); road (2, knots). u (nodes, 2) comes back as it is driven:
 * a car that stands has no jerk, and steers only if it drives off later; where it drives off, the jerk is what brings it to the
 * acceleration that the inputs meant by then, as far as the car can. */
PUBLIC void mcdas_drive(whole nodes, const double *h, const double *planned, double starts, const double *car, whole knots,
                        const double *road, double *u, double *x)
{
    double meant = x[V] <= 1e-9 ? GREATER(x[A], 0.0) : x[A]; /* acceleration, by the inputs so far */
    whole leaves = nodes;
    while (leaves > 0 && planned[leaves] < starts) leaves--;
    for (whole k = 0; k < nodes; k++, x += NX, u += 2) {
        double *next = x + NX;
        const int stands = x[V] <= 1e-9 && x[A] <= 0.0;
        const double jerk = u[0] + (meant - x[A]) / h[k];
        meant += u[0] * h[k];
        if (stands && (planned[k + 1] < starts || jerk <= 0.0)) {
            u[0] = 0.0;
            if (k >= leaves) u[1] = 0.0;
            memcpy(next, x, sizeof(double) * NX);
            next[A] = 0.0;
            next[DELTA] += u[1] * h[k];
            continue;
        }
        if (stands) u[0] = LESSER(jerk, car[2]);
        if (x[A] < 0.0 && x[A] + u[0] * h[k] >= 0.0 && time_to_stop(x[V], x[A], u[0]) < h[k]) u[0] = -(x[A] + HELD) / h[k];
        const Road on = {u, car, road, road + knots, knots};
        step(&on, x, h[k], next);
    }
}

typedef struct {
    double start_s, start_d, amplitude, a, b, bend, bend_s, bend_width;
} Path;

/* d(s) and its first two derivatives: `reference.offset_path` */
static void path_at(const Path *p, double s, double out[3])
{
    const double x = s - p->start_s, z = s - p->bend_s, length = -2.0 * log(p->b) / p->a, gain = (p->b + 1.0) / (p->b - 1.0);
    const double on = LESSER(GREATER(x, 0.0), length), shape = 0.5 * (1.0 - tanh(0.5 * (p->a * on + log(p->b))));
    const double w2 = p->bend_width * p->bend_width, h = p->bend * exp(-(z / p->bend_width) * (z / p->bend_width));
    const double h1 = -2.0 * z / w2 * h, h2 = (4.0 * z * z / w2 - 2.0) / w2 * h, level = p->amplitude + h;
    double r = x > length ? 1.0 : 0.0, r1 = 0.0, r2 = 0.0;
    if (x >= 0.0 && x <= length) {
        r = (shape - 1.0 / (1.0 + p->b)) * (p->b + 1.0) / (p->b - 1.0);
        r1 = -gain * p->a * shape * (1.0 - shape);
        r2 = gain * p->a * p->a * shape * (1.0 - shape) * (1.0 - 2.0 * shape);
    }
    out[0] = p->start_d + r * level;
    out[1] = r1 * level + r * h1;
    out[2] = r2 * level + 2.0 * r1 * h1 + r * h2;
}

typedef struct {
    double lateral, grip, bandwidth, preview;                        /* bounds and bandwidth of the following */
    double steering, rate, jerk_min, jerk_max, slowest, fastest;     /* the car's limits, as far as they are used */
    double halting;                                                  /* (braking)^2 over speed from which the car still comes to rest [m/s^3] */
} Law;

static double bounded(double low, double value, double high) { return LESSER(GREATER(value, low), high); }

static double steering_rate(const double *x, const Path *path, double kappa, const double *car, const Law *law, double h)
{
    const double wheelbase = car[WHEELBASE], speed = GREATER(x[V], 2.0), w = law->bandwidth;
    double here[3], ahead[3];
    path_at(path, x[S], here);
    path_at(path, x[S] + x[V] * law->preview, ahead);
    const double offset = x[D] - here[0] - car[INSET] * kappa, heading = x[PSI] - atan(here[1]) + car[CENTRE] * kappa;
    double wanted = kappa * cos(x[PSI]) / (1.0 - x[D] * kappa) + ahead[2] / pow(1.0 + ahead[1] * ahead[1], 1.5);
    wanted -= w / speed * (w / speed) * offset + 2.0 * w / speed * heading;
    const double slow = GREATER(x[V], 0.1), most = LESSER(law->lateral / (slow * slow), tan(law->steering) / wheelbase);
    const double target = atan(wheelbase * bounded(-most, wanted, most));
    return x[V] < 0.05 ? 0.0 : bounded(-law->rate, (target - x[DELTA]) / h, law->rate);
}

/* Who drives, as a list of numbers: its kind, then what that kind needs */
enum { APPROACH, STEADY, REACTION, FOLLOWING };

/* towards a speed, with at most an acceleration, from a time on */
static double approach(const double *driver, double v, double t, const Law *law, double h)
{
    const double gap = driver[0] - v, easing = gap > 0.0 ? -law->jerk_min : law->jerk_max;
    if (t < driver[2] - 1e-9) return 0.0;
    return copysign(LESSER(driver[1], LESSER(sqrt(1.6 * easing * fabs(gap)), fabs(gap) / (2.0 * h))), gap);
}

/* `baselines.competent_driver`: since, until, strength, reaction, release, jerk */
static double reaction(const double *driver, double v, double t)
{
    const double pressed = driver[0] + t - driver[3];
    if (v <= driver[1]) return 0.0;
    if (pressed < -1e-9) return -driver[4];
    return -LESSER(GREATER(driver[5] * pressed, driver[4]), driver[2]);
}

/* `dynamics.car_following`, behind the most demanding of several: desired speed, headway, acceleration, deceleration, exponent, jam
 * distance, braking limit, how many, and of each the place, the speed and half the lengths of both cars */
static double following(const double *driver, double s, double v, double t)
{
    const int count = (int)driver[7];
    const double *other = driver + 8;
    double least = HUGE_VAL;
    for (int k = 0; k < (count > 0 ? count : 1); k++, other += 3) {
        double crowd = 0.0;
        if (count > 0) {
            const double gap = other[0] + other[1] * t - s - other[2];
            const double urgency = v * (v - other[1]) / (2.0 * sqrt(driver[2] * driver[3]));
            const double wanted = driver[5] + GREATER(v * driver[1] + urgency, 0.0);
            crowd = pow(wanted / GREATER(gap, 0.01), 2.0);
        }
        const double asked = driver[2] * (1.0 - pow(v / driver[0], driver[4]) - crowd);
        least = LESSER(least, GREATER(asked, -driver[6]));
    }
    return least;
}

/* what the driver asks for; who is not eased by its own law is eased where it would brake beyond standstill */
static double asked(const double *driver, const double *x, double t, const Law *law, double h)
{
    const double v = x[V];
    double a = 0.0;
    if (driver[0] == APPROACH) return approach(driver + 1, v, t, law, h);
    if (driver[0] == STEADY) a = v > driver[2] ? -driver[1] : 0.0;
    if (driver[0] == REACTION) a = reaction(driver + 1, v, t);
    if (driver[0] == FOLLOWING) a = following(driver + 1, x[S], v, t);
    if (a >= 0.0) return a;
    return GREATER(a, v <= 0.0 ? -v / (2.0 * h) : -LESSER(sqrt(law->halting * v), v / (3.0 * h)));
}

static double jerk(const double *x, double wanted, double wheelbase, const Law *law, double h)
{
    const double lateral = x[V] * x[V] * tan(x[DELTA]) / wheelbase, room = sqrt(GREATER(law->grip * law->grip - lateral * lateral, 0.0));
    wanted = GREATER(law->slowest, GREATER(-room, LESSER(law->fastest, LESSER(room, wanted))));
    return bounded(law->jerk_min, (wanted - x[A]) / h, law->jerk_max);
}

/* x (steps + 1, NX) with the start in its first row, u (steps, 2): what the following law makes of a path and a driver */
PUBLIC void mcdas_follow(whole steps, double h, const double *car, whole knots, const double *road, const double *path, const double *law,
                         const double *driver, double *u, double *x)
{
    Path way;
    Law rule;
    memcpy(&way, path, sizeof way);
    memcpy(&rule, law, sizeof rule);
    for (whole k = 0; k < steps; k++, x += NX, u += 2) {
        const Road on = {u, car, road, road + knots, knots};
        u[1] = steering_rate(x, &way, curvature_at(x[S], knots, road, road + knots), car, &rule, h);
        u[0] = jerk(x, asked(driver, x, k * h, &rule, h), car[WHEELBASE], &rule, h);
        step(&on, x, h, x + NX);
    }
}
