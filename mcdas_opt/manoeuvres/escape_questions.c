/* The questions of `manoeuvres.escape_guess` about one situation; `escape_kernel.c` stands before this text. */

static const double AS_IT_IS[3] = {1.0, 1.0, 1.0}; /* factors of level, until and push */

/* a member begun at this speed, times these factors: its level and until when; returns whether it does anything */
static int begun(const Case *q, whole member, const double *factor, double speed, double *level, double *until)
{
    const double ends = q->until_mps[member];
    *level = q->level[member] * factor[0];
    *until = q->until[member] * factor[1];
    if (ends != ends) return 1;
    *until = (ends - speed) / (*level == 0.0 ? 1.0 : *level);
    if (*until >= q->shortest) return 1;
    *level = *until = 0.0;
    return 0;
}

static void at_nodes(whole start, const whole *nodes, int n, whole *clock)
{
    for (int t = 0; t < n; t++) clock[t] = start + nodes[t];
}

/* between which distances at its start each body would be met: low and high (bodies), `stride` apart */
static void blocked(const Case *q, const Motion *m, int n, int last, const whole *clock, whole stride, double *low, double *high)
{
    const double host_long = 0.5 * q->length, host_wide = 0.5 * q->width;
    double below[ROOM], above[ROOM], first[ROOM], final[ROOM], others[ROOM], aside[ROOM], lengths[ROOM], widths[ROOM];
    for (whole j = 0; j < q->bodies; j++) {
        const double *long_of = q->half_length + j * q->lattice, *wide_of = q->half_width + j * q->lattice;
        const double *there = q->others_s + j * q->lattice, *beside = q->others_d + j * q->lattice;
        double ahead, behind;
        for (int t = 0; t < n; t++) {
            others[t] = there[clock[t]];
            aside[t] = beside[clock[t]] - m->d[t];
            lengths[t] = long_of[clock[t]];
            widths[t] = wide_of[clock[t]];
        }
        const double from = others[0] - m->s[0];
        for (int t = 0; t < n; t++) {
            const double length = lengths[t], width = widths[t], sine = m->sine[t], c = m->cosine[t], bare = fabs(sine), y = aside[t];
            const double way = sine > 0.0 ? 1.0 : (sine < 0.0 ? -1.0 : 0.0), tilt = bare + 1e-9;
            const double side = y * c * way, flank = length * bare + (width * c + host_wide);
            const double extent = length + (host_long * c + host_wide * tilt);
            const double near = (side - flank) / tilt, far = (side + flank) / tilt, gained = from - (others[t] - m->s[t]);
            const double a = GREATER(near, -extent), b = LESSER(far, extent);
            const int apart = (a >= b) | (fabs(y) >= width + (host_long * tilt + host_wide * c));
            first[t] = a;
            final[t] = b;
            below[t] = apart ? NOWHERE_M : a + gained;
            above[t] = apart ? -NOWHERE_M : b + gained;
        }
        low[j * stride] = least(n, below);
        high[j * stride] = greatest(n, above);
        if (fabs(aside[last]) < widths[last] + host_wide) {
            const double gained = from - (others[last] - m->s[last]);
            room_needed(q, m->v[last], q->others_mps[j * q->lattice + clock[last]], lengths[last], &ahead, &behind);
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

/* the same of a row that keeps its lane, of bodies that keep their speed: only the moments at which gaps can be least or greatest */
static void blocked_in_lane(const Case *q, double level, double until, const double *begin, whole clock, whole stride, double *low,
                            double *high)
{
    const double rise = q->jerk_max, fall = q->jerk_min, change = level - begin[ACCELERATION];
    const double built = change >= 0.0 ? change / rise : change / fall;
    const double reached = begin[SPEED] + 0.5 * (begin[ACCELERATION] + level) * built, steady = level == 0.0 ? 1.0 : level;
    const double ended = GREATER(until, built);
    for (whole j = 0; j < q->bodies; j++) {
        const double other = q->others_mps[j * q->lattice + clock], *beside = q->others_d + j * q->lattice;
        const double length = q->half_length[j * q->lattice + clock], bodies = length + 0.5 * q->length;
        double z[LANES], v[LANES], a[LANES], way[LANES], ahead, behind;
        double moments[6] = {0.0,   built + (other - reached) / steady, built - reached / steady, ended,
                             ended + fabs(level) / (level > 0.0 ? -fall : rise), q->clear_s};
        for (int i = 0; i < 6; i++) {
            const double late = GREATER(moments[i], 0.0);
            moments[i] = LESSER(late, q->clear_s);
        }
        sorted(6, moments);
        for (int i = 0; i < LANES; i++) z[i] = moments[i < 5 ? i : 5];
        pace(q, level, until, LANES, z, begin[SPEED], begin[ACCELERATION], v, a, way);
        for (int i = 0; i < LANES; i++) way[i] -= other * z[i];
        room_needed(q, v[5], other, length, &ahead, &behind);
        const whole half = clock + q->half_steps < q->lattice ? clock + q->half_steps : q->lattice - 1;
        const double now = fabs(beside[clock] - begin[D]), then = fabs(beside[half] - begin[D]);
        const double below = least(LANES, way) - bodies, above = greatest(LANES, way) + bodies;
        const int clear = LESSER(now, then) >= q->half_width[j * q->lattice + clock] + 0.5 * q->width;
        low[j * stride] = clear ? NOWHERE_M : LESSER(below, way[5] - behind);
        high[j * stride] = clear ? -NOWHERE_M : GREATER(above, way[5] + ahead);
    }
}

/* Bodies that cruise (bodies, CRUISER) on the lattice, as `domain.prediction` and `parting.Company` have them, into tables (5, bodies, lattice):
 * places along and across, speeds, half lengths and half widths of the boxes around them. `fade` (lattice): what is left of speeds across */
PUBLIC void mcdas_escape_company(whole bodies, whole lattice, const double *begin, const double *times, const double *fade, double *tables)
{
    enum { AT, ASIDE, ALONG, ACROSS, FADE_S, LENGTH, WIDTH, MORE_LENGTH, MORE_WIDTH, CRUISER };
    for (whole j = 0; j < bodies; j++, begin += CRUISER) {
        double *s = tables + j * lattice, *d = s + bodies * lattice, *v = d + bodies * lattice;
        double *half_length = v + bodies * lattice, *half_width = half_length + bodies * lattice;
        const double slowest = GREATER(fabs(begin[ALONG]), 1.0), length = begin[LENGTH], width = begin[WIDTH];
        for (whole t = 0; t < lattice; t++) {
            s[t] = begin[AT] + begin[ALONG] * times[t];
            d[t] = begin[ASIDE] + begin[ACROSS] * begin[FADE_S] * (1.0 - fade[t]);
            v[t] = begin[ALONG];
        }
        for (whole t = 0; t < lattice; t += TURNED_STEPS) { /* it is turned the most where a box begins: speeds across only fade */
            const whole end = t + TURNED_STEPS < lattice ? t + TURNED_STEPS : lattice;
            const double turned = atan(fabs(begin[ACROSS] * fade[t > 0 ? t - 1 : 0]) / slowest), sine = sin(turned), cosine = cos(turned);
            const double longer = 0.5 * (length + width * sine) + begin[MORE_LENGTH], wider = 0.5 * (width * cosine + length * sine) + begin[MORE_WIDTH];
            for (whole i = t; i < end; i++) {
                half_length[i] = longer;
                half_width[i] = wider;
            }
        }
    }
}

/* The host that keeps its acceleration and its steering from x on, at times (q->held): `manoeuvres.held`, into the table (STATES, held) */
PUBLIC void mcdas_escape_held(const Case *q, const double *x, const double *times, double *table)
{
    const whole n = q->held;
    const double c = q->centre, turn = tan(x[STEERING]) / q->wheelbase, top = GREATER(q->speed_max, x[SPEED]);
    const double kappa0 = curvature_at(q, x[S]), psi0 = x[HEADING] + kappa0 * c, cosine0 = cos(psi0);
    const double d0 = x[D] - c * sin(psi0) + 0.5 * kappa0 * (c * cosine0) * (c * cosine0), s0 = x[S] - c * cosine0 / (1.0 - kappa0 * d0);
    double *s = table, *d = table + n, *psi = table + 2 * n, *v = table + 3 * n, *a = table + 4 * n, *way = table + 5 * n;
    for (whole t = 0; t < n; t++) {
        const double free = x[SPEED] + x[ACCELERATION] * times[t], capped = LESSER(free, top);
        v[t] = GREATER(capped, 0.0);
        a[t] = v[t] == free ? x[ACCELERATION] : 0.0;
        way[t] = t ? way[t - 1] + 0.5 * (v[t] + v[t - 1]) * (times[t] - times[t - 1]) : 0.0;
        s[t] = s0 + way[t];
        d[t] = d0;
    }
    for (int pass = 0; pass < (q->bend > 0.0 ? PASSES : 1); pass++) {
        double turned = 0.0, along = 0.0, across = 0.0, kappa_before = 0.0, s_before = 0.0, ratio_before = 0.0, sine_before = 0.0;
        for (whole t = 0; t < n; t++) {
            const double kappa = curvature_at(q, s[t]), step = t ? way[t] - way[t - 1] : 0.0;
            if (t) turned += 0.5 * (kappa + kappa_before) * (s[t] - s_before);
            s_before = s[t];
            kappa_before = kappa;
            psi[t] = psi0 + turn * way[t] - turned;
            const double ratio = cos(psi[t]) / (1.0 - kappa * d[t]), sine = sin(psi[t]);
            along += 0.5 * (ratio + ratio_before) * step;
            across += 0.5 * (sine + sine_before) * step;
            ratio_before = ratio;
            sine_before = sine;
            s[t] = s0 + along;
            d[t] = d0 + across;
        }
    }
    for (whole t = 0; t < n; t++) {
        const double kappa = curvature_at(q, s[t]), cosine = cos(psi[t]), stretch = 1.0 - kappa * d[t];
        s[t] += c * cosine / stretch;
        d[t] += c * sin(psi[t]) - 0.5 * kappa * (c * cosine) * (c * cosine);
        psi[t] -= kappa * c;
        way[t] = x[STEERING];
    }
}

/* the nodes of a row: steps of the lattice and seconds, padded to n */
typedef struct {
    const whole *steps;
    const double *times;
    whole n, last, middle;
} Nodes;

/* a start from which members are driven, and of a car that keeps its lane and its speed from there: the share of its limits that is left, the
 * room to the edges, what it asks across at most and in the end */
typedef struct {
    Begin begin;
    whole start, clock[ROOM];
    double able, edge, alone, steady;
} Anchor;

static void anchor_at(const Case *q, whole start, const Nodes *c, Anchor *a)
{
    Motion m;
    a->start = start;
    begin_at(q, start, &a->begin);
    at_nodes(start, c->steps, (int)c->n, a->clock);
    swerve(q, 0.0, 0.0, NAN, q->straightening, &a->begin, (int)c->n, c->times, (int)c->middle, 0, 0.0, &m);
    a->alone = 0.0;
    for (int t = 0; t < c->n; t++) a->alone = GREATER(a->alone, fabs(m.v[t] * m.v[t] * m.curvature[t]));
    a->steady = fabs(m.v[c->last] * m.v[c->last] * m.curvature[c->last]);
    a->able = m.ability;
    a->edge = m.edge;
}

/* What member i needs from an anchor: low and high (bodies), slack (3), each `all` apart */
static void need(const Case *q, const Anchor *a, whole i, const Nodes *c, whole all, double *low, double *high, double *slack)
{
    const double *x = a->begin.x;
    double level, until;
    const int acts = begun(q, i, AS_IT_IS, x[SPEED], &level, &until);
    if (i < q->in_lane) {
        double sideways = a->alone;
        blocked_in_lane(q, level, until, x, a->start, all, low, high);
        if (q->bend > 0.0) { /* faster, the same bend asks for more */
            const double gained = 1.0 + level * LESSER(until, q->clear_s) / GREATER(x[SPEED], 1.0);
            if (gained > 1.0) sideways = GREATER(sideways, a->steady * gained * gained);
        }
        const double effort = sqrt(level * level + sideways * sideways), left = 1.0 - effort / q->limit;
        slack[0] = a->edge;
        slack[all] = acts ? LESSER(a->able, left) : -1.0;
        slack[2 * all] = q->comfort - effort;
    } else {
        Motion m;
        swerve(q, level, until, q->target[i], q->lateral[i], &a->begin, (int)c->n, c->times, (int)c->middle, 0, 0.0, &m);
        blocked(q, &m, (int)c->n, (int)c->last, a->clock, all, low, high);
        const double arrives = (ARRIVED_M - fabs(m.d[c->last] - q->target[i])) / ABILITY_M;
        slack[0] = m.edge;
        slack[all] = LESSER(m.ability, arrives);
        slack[2 * all] = q->comfort - m.demand;
    }
}

/* Every member from the anchors: low and high (bodies, anchors, members), slack (3, anchors, members); all nodes padded to n */
PUBLIC void mcdas_escape_needs(const Case *q, int anchors, const whole *anchor, int n, int last, const whole *nodes, const double *times,
                               int middle, double *low, double *high, double *slack)
{
    const whole size = q->members, all = anchors * size;
    const Nodes c = {nodes, times, n, last, middle};
    Anchor a;
    for (int k = 0; k < anchors; k++) {
        anchor_at(q, anchor[k], &c, &a);
        for (whole i = 0; i < size; i++) need(q, &a, i, &c, all, low + k * size + i, high + k * size + i, slack + k * size + i);
    }
}

/* whether a member, times these factors, is a way out from this start that asks no more than `most` of the tyres, and what it asks, which
 * with `brief` is left open where it is none */
static int sound_one(const Case *q, whole i, const double *factor, whole start, const Nodes *e, int brief, double most, double *demand)
{
    whole clock[ROOM], whom;
    Motion m;
    Begin b;
    double level, until;
    const double target = q->target[i];
    const int last = (int)e->last;
    begin_at(q, start, &b);
    const int acts = begun(q, i, factor, b.x[SPEED], &level, &until);
    if (brief && !acts) return 0;
    if (!swerve(q, level, until, target, q->lateral[i] * factor[2], &b, (int)e->n, e->times, (int)e->middle, brief, most, &m)) return 0;
    at_nodes(start, e->steps, (int)e->n, clock);
    *demand = m.demand;
    const int arrives = target != target || fabs(m.d[last] - target) <= ARRIVED_M;
    return acts && arrives && m.demand <= most && m.ability >= 0.0 && m.edge >= 0.0 && !doomed(q, &m, last, clock[last]) &&
           touched(q, last + 1, clock, m.s, m.d, m.sine, m.cosine, q->clear_m, 1, &whom) < 0;
}

/* Exactly: which members from these starts are ways out, and what they ask of the tyres */
PUBLIC void mcdas_escape_sound(const Case *q, int rows, const whole *member, const whole *start, int n, int last, const whole *nodes,
                               const double *times, int middle, unsigned char *good, double *demand)
{
    const Nodes e = {nodes, times, n, last, middle};
    for (int r = 0; r < rows; r++) good[r] = (unsigned char)sound_one(q, member[r], AS_IT_IS, start[r], &e, 0, INFINITY, demand + r);
}

/* The step in which a host that goes through these places (nodes) first has nothing left to somebody, and to whom; -1 without */
PUBLIC int mcdas_escape_met(const Case *q, int nodes, const whole *clock, const double *s, const double *d, const double *sine,
                            const double *cosine, whole *whom)
{
    return touched(q, nodes, clock, s, d, sine, cosine, 0.0, 0, whom);
}
