/* What the escape map spends its time on, for one row (one manoeuvre from one start) after the other: the motion of
 * `manoeuvres.swerves`, and the questions of `manoeuvres.parting` about it. Operation by operation as there; the numbers in capitals
 * stand before this text. Loops run over nodes, which are padded to whole LANES with the last one. Portable C99; nothing global. */

typedef long long whole;

enum { S, D, HEADING, SPEED, ACCELERATION, STEERING, STATES };

typedef struct {
    const double *others_s, *others_d, *others_mps, *half_length, *half_width; /* (bodies, lattice) */
    const double *longest;                           /* (bodies): the greatest half length */
    const double *table;                            /* (STATES, held): the host that keeps on */
    const double *level, *until, *until_mps, *target, *lateral;
    const double *knots, *kappas;
    whole bodies, lattice, held, members, in_lane, half_steps, count_of_knots;
    double wheelbase, centre, length, width, jerk_min, jerk_max, speed_max, steering_max, steering_rate;
    double limit, steering_share, brake, accelerate, left, right, end, bend, clear_m, clear_s, comfort, shortest, straightening;
} Case;

typedef struct {
    double v[ROOM], a[ROOM], way[ROOM], d[ROOM], first[ROOM], second[ROOM], sine[ROOM], cosine[ROOM], curvature[ROOM], ratio[ROOM], s[ROOM];
    double demand, ability, edge;
} Motion;

static double curvature_at(const Case *q, double s)
{
    const double *at = q->knots, *kappa = q->kappas;
    whole i = 0;
    if (s <= at[0]) return kappa[0];
    if (s >= at[q->count_of_knots - 1]) return kappa[q->count_of_knots - 1];
    while (s >= at[i + 1]) i++;
    return (kappa[i + 1] - kappa[i]) / (at[i + 1] - at[i]) * (s - at[i]) + kappa[i];
}

static double sign(double x) { return (double)((x > 0.0) - (x < 0.0)); }

static double greatest(int n, const double *x)
{
    double most[LANES], m;
    memcpy(most, x, sizeof most);
    for (int t = LANES; t < n; t += LANES)
        for (int j = 0; j < LANES; j++) most[j] = GREATER(most[j], x[t + j]);
    m = most[0];
    for (int j = 1; j < LANES; j++) m = GREATER(m, most[j]);
    return m;
}

static double least(int n, const double *x)
{
    double low[LANES], m;
    memcpy(low, x, sizeof low);
    for (int t = LANES; t < n; t += LANES)
        for (int j = 0; j < LANES; j++) low[j] = LESSER(low[j], x[t + j]);
    m = low[0];
    for (int j = 1; j < LANES; j++) m = LESSER(m, low[j]);
    return m;
}

/* x0 + x1 z + x2 z^2 / 2 and its derivatives, and on top of them ramps of the second one: from its begin on, for as long as it lasts */
static inline void ramps(int n, int count, const double *restrict z, double x0, double x1, double x2, const double *begin,
                         const double *lasting, const double *rate, double *restrict second, double *restrict first, double *restrict sum)
{
    for (int t = 0; t < n; t++) {
        double f2 = x2, f1 = x1 + x2 * z[t], f0 = x0 + (x1 + 0.5 * x2 * z[t]) * z[t];
        for (int r = 0; r < count; r++) {
            const double from = z[t] - begin[r], u = GREATER(from, 0.0), c = LESSER(u, lasting[r]), over = u - c, rest = lasting[r] * over;
            f2 += rate[r] * c;
            f1 += rate[r] * (0.5 * (c * c) + rest);
            f0 += rate[r] * (c * c * (c * (1.0 / 6.0)) + 0.5 * (rest * (over + lasting[r])));
        }
        second[t] = f2;
        first[t] = f1;
        sum[t] = f0;
    }
}

static void pace(const Case *q, double level, double until, int n, const double *restrict z, double v0, double a0, double *restrict v,
                 double *restrict a, double *restrict way)
{
    const double rise = SHARE * q->jerk_max, fall = SHARE * q->jerk_min;
    const double up = level >= a0 ? rise : fall, down = level > 0.0 ? fall : rise;
    const double built = (level - a0) / up, top = GREATER(SHARE * q->speed_max, v0);
    const double begins[2] = {0.0, GREATER(until, built)}, lasting[2] = {built, -level / down}, rates[2] = {up, down};
    ramps(n, 2, z, 0.0, v0, a0, begins, lasting, rates, a, v, way);
    if (least(n, v) <= 0.0) {
        int stands = 0;
        for (int t = 0; t < n; t++) {
            stands |= v[t] <= 0.0;
            if (stands) v[t] = a[t] = 0.0;
            if (t) way[t] = GREATER(way[t], way[t - 1]);
        }
    }
    if (greatest(n, v) > top)
        for (int t = 0; t < n; t++) {
            if (v[t] > top) {
                v[t] = top;
                a[t] = 0.0;
            }
            if (t) way[t] = way[t - 1] + 0.5 * (v[t] + v[t - 1]) * (z[t] - z[t - 1]);
        }
}

/* d and its first two derivatives, by the clock or by the way; returns whether there is such a sidestep */
static int across(const Case *q, double level, double target, double lateral, int timed, int n, const double *z, double slow, double v0,
                  double a0, double d0, double sine0, double bend0, Motion *m)
{
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
    const double begins[4] = {0.0, ends, turn, done}, lasting[4] = {ends, rising, timed ? 2.0 * rising : rising, rising};
    const double rates[4] = {-sign(curl0) * undoing, timed ? up : 0.0, -up, up};
    ramps(n, 4, z, d0, rate0, curl0, begins, lasting, rates, m->second, m->first, m->d);
    return fits;
}

/* the most that the steering turns in a second, from the tangents of its angle: of steps as long as each other the longest turn counts */
static double turning_rate(int n, const double *restrict times, const double *restrict tangent)
{
    double turned[ROOM], most = 0.0;
    int wide = 0;
    turned[0] = 0.0;
    for (int t = 1; t < n; t++) {
        const double under = 1.0 + tangent[t] * tangent[t - 1];
        turned[t] = fabs(tangent[t] - tangent[t - 1]) / under;
        wide |= under <= 0.0;
    }
    for (int t = 1; t < n;) {
        const double h = times[t] - times[t - 1];
        double run = 0.0;
        if (!(h > 0.0)) break;
        if (wide) {
            most = GREATER(most, fabs(atan(tangent[t]) - atan(tangent[t - 1])) / h);
            t++;
            continue;
        }
        for (; t < n && fabs(times[t] - times[t - 1] - h) < 1e-12; t++) run = GREATER(run, turned[t]);
        if (run <= most * h) continue; /* an angle is no greater than its tangent */
        run = atan(run) / h;
        most = GREATER(most, run);
    }
    return most;
}

/* the state that a row begins in, and what follows of it for the rear axle */
typedef struct {
    double x[STATES], sine0, d0, s0, bend0;
} Begin;

static void begin_at(const Case *q, whole start, Begin *b)
{
    whole before = start / HELD_STEPS;
    if (before > q->held - 2) before = q->held - 2;
    const double share = (double)start / HELD_STEPS - (double)before, c = q->centre;
    double *x = b->x;
    for (int i = 0; i < STATES; i++) {
        const double *row = q->table + i * q->held + before;
        x[i] = row[0] + share * (row[1] - row[0]);
    }
    const double kappa = q->bend > 0.0 ? curvature_at(q, x[S]) : 0.0, psi = x[HEADING] + kappa * c, cosine = cos(psi);
    b->sine0 = sin(psi);
    b->d0 = x[D] - c * b->sine0 + 0.5 * kappa * (c * cosine) * (c * cosine);
    b->s0 = x[S] - c * cosine / (1.0 - kappa * b->d0);
    b->bend0 = (tan(x[STEERING]) / q->wheelbase - kappa * cosine / (1.0 - kappa * b->d0)) * cosine;
}

/* the way along the road, from what a metre of it takes off the road's */
static void along(double s0, int n, Motion *m)
{
    m->s[0] = s0;
    for (int t = 1; t < n; t++) m->s[t] = m->s[t - 1] + 0.5 * (m->way[t] - m->way[t - 1]) * (m->ratio[t] + m->ratio[t - 1]);
}

/* The motion of one row. With `brief` it stops, and returns 0, as soon as it is beyond the car, or asks the tyres for more than `most`:
 * where the body is comes last. */
static int swerve(const Case *q, double level, double until, double target, double lateral, const Begin *begin, int n,
                  const double *restrict times, int middle, int brief, double most, Motion *restrict m)
{
    const double c = q->centre, v0 = begin->x[SPEED], a0 = begin->x[ACCELERATION], s0 = begin->s0;
    const int timed = target == target;
    double work[ROOM], kappa[ROOM];
    pace(q, level, until, n, times, v0, a0, m->v, m->a, m->way);
    const double slow = LESSER(v0, m->v[middle]);
    const int fits = across(q, level, target, lateral, timed, n, timed ? times : m->way, GREATER(slow, SLOWEST_MPS), v0, m->a[0],
                            begin->d0, begin->sine0, begin->bend0, m);
    if (brief && !fits) return 0;
    for (int t = 0; t < n; t++) {
        const double per_way = timed ? 1.0 / GREATER(m->v[t], SLOWEST_MPS) : 1.0, raw = m->first[t] * per_way;
        const double capped = LESSER(raw, STEEPEST), sine = GREATER(capped, -STEEPEST), cosine = sqrt(1.0 - sine * sine);
        work[t] = fabs(raw);
        m->sine[t] = sine;
        m->cosine[t] = m->ratio[t] = cosine;
        m->curvature[t] = (m->second[t] - (timed ? m->a[t] : 0.0) * sine) * per_way * per_way / cosine;
    }
    const double steep = greatest(n, work);
    if (q->bend > 0.0) {
        for (int t = 0; t < n; t++) m->ratio[t] /= 1.0 - curvature_at(q, s0 + m->way[t]) * m->d[t];
        along(s0, n, m);
        for (int t = 0; t < n; t++) {
            kappa[t] = curvature_at(q, m->s[t]);
            m->curvature[t] += kappa[t] * m->cosine[t] / (1.0 - kappa[t] * m->d[t]);
        }
    }
    for (int t = 0; t < n; t++) {
        const double sideways = m->v[t] * m->v[t] * m->curvature[t];
        work[t] = m->a[t] * m->a[t] + sideways * sideways;
    }
    m->demand = sqrt(greatest(n, work));
    double used = GREATER(m->demand / q->limit, steep / STEEPEST);
    if (brief && (m->demand > most || used > 1.0)) return 0;
    for (int t = 0; t < n; t++) work[t] = q->wheelbase * m->curvature[t];
    const double turned = turning_rate(n, times, work);
    for (int t = 0; t < n; t++) work[t] = fabs(work[t]);
    const double angle = atan(greatest(n, work)) / (q->steering_share * q->steering_max);
    used = GREATER(used, angle);
    used = GREATER(used, turned / (q->steering_share * q->steering_rate));
    m->ability = fits ? 1.0 - used : -1.0;
    if (brief && !(m->ability >= 0.0)) return 0;
    if (q->bend > 0.0) { /* turned by kappa c, whose sine and cosine are worked out anew only where the bend changes */
        double sin_turn = 0.0, cos_turn = 1.0, turn = 0.0;
        for (int t = 0; t < n; t++) {
            const double stretch = 1.0 - kappa[t] * m->d[t], cosine = m->cosine[t], sine = m->sine[t];
            if (kappa[t] * c != turn) turn = kappa[t] * c, sin_turn = sin(turn), cos_turn = cos(turn);
            m->s[t] += c * cosine / stretch;
            m->d[t] += c * sine - 0.5 * kappa[t] * (c * cosine) * (c * cosine);
            m->sine[t] = sine * cos_turn - cosine * sin_turn;
            m->cosine[t] = cosine * cos_turn + sine * sin_turn;
        }
    } else {
        along(s0, n, m);
        for (int t = 0; t < n; t++) {
            m->s[t] += c * m->cosine[t];
            m->d[t] += c * m->sine[t];
        }
    }
    for (int t = 0; t < n; t++) work[t] = m->d[t] + 0.5 * (q->width * m->cosine[t] + q->length * fabs(m->sine[t]));
    double edge = q->left - greatest(n, work);
    for (int t = 0; t < n; t++) work[t] = m->d[t] - 0.5 * (q->width * m->cosine[t] + q->length * fabs(m->sine[t]));
    edge = LESSER(edge, least(n, work) - q->right);
    edge = LESSER(edge, q->end - m->s[n - 1] - 0.5 * q->length);
    m->edge = edge - EDGE_M;
    return 1;
}

static void room_needed(const Case *q, double v, double other, double half_length, double *ahead, double *behind)
{
    const double closing = v - other, bodies = half_length + 0.5 * q->length;
    const double on = GREATER(closing, 0.0), off = LESSER(closing, 0.0);
    *ahead = bodies + on * on / (2.0 * ROOM_SHARE * q->brake);
    *behind = bodies + off * off / (2.0 * ROOM_SHARE * q->accelerate);
}

/* whether two rectangles that move for a step from x, y (two values each) leave a moment without an axis that parts them */
static int meet(const double *x, const double *y, const double *sine, const double *cosine, double length, double width, double kept,
                double host_long, double host_wide)
{
    double until = -1.0, since = 2.0, gap[2][8];
    for (int e = 0; e < 2; e++) {
        const double c = cosine[e], s = sine[e], tilt = fabs(s), along = x[e] * c + y[e] * s, aside = y[e] * c - x[e] * s;
        const double own = host_long * c + host_wide * tilt + length + kept, side = host_long * tilt + host_wide * c + width + kept;
        const double their = length * c + width * tilt + host_long + kept, flank = length * tilt + width * c + host_wide + kept;
        double *g = gap[e];
        g[0] = x[e] - own, g[1] = -x[e] - own, g[2] = y[e] - side, g[3] = -y[e] - side;
        g[4] = along - their, g[5] = -along - their, g[6] = aside - flank, g[7] = -aside - flank;
    }
    for (int i = 0; i < 8; i++) {
        const double begin = gap[0][i], end = gap[1][i];
        if (begin > 0.0 && end > 0.0) return 0;
        if (begin > 0.0) until = GREATER(until, begin / (begin - end));
        if (end > 0.0) since = LESSER(since, begin / (begin - end));
    }
    return !(until > since);
}

/* the first step in which no more than `kept` is left to somebody, and to whom; -1 without */
static int touched(const Case *q, int nodes, const whole *clock, const double *s, const double *d, const double *sine,
                   const double *cosine, double kept, int any, whole *whom)
{
    const double host_long = 0.5 * q->length, host_wide = 0.5 * q->width, corner = sqrt(host_long * host_long + host_wide * host_wide);
    int first = -1;
    *whom = -1;
    for (whole j = 0; j < q->bodies; j++) {
        const double *lengths = q->half_length + j * q->lattice, *widths = q->half_width + j * q->lattice;
        const double *there = q->others_s + j * q->lattice, *aside = q->others_d + j * q->lattice;
        const double reach = (corner + q->longest[j] + kept + STEP_REACH_M) * (q->bend > 0.0 ? 2.0 : 1.0);
        int near = 0;
        for (int k = 0; k < nodes && (first < 0 || k <= first); k++) {
            const int before = near;
            near = fabs(there[clock[k]] - s[k]) < reach;
            if (!k || !(before || near)) continue;
            double x[2], y[2];
            const double length = GREATER(lengths[clock[k - 1]], lengths[clock[k]]), width = GREATER(widths[clock[k - 1]], widths[clock[k]]);
            const double bow = q->bend > 0.0 ? BOW * q->bend * (4.0 * length * length + q->length * q->length) : 0.0;
            for (int e = 0; e < 2; e++) {
                const int i = k - 1 + e;
                x[e] = there[clock[i]] - s[i];
                y[e] = aside[clock[i]] - d[i];
                if (q->bend > 0.0) x[e] *= 1.0 - curvature_at(q, s[i] + x[e]) * 0.5 * (aside[clock[i]] + d[i]);
            }
            if ((first < 0 || k - 1 < first) && meet(x, y, sine + k - 1, cosine + k - 1, length, width, kept + bow, host_long, host_wide)) {
                first = k - 1;
                *whom = j;
                if (any) return first;
            }
        }
    }
    return first;
}

static int doomed(const Case *q, const Motion *m, int last, whole clock)
{
    for (whole j = 0; j < q->bodies; j++) {
        const whole at = j * q->lattice + clock;
        const double apart = q->others_s[at] - m->s[last];
        double ahead, behind;
        room_needed(q, m->v[last], q->others_mps[at], q->half_length[at], &ahead, &behind);
        if (fabs(q->others_d[at] - m->d[last]) < q->half_width[at] + 0.5 * q->width &&
            (apart > 0.0 ? apart < ahead + q->clear_m : -apart < behind + q->clear_m))
            return 1;
    }
    return 0;
}
