/* Questions about one situation: what members need from a few starts, and whether a member is open from a start. */

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

/* a row that sets out: its speeds and ways at all the nodes, and its profile */
static Profile set_out(const Case *q, const Begin *b, double level, double until, double target, double lateral, const Nodes *e, Motion *m)
{
    const double v0 = b->x[SPEED];
    pace(q, level, until, (int)e->n, e->times, v0, b->x[ACCELERATION], m->v, m->a, m->way);
    const double least_of = LESSER(v0, m->v[e->middle]), slow = GREATER(least_of, SLOWEST_MPS);
    start_out(b->s0, m);
    return profile(q, level, target, lateral, slow, v0, m->a[0], b);
}

/* a start from which members are driven, and of a car that keeps its lane and its speed from there: the share of its limits that is left, the
 * room to the edges, what it asks across at most and in the end */
typedef struct {
    Begin begin;
    whole start;
    double able, edge, alone, steady;
} Anchor;

static void anchor_at(const Case *q, whole start, const Nodes *c, Anchor *a)
{
    Motion m;
    a->start = start;
    begin_at(q, start, &a->begin);
    const Profile p = set_out(q, &a->begin, 0.0, 0.0, NAN, q->straightening, c, &m);
    driven(q, &p, c, 0, (int)c->n, 0, 0.0, &m);
    a->alone = 0.0;
    for (int t = 0; t < c->n; t++) a->alone = GREATER(a->alone, fabs(m.v[t] * m.v[t] * m.curvature[t]));
    a->steady = fabs(m.v[c->last] * m.v[c->last] * m.curvature[c->last]);
    a->able = m.ability;
    a->edge = m.edge;
}

/* What member i, which keeps its lane, leaves from an anchor of the road, of the car's limits and of what is comfortable: (3), `all` apart. It does
 * across as a car that keeps its speed; before a bend that is too fast for that, who brakes asks for less, and is driven. */
static void left_in_lane(const Case *q, const Anchor *a, const Nodes *c, whole i, whole all, double *slack)
{
    const double *x = a->begin.x;
    double level, until, sideways = a->alone;
    const int acts = begun(q, i, AS_IT_IS, x[SPEED], &level, &until);
    if (q->bend > 0.0) { /* faster, the same bend asks for more */
        const double gained = 1.0 + level * LESSER(until, q->clear_s) / GREATER(x[SPEED], 1.0);
        if (gained > 1.0) sideways = GREATER(sideways, a->steady * gained * gained);
    }
    const double effort = sqrt(level * level + sideways * sideways), left = 1.0 - effort / q->limit;
    slack[0] = a->edge;
    slack[all] = acts ? LESSER(a->able, left) : -1.0;
    slack[2 * all] = q->comfort - effort;
    if (q->bend > 0.0 && acts && level < 0.0 && slack[all] < 0.0) {
        Motion m;
        const Profile p = set_out(q, &a->begin, level, until, q->target[i], q->lateral[i], c, &m);
        driven(q, &p, c, 0, (int)c->n, 0, 0.0, &m);
        slack[0] = m.edge;
        slack[all] = m.ability;
        slack[2 * all] = q->comfort - m.demand;
    }
}

/* which gaps it needs: low and high (bodies), `all` apart */
static void gaps_in_lane(const Case *q, const Anchor *a, whole i, whole all, double *low, double *high)
{
    double level, until;
    begun(q, i, AS_IT_IS, a->begin.x[SPEED], &level, &until);
    blocked_in_lane(q, level, until, a->begin.x, a->start, all, low, high);
}

enum { COSTLY = 1, UNABLE = 8, OFF_ROAD = 16 }; /* asks for more than it may; is beyond the car; leaves the road */

/* Both of a member that steers; 0. With `brief` only where it is none of these; else which. */
static int steered(const Case *q, const Anchor *a, whole i, const Nodes *c, int brief, double most, whole all, double *low, double *high,
                   double *slack)
{
    Motion m;
    double level, until;
    begun(q, i, AS_IT_IS, a->begin.x[SPEED], &level, &until);
    const Profile p = set_out(q, &a->begin, level, until, q->target[i], q->lateral[i], c, &m);
    if (brief && !p.fits) return UNABLE;
    for (int from = 0, to, n = (int)c->n; from < n; from = to) {
        to = brief && from + PIECE < n ? from + PIECE : n;
        if (!driven(q, &p, c, from, to, brief, most, &m)) return m.demand > most ? COSTLY : UNABLE;
        if (brief && !(m.edge >= 0.0)) return OFF_ROAD;
    }
    blocked(q, &m, c, a->start, all, low, high);
    const double arrives = (ARRIVED_M - fabs(m.d[c->last] - q->target[i])) / ABILITY_M;
    slack[0] = m.edge;
    slack[all] = LESSER(m.ability, arrives);
    slack[2 * all] = q->comfort - m.demand;
    return 0;
}

/* a row and the start that it was last driven from */
typedef struct {
    whole start;
    Begin begin;
    Motion motion;
} Drive;

/* whether a member, times these factors, is open from this start and asks no more than `most` of the tyres, and what it asks, which
 * with `brief` is left open where it is none */
static int sound_one(const Case *q, Drive *w, whole i, const double *factor, whole start, const Nodes *e, int brief, double most, double *demand)
{
    const double target = q->target[i];
    const int last = (int)e->last, n = (int)e->n;
    Motion *m = &w->motion;
    whole whom;
    double level, until;
    if (w->start != start) begin_at(q, w->start = start, &w->begin);
    const int acts = begun(q, i, factor, w->begin.x[SPEED], &level, &until);
    if (brief && !acts) return 0;
    const Profile p = set_out(q, &w->begin, level, until, target, q->lateral[i] * factor[2], e, m);
    if (brief && !p.fits) return 0;
    int met = -1;
    for (int from = 0, to; from < n && met < 0; from = to) {
        to = brief && from + PIECE < n ? from + PIECE : n;
        if (!driven(q, &p, e, from, to, brief, most, m)) return 0;
        if (brief && !(m->edge >= 0.0)) return 0;
        met = touched(q, from, LESSER(to, last + 1), start, e->steps, m->s, m->d, m->sine, m->cosine, most_of(m->left),
                      least_of_lanes(m->right), q->clear_m, 1, &whom);
    }
    *demand = m->demand;
    const int arrives = target != target || fabs(m->d[last] - target) <= ARRIVED_M;
    return met < 0 && acts && arrives && m->demand <= most && m->ability >= 0.0 && m->edge >= 0.0 && !inevitable_collision(q, m, last, start + e->steps[last]);
}

/* Exactly: which members are open from these starts, and what they ask of the tyres */
PUBLIC void mcdas_escape_sound(const Case *q, int rows, const whole *member, const whole *start, const Nodes *e, unsigned char *good,
                               double *demand)
{
    Drive w;
    w.start = -1;
    for (int r = 0; r < rows; r++) good[r] = (unsigned char)sound_one(q, &w, member[r], AS_IT_IS, start[r], e, 0, INFINITY, demand + r);
}
