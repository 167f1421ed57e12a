/* What takes most of the time, for one row (one manoeuvre from one start) after the other: the motion of an evasive profile, operation by
 * operation as the array operations have it. Rows are worked out from node to node, whole LANES at a time (they are padded with the last
 * node), so that one that goes wrong early needs no more. */

enum { S, D, HEADING, SPEED, ACCELERATION, STEERING, STATES };

typedef struct {
    const double *others_s, *others_d, *others_mps, *half_length, *half_width; /* (bodies, lattice) */
    const double *longest, *rightmost, *leftmost;    /* (bodies): the greatest half length; where its sides are at most, on the lattice */
    const double *table;                            /* (STATES, moments): the host under constant inputs */
    const double *level, *until, *until_mps, *target, *lateral;
    const double *knots, *kappas, *edges;
    whole bodies, lattice, moments, members, in_lane, half_steps, count_of_knots, count_of_edges;
    double wheelbase, centre, length, width, jerk_min, jerk_max, speed_max, steering_max, steering_rate;
    double limit, steering_share, brake, accelerate, left, right, end, bend, clear_m, clear_s, comfort, shortest, straightening;
} Case;

/* the nodes of a row: steps of the lattice and seconds, padded to n; `runs` of steps as long as each other, each until a node */
typedef struct {
    const whole *steps, *until;
    const double *times, *step;
    whole n, last, middle, runs;
} Nodes;

/* a second derivative as ramps on top of one another, each from its begin on, for as long as it lasts */
typedef struct {
    double begin[4], lasting[4], rate[4];
} Ramps;

/* A lane-change profile, by the clock or by the way: where it begins, its first two derivatives there, what is added; whether there is one */
typedef struct {
    int timed, fits;
    double d, rate, curl;
    Ramps ramps;
} Profile;

typedef struct {
    double v[ROOM], a[ROOM], way[ROOM], d[ROOM], sine[ROOM], cosine[ROOM], curvature[ROOM], ratio[ROOM], s[ROOM], tangent[ROOM], kappa[ROOM];
    double steep[LANES], squared[LANES], tangents[LANES], left[LANES], right[LANES]; /* the most so far, lane by lane */
    double s0, rear_s, turn, sine_of_turn, cosine_of_turn, rate;
    int wide;
    double demand, ability, edge, beyond;
} Motion;

OUT_OF_LINE static double curvature(const Case *q, double s) { return curvature_at(s, q->count_of_knots, q->knots, q->kappas); }

/* the same of places one after the other: behind which knot the last one lies is kept */
static inline double curvature_on(const Case *q, double s, whole *knot)
{
    *knot = knot_beside(*knot, s, q->count_of_knots, q->knots);
    return value_behind(*knot, s, q->count_of_knots, q->knots, q->kappas);
}

/* how far a body here is beyond edges that change along the road */
OUT_OF_LINE static double beyond_here(const Case *q, double s, double d, double sine, double cosine)
{
    const Edges edges = {q->edges, q->count_of_edges};
    const double room = 0.5 * (q->width * cosine + q->length * fabs(sine));
    return beyond_edges(&edges, s, 0.5 * q->length, d + room, d - room);
}

static double sign(double x) { return (double)((x > 0.0) - (x < 0.0)); }

static double most_of(const double *lanes)
{
    double most[LANES / 2];
    for (int j = 0; j < LANES / 2; j++) most[j] = GREATER(lanes[j], lanes[j + LANES / 2]);
    for (int half = LANES / 4; half; half /= 2)
        for (int j = 0; j < half; j++) most[j] = GREATER(most[j], most[j + half]);
    return most[0];
}

static double least_of_lanes(const double *lanes)
{
    double low[LANES / 2];
    for (int j = 0; j < LANES / 2; j++) low[j] = LESSER(lanes[j], lanes[j + LANES / 2]);
    for (int half = LANES / 4; half; half /= 2)
        for (int j = 0; j < half; j++) low[j] = LESSER(low[j], low[j + half]);
    return low[0];
}

static inline void ramp(double z, double begin, double lasting, double rate, double *second, double *first, double *sum)
{
    const double from = z - begin, u = GREATER(from, 0.0), c = LESSER(u, lasting), over = u - c, rest = lasting * over;
    *second += rate * c;
    *first += rate * (0.5 * (c * c) + rest);
    *sum += rate * (c * c * (c * (1.0 / 6.0)) + 0.5 * (rest * (over + lasting)));
}

/* speed, acceleration and way at times z (n) of a row that begins with v0 and a0 */
static inline void pace(const Case *q, double level, double until, int n, const double *restrict z, double v0, double a0,
                        double *restrict v, double *restrict a, double *restrict way)
{
    const double rise = SHARE * q->jerk_max, fall = SHARE * q->jerk_min;
    const double up = level >= a0 ? rise : fall, down = level > 0.0 ? fall : rise;
    const double built = (level - a0) / up, top = GREATER(SHARE * q->speed_max, v0), ended = GREATER(until, built), lasting = -level / down;
    int stands = 0, beyond = 0;
    for (int t = 0; t < n; t++) {
        double f2 = a0, f1 = v0 + a0 * z[t], f0 = 0.0 + (v0 + 0.5 * a0 * z[t]) * z[t];
        ramp(z[t], 0.0, built, up, &f2, &f1, &f0);
        ramp(z[t], ended, lasting, down, &f2, &f1, &f0);
        a[t] = f2;
        v[t] = f1;
        way[t] = f0;
        stands |= f1 <= 0.0;
        beyond |= f1 > top;
    }
    if (stands) {
        stands = 0;
        for (int t = 0; t < n; t++) {
            stands |= v[t] <= 0.0;
            if (stands) v[t] = a[t] = 0.0;
            if (t) way[t] = GREATER(way[t], way[t - 1]);
        }
    }
    if (beyond)
        for (int t = 0; t < n; t++) {
            if (v[t] > top) {
                v[t] = top;
                a[t] = 0.0;
            }
            if (t) way[t] = way[t - 1] + 0.5 * (v[t] + v[t - 1]) * (z[t] - z[t - 1]);
        }
}

/* the state that a row begins in, and what follows of it for the rear axle */
typedef struct {
    double x[STATES], sine0, d0, s0, bend0;
} Begin;

static void begin_at(const Case *q, whole start, Begin *b)
{
    whole before = start / CONSTANT_STEPS;
    if (before > q->moments - 2) before = q->moments - 2;
    const double share = (double)start / CONSTANT_STEPS - (double)before, c = q->centre;
    double *x = b->x;
    for (int i = 0; i < STATES; i++) {
        const double *row = q->table + i * q->moments + before;
        x[i] = row[0] + share * (row[1] - row[0]);
    }
    const double kappa = q->bend > 0.0 ? curvature(q, x[S]) : 0.0, psi = x[HEADING] + kappa * c, cosine = cos(psi);
    b->sine0 = sin(psi);
    b->d0 = x[D] - c * b->sine0 + 0.5 * kappa * (c * cosine) * (c * cosine);
    b->s0 = x[S] - c * cosine / (1.0 - kappa * b->d0);
    b->bend0 = (tan(x[STEERING]) / q->wheelbase - kappa * cosine / (1.0 - kappa * b->d0)) * cosine;
}

/* the profile to `target` (NAN: to straighten up) of a row that begins with v0 and a0 and is as slow as `slow` in its first second */
static Profile profile(const Case *q, double level, double target, double lateral, double slow, double v0, double a0, const Begin *b)
{
    const int timed = target == target;
    const double d0 = b->d0, sine0 = b->sine0, bend0 = b->bend0;
    const double at_least = GREATER(v0, 1.0), rate0 = timed ? v0 * sine0 : sine0, curl0 = timed ? a0 * sine0 + v0 * v0 * bend0 : bend0;
    const double turning = SHARE * q->steering_rate / q->wheelbase;
    double peak = timed ? lateral : LESSER(lateral / (at_least * at_least), CURVIEST_1PM);
    double jerk = timed ? turning * slow * slow : LESSER(peak / (GENTLE_S * at_least), turning / at_least);
    const double undoing = timed ? jerk : 0.5 * turning / at_least, ends = fabs(curl0) / undoing;
    double u = rate0 + 0.5 * curl0 * ends, left = timed ? target - (d0 + (rate0 + curl0 * ends / 3.0) * ends) : 0.0;
    const double way = left - 0.5 * u * fabs(u) / peak >= 0.0 ? 1.0 : -1.0;
    u *= way;
    left *= way;
    const double far = GREATER(fabs(left), LEAST_M), shorter = 2.0 * cbrt(0.5 * far / jerk), arc = sqrt(far / peak);
    const double fast = far / GREATER(arc, shorter) * (timed ? 1.0 / slow : 0.0), quick = LESSER(fast, STEEPEST);
    const double upright = sqrt(1.0 - quick * quick);
    jerk *= upright;
    peak = GREATER(peak * upright - (timed ? fabs(level) * quick : 0.0), 0.1 * peak);
    const double most = timed ? jerk * cbrt(0.5 * far / jerk) : sqrt(GREATER(fabs(u), 1e-9) * jerk);
    peak = LESSER(peak, most);
    double rising = 0.0, out = 0.0, back = 0.0;
    int fits = 0;
    for (int round = 0; round < ROUNDS && !fits; round++) {
        rising = peak / jerk;
        const double half = 0.5 * (2.0 * u - peak * rising);
        const double under = half * half - 0.5 * u * u + 0.5 * peak * rising * u + peak * left;
        out = (-half + sqrt(GREATER(under, 0.0))) / peak;
        back = out + u / peak;
        const double briefer = LESSER(out, back);
        fits = !timed || briefer >= 2.0 * rising - 1e-9;
        if (!fits) peak = GREATER(0.49 * jerk * briefer, 0.3 * peak);
    }
    const double up = timed ? way * jerk : sign(u) * way * jerk, turn = timed ? ends + out - rising : ends;
    const double done = timed ? ends + out + back - rising : ends + fabs(u) / peak;
    const Profile p = {timed, fits, d0, rate0, curl0, {{0.0, ends, turn, done}, {ends, rising, timed ? 2.0 * rising : rising, rising},
                        {-sign(curl0) * undoing, timed ? up : 0.0, -up, up}}};
    return p;
}

/* across the road, from one node on until another: place, sine and cosine of the heading, curvature */
static inline void across(const Profile *p, const int timed, int from, int to, const double *restrict z, Motion *restrict m)
{
    const double *begin = p->ramps.begin, *lasting = p->ramps.lasting, *rate = p->ramps.rate;
    for (int t = from; t < to; t += LANES)
        for (int j = t; j < t + LANES; j++) {
            double f2 = p->curl, f1 = p->rate + p->curl * z[j], f0 = p->d + (p->rate + 0.5 * p->curl * z[j]) * z[j];
            ramp(z[j], begin[0], lasting[0], rate[0], &f2, &f1, &f0);
            ramp(z[j], begin[1], lasting[1], rate[1], &f2, &f1, &f0);
            ramp(z[j], begin[2], lasting[2], rate[2], &f2, &f1, &f0);
            ramp(z[j], begin[3], lasting[3], rate[3], &f2, &f1, &f0);
            const double per_way = timed ? 1.0 / GREATER(m->v[j], SLOWEST_MPS) : 1.0, raw = f1 * per_way, steep = fabs(raw);
            const double capped = LESSER(raw, STEEPEST), sine = GREATER(capped, -STEEPEST), cosine = sqrt(1.0 - sine * sine);
            m->d[j] = f0;
            m->sine[j] = sine;
            m->cosine[j] = m->ratio[j] = cosine;
            m->curvature[j] = (f2 - (timed ? m->a[j] : 0.0) * sine) * per_way * per_way / cosine;
            m->steep[j - t] = GREATER(m->steep[j - t], steep);
        }
}

/* the way of the rear axle along the road, from what a metre of it takes off the road's */
static void along(int from, int to, Motion *restrict m)
{
    double gained[ROOM], s = m->rear_s;
    const int first = from ? from : 1;
    for (int t = first; t < to; t++) gained[t] = 0.5 * (m->way[t] - m->way[t - 1]) * (m->ratio[t] + m->ratio[t - 1]);
    if (!from) m->s[0] = s;
    for (int t = first; t < to; t++) m->s[t] = s += gained[t];
    m->rear_s = s;
}

static double greatest(int n, const double *x)
{
    double most = x[0];
    for (int t = 1; t < n; t++) most = GREATER(most, x[t]);
    return most;
}

/* the most that the steering turns in a second, from the tangents of its angle: of steps as long as each other the longest turn counts */
static void turning(const Nodes *c, int from, int to, Motion *restrict m)
{
    double turned[ROOM];
    const double *tangent = m->tangent;
    int wide = 0;
    for (int t = from ? from : 1; t < to; t++) {
        const double under = 1.0 + tangent[t] * tangent[t - 1];
        turned[t] = fabs(tangent[t] - tangent[t - 1]) / under;
        wide |= under <= 0.0;
    }
    m->wide |= wide;
    for (whole r = 0, begin = 1; r < c->runs; begin = c->until[r++]) {
        const int first = (int)GREATER(begin, from), end = (int)LESSER(c->until[r], to);
        if (first >= end) continue;
        const double run = greatest(end - first, turned + first);
        if (run <= m->rate * c->step[r]) continue; /* an angle is no greater than its tangent */
        const double rate = atan(run) / c->step[r];
        m->rate = GREATER(m->rate, rate);
    }
}

/* the same where an angle turns by a right one in a step */
static double turning_widely(const Nodes *c, const double *tangent)
{
    double most = 0.0;
    for (int t = 1; t < c->n && c->times[t] > c->times[t - 1]; t++)
        most = GREATER(most, fabs(atan(tangent[t]) - atan(tangent[t - 1])) / (c->times[t] - c->times[t - 1]));
    return most;
}

static void start_out(double s0, Motion *m)
{
    m->s0 = m->rear_s = s0;
    m->turn = m->sine_of_turn = m->rate = 0.0;
    m->cosine_of_turn = 1.0;
    m->wide = 0;
    m->beyond = -INFINITY;
    for (int j = 0; j < LANES; j++) {
        m->steep[j] = m->squared[j] = m->tangents[j] = 0.0;
        m->left[j] = -INFINITY;
        m->right[j] = INFINITY;
    }
}

/* The motion on from one node until another, whose speed and way stand there already: places and headings of the body, and what they ask of
 * the car. With `brief` it returns 0 as soon as that is beyond the car, or asks the tyres for more than `most`: where the body is comes last. */
static int driven(const Case *q, const Profile *p, const Nodes *e, int from, int to, int brief, double most, Motion *restrict m)
{
    const double c = q->centre;
    if (p->timed)
        across(p, 1, from, to, e->times, m);
    else
        across(p, 0, from, to, m->way, m);
    if (q->bend > 0.0) {
        whole knot = knot_before(m->s0 + m->way[from], q->count_of_knots, q->knots);
        for (int t = from; t < to; t++) m->kappa[t] = curvature_on(q, m->s0 + m->way[t], &knot);
        for (int t = from; t < to; t++) m->ratio[t] /= 1.0 - m->kappa[t] * m->d[t];
        along(from, to, m);
        for (int t = from; t < to; t++) m->kappa[t] = curvature_on(q, m->s[t], &knot);
        for (int t = from; t < to; t++) m->curvature[t] += m->kappa[t] * m->cosine[t] / (1.0 - m->kappa[t] * m->d[t]);
    }
    for (int t = from; t < to; t += LANES)
        for (int j = t; j < t + LANES; j++) {
            const double sideways = m->v[j] * m->v[j] * m->curvature[j], squared = m->a[j] * m->a[j] + sideways * sideways;
            const double tangent = m->tangent[j] = q->wheelbase * m->curvature[j], bare = fabs(tangent);
            m->squared[j - t] = GREATER(m->squared[j - t], squared);
            m->tangents[j - t] = GREATER(m->tangents[j - t], bare);
        }
    m->demand = sqrt(most_of(m->squared));
    double used = GREATER(m->demand / q->limit, most_of(m->steep) / STEEPEST);
    if (brief && (m->demand > most || used > 1.0)) return 0;
    turning(e, from, to, m);
    const int done = to == e->n;
    if (m->wide && done) m->rate = turning_widely(e, m->tangent);
    const double angle = atan(most_of(m->tangents)) / (q->steering_share * q->steering_max);
    used = GREATER(used, angle);
    if (!m->wide || done) used = GREATER(used, m->rate / (q->steering_share * q->steering_rate));
    m->ability = p->fits ? 1.0 - used : -1.0;
    if (brief && !(m->ability >= 0.0)) return 0;
    if (q->bend > 0.0) { /* turned by kappa c, whose sine and cosine are worked out anew only where the bend changes */
        double sines[ROOM], cosines[ROOM];
        for (int t = from; t < to; t++) {
            const double turn = m->kappa[t] * c;
            if (turn != m->turn) m->turn = turn, m->sine_of_turn = sin(turn), m->cosine_of_turn = cos(turn);
            sines[t] = m->sine_of_turn;
            cosines[t] = m->cosine_of_turn;
        }
        for (int t = from; t < to; t++) {
            const double kappa = m->kappa[t], stretch = 1.0 - kappa * m->d[t], cosine = m->cosine[t], sine = m->sine[t];
            m->s[t] += c * cosine / stretch;
            m->d[t] += c * sine - 0.5 * kappa * (c * cosine) * (c * cosine);
            m->sine[t] = sine * cosines[t] - cosine * sines[t];
            m->cosine[t] = cosine * cosines[t] + sine * sines[t];
        }
    } else {
        along(from, to, m);
        for (int t = from; t < to; t++) {
            m->s[t] += c * m->cosine[t];
            m->d[t] += c * m->sine[t];
        }
    }
    for (int t = from; t < to; t += LANES)
        for (int j = t; j < t + LANES; j++) {
            const double wide = 0.5 * (q->width * m->cosine[j] + q->length * fabs(m->sine[j])), left = m->d[j] + wide, right = m->d[j] - wide;
            m->left[j - t] = GREATER(m->left[j - t], left);
            m->right[j - t] = LESSER(m->right[j - t], right);
        }
    double edge = q->left - most_of(m->left);
    edge = LESSER(edge, least_of_lanes(m->right) - q->right);
    if (q->count_of_edges) {
        for (int t = from; t < to; t++) m->beyond = GREATER(m->beyond, beyond_here(q, m->s[t], m->d[t], m->sine[t], m->cosine[t]));
        edge = -m->beyond;
    }
    if (done) edge = LESSER(edge, q->end - m->s[e->n - 1] - 0.5 * q->length);
    m->edge = edge - EDGE_M;
    return 1;
}
