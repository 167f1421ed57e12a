/* One row against the predicted traffic: signed separations and gaps. */

#define ROUNDING_M 1e-6

static void room_needed(const Case *q, double v, double other, double half_length, double *ahead, double *behind)
{
    const double closing = v - other, bodies = half_length + 0.5 * q->length;
    const double on = GREATER(closing, 0.0), off = LESSER(closing, 0.0);
    *ahead = bodies + on * on / (2.0 * ROOM_SHARE * q->brake);
    *behind = bodies + off * off / (2.0 * ROOM_SHARE * q->accelerate);
}

/* whether two rectangles that move for a step from x, y (two values each) leave a moment without an axis that separates them */
static int meet(const double *x, const double *y, const double *sine, const double *cosine, double length, double width, double kept,
                double host_long, double host_wide)
{
    double until = -1.0, since = 2.0, gap[8][2];
    for (int e = 0; e < 2; e++) {
        const double c = cosine[e], tilt = fabs(sine[e]);
        const double own = host_long * c + host_wide * tilt + length + kept, side = host_long * tilt + host_wide * c + width + kept;
        gap[0][e] = x[e] - own, gap[1][e] = -x[e] - own, gap[2][e] = y[e] - side, gap[3][e] = -y[e] - side;
    }
    for (int i = 0; i < 4; i++) /* mostly one of these separates them all the time */
        if (gap[i][0] > 0.0 && gap[i][1] > 0.0) return 0;
    for (int e = 0; e < 2; e++) {
        const double c = cosine[e], s = sine[e], tilt = fabs(s), along = x[e] * c + y[e] * s, aside = y[e] * c - x[e] * s;
        const double their = length * c + width * tilt + host_long + kept, flank = length * tilt + width * c + host_wide + kept;
        gap[4][e] = along - their, gap[5][e] = -along - their, gap[6][e] = aside - flank, gap[7][e] = -aside - flank;
    }
    for (int i = 0; i < 8; i++) {
        const double begin = gap[i][0], end = gap[i][1];
        if (begin > 0.0 && end > 0.0) return 0;
        if (begin > 0.0) until = GREATER(until, begin / (begin - end));
        if (end > 0.0) since = LESSER(since, begin / (begin - end));
    }
    return !(until > since);
}

/* whether a body stays to the left of a row that comes no farther left, or to the right of it, by more than `kept`: mostly nothing else need
 * be asked */
static int stays_beside(const Case *q, whole j, double left, double right, double kept)
{
    return q->rightmost[j] - left > kept + ROUNDING_M || right - q->leftmost[j] > kept + ROUNDING_M;
}

/* The first step between the nodes `from` and `to`, so many steps of the lattice after `start`, in which no more than `kept` is left to
 * somebody, and to whom; -1 without. With `any` it is any such step. The row's sides are never beyond `left` and `right`. */
static int touched(const Case *q, int from, int to, whole start, const whole *steps, const double *s, const double *d, const double *sine,
                   const double *cosine, double left, double right, double kept, int any, whole *whom)
{
    const double host_long = 0.5 * q->length, host_wide = 0.5 * q->width, corner = sqrt(host_long * host_long + host_wide * host_wide);
    const int straight = !(q->bend > 0.0), begin = from ? from - 1 : 0;
    int first = -1;
    *whom = -1;
    for (whole j = 0; j < q->bodies; j++) {
        const whole at = j * q->lattice + start;
        const double *lengths = q->half_length + at, *widths = q->half_width + at, *there = q->others_s + at, *aside = q->others_d + at;
        const double longest = q->longest[j], widest_bow = straight ? 0.0 : BOW * q->bend * (4.0 * longest * longest + q->length * q->length);
        if (stays_beside(q, j, left, right, kept + widest_bow)) continue;
        const double reach = (corner + longest + kept + STEP_REACH_M) * (straight ? 1.0 : 2.0);
        whole knot = straight ? 0 : knot_before(there[steps[begin]], q->count_of_knots, q->knots);
        int near = fabs(there[steps[begin]] - s[begin]) < reach;
        for (int k = begin + 1; k < to && (first < 0 || k <= first); k++) {
            const int before = near;
            near = fabs(there[steps[k]] - s[k]) < reach;
            if (!(before || near)) continue;
            double x[2], y[2];
            const whole past = steps[k - 1], next = steps[k];
            const double length = GREATER(lengths[past], lengths[next]), width = GREATER(widths[past], widths[next]);
            const double bow = straight ? 0.0 : BOW * q->bend * (4.0 * length * length + q->length * q->length);
            for (int e = 0; e < 2; e++) {
                const int i = k - 1 + e;
                x[e] = there[steps[i]] - s[i];
                y[e] = aside[steps[i]] - d[i];
                if (!straight) x[e] *= 1.0 - curvature_on(q, s[i] + x[e], &knot) * 0.5 * (aside[steps[i]] + d[i]);
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

static int inevitable_collision(const Case *q, const Motion *m, int last, whole clock)
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

/* between which distances at its start each body would be met: low and high (bodies), `stride` apart */
static void blocked(const Case *q, const Motion *restrict m, const Nodes *c, whole start, whole stride, double *low, double *high)
{
    const double host_long = 0.5 * q->length, host_wide = 0.5 * q->width;
    const double left = most_of(m->left), right = least_of_lanes(m->right);
    const int n = (int)c->n, last = (int)c->last;
    double first[ROOM], final[ROOM], others[ROOM], aside[ROOM], lengths[ROOM], widths[ROOM];
    for (whole j = 0; j < q->bodies; j++) {
        const whole at = j * q->lattice + start;
        const double *long_of = q->half_length + at, *wide_of = q->half_width + at, *there = q->others_s + at, *beside = q->others_d + at;
        double below[LANES], above[LANES], ahead, behind;
        if (stays_beside(q, j, left, right, 0.0)) {
            low[j * stride] = NOWHERE_M;
            high[j * stride] = -NOWHERE_M;
            continue;
        }
        for (int t = 0; t < n; t++) {
            const whole step = c->steps[t];
            others[t] = there[step];
            aside[t] = beside[step] - m->d[t];
            lengths[t] = long_of[step];
            widths[t] = wide_of[step];
        }
        const double from = others[0] - m->s[0];
        for (int i = 0; i < LANES; i++) below[i] = INFINITY, above[i] = -INFINITY;
        for (int t = 0; t < n; t += LANES)
            for (int i = t; i < t + LANES; i++) {
                const double length = lengths[i], width = widths[i], sine = m->sine[i], cosine = m->cosine[i], bare = fabs(sine), y = aside[i];
                const double way = sine > 0.0 ? 1.0 : (sine < 0.0 ? -1.0 : 0.0), tilt = bare + 1e-9;
                const double side = y * cosine * way, flank = length * bare + (width * cosine + host_wide);
                const double extent = length + (host_long * cosine + host_wide * tilt);
                const double near = (side - flank) / tilt, far = (side + flank) / tilt, gained = from - (others[i] - m->s[i]);
                const double a = GREATER(near, -extent), b = LESSER(far, extent);
                const int apart = (a >= b) | (fabs(y) >= width + (host_long * tilt + host_wide * cosine));
                const double under = apart ? NOWHERE_M : a + gained, over = apart ? -NOWHERE_M : b + gained;
                first[i] = a;
                final[i] = b;
                below[i - t] = LESSER(below[i - t], under);
                above[i - t] = GREATER(above[i - t], over);
            }
        low[j * stride] = least_of_lanes(below);
        high[j * stride] = most_of(above);
        if (fabs(aside[last]) < widths[last] + host_wide) {
            const double gained = from - (others[last] - m->s[last]);
            room_needed(q, m->v[last], q->others_mps[at + c->steps[last]], lengths[last], &ahead, &behind);
            const double nearer = LESSER(first[last], -behind), farther = GREATER(final[last], ahead);
            low[j * stride] = LESSER(low[j * stride], gained + nearer);
            high[j * stride] = GREATER(high[j * stride], gained + farther);
        }
    }
}

static void sorted(int n, double *x)
{
    for (int i = 1; i < n; i++) {
        const double value = x[i];
        int j = i;
        for (; j > 0 && x[j - 1] > value; j--) x[j] = x[j - 1];
        x[j] = value;
    }
}

/* the same of a row that keeps its lane, of bodies that keep their speed: only the instants at which gaps can be least or greatest */
static void blocked_in_lane(const Case *q, double level, double until, const double *begin, whole clock, whole stride, double *low,
                            double *high)
{
    const double rise = q->jerk_max, fall = q->jerk_min, change = level - begin[ACCELERATION];
    const double built = change >= 0.0 ? change / rise : change / fall;
    const double reached = begin[SPEED] + 0.5 * (begin[ACCELERATION] + level) * built, steady = level == 0.0 ? 1.0 : level;
    const double ended = GREATER(until, built), rests = built - reached / steady, over = ended + fabs(level) / (level > 0.0 ? -fall : rise);
    for (whole j = 0; j < q->bodies; j++) {
        const double other = q->others_mps[j * q->lattice + clock], *beside = q->others_d + j * q->lattice;
        const double length = q->half_length[j * q->lattice + clock], bodies = length + 0.5 * q->length;
        const whole half = clock + q->half_steps < q->lattice ? clock + q->half_steps : q->lattice - 1;
        const double now = fabs(beside[clock] - begin[D]), then = fabs(beside[half] - begin[D]);
        low[j * stride] = NOWHERE_M;
        high[j * stride] = -NOWHERE_M;
        if (LESSER(now, then) >= q->half_width[j * q->lattice + clock] + 0.5 * q->width) continue;
        double z[LANES], v[LANES], a[LANES], way[LANES], ahead, behind;
        double instants[6] = {0.0, built + (other - reached) / steady, rests, ended, over, q->clear_s};
        for (int i = 0; i < 6; i++) {
            const double late = GREATER(instants[i], 0.0);
            instants[i] = LESSER(late, q->clear_s);
        }
        sorted(6, instants);
        for (int i = 0; i < LANES; i++) z[i] = instants[i < 5 ? i : 5];
        pace(q, level, until, LANES, z, begin[SPEED], begin[ACCELERATION], v, a, way);
        for (int i = 0; i < LANES; i++) way[i] -= other * z[i];
        room_needed(q, v[5], other, length, &ahead, &behind);
        const double below = least_of_lanes(way) - bodies, above = most_of(way) + bodies;
        low[j * stride] = LESSER(below, way[5] - behind);
        high[j * stride] = GREATER(above, way[5] + ahead);
    }
}
