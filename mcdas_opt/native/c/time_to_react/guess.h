/* Which members can be started last, one by one, and no more of them than the search needs. A member is driven from an anchor when somebody
 * asks what it needs there; the answer is kept for the rest of the call. */

/* a start lies between two anchors, or (rest 0) on the first of them */
typedef struct {
    int k, next;
    double share, rest;
} Between;

static Between between_of(const double *weights, int anchors)
{
    int k = 0;
    while (k < anchors - 1 && weights[k] == 0.0) k++;
    const int next = k < anchors - 1 && weights[k + 1] != 0.0 ? k + 1 : k;
    const Between b = {k, next, weights[k], next > k ? weights[next] : 0.0};
    return b;
}

/* Of a member from an anchor: what it asks at least is known, what it leaves, which gaps it needs; or that it is UNABLE, OFF_ROAD */
enum { AT_LEAST = 1, SLACK = 2, GAPS = 4, NONE = UNABLE | OFF_ROAD };

typedef struct {
    const Case *q;
    const Nodes *nodes;
    const whole *anchor;
    int anchors, starts;
    const double *seconds, *apart; /* (starts), (bodies, starts) */
    const Between *between;        /* (starts) */
    double *low, *high, *slack;    /* (bodies, anchors, members), (3, anchors, members) */
    double *last;                  /* (2, members): of any demand, comfortable; -1 without, or not looked for yet */
    unsigned char *known;          /* (anchors, members) */
    unsigned char ready[ANCHORS];
    Anchor at[ANCHORS];
} Guesses;

static const Anchor *anchor_of(Guesses *g, int k)
{
    if (!g->ready[k]) anchor_at(g->q, g->anchor[k], g->nodes, g->at + k);
    g->ready[k] = 1;
    return g->at + k;
}

/* Drives a member from an anchor, no further than until it shows that it is none or asks for more than `most`; returns that, or 0 with
 * all of it known */
static int tried(Guesses *g, whole i, int k, double most)
{
    const Case *q = g->q;
    const whole all = g->anchors * q->members, at = k * q->members + i;
    unsigned char *known = g->known + at;
    if (*known & (SLACK | NONE)) return *known & NONE;
    if (i < q->in_lane)
        left_in_lane(q, anchor_of(g, k), g->nodes, i, all, g->slack + at);
    else {
        const int why = steered(q, anchor_of(g, k), i, g->nodes, 1, most, all, g->low + at, g->high + at, g->slack + at);
        if (why == COSTLY) return why;
        *known |= why;
        if (why) return why;
        *known |= GAPS;
    }
    *known |= SLACK;
    if (g->slack[at + all] < 0.0) *known |= UNABLE;
    if (g->slack[at] < 0.0) *known |= OFF_ROAD;
    return *known & NONE;
}

/* all of what a member needs from an anchor */
static void ask(Guesses *g, whole i, int k)
{
    const Case *q = g->q;
    const whole all = g->anchors * q->members, at = k * q->members + i;
    if (g->known[at] & GAPS) return;
    if (i < q->in_lane) {
        tried(g, i, k, INFINITY);
        gaps_in_lane(q, anchor_of(g, k), i, all, g->low + at, g->high + at);
    } else
        steered(q, anchor_of(g, k), i, g->nodes, 0, INFINITY, all, g->low + at, g->high + at, g->slack + at);
    g->known[at] |= SLACK | GAPS;
}

/* No member is more comfortable from an anchor than this: one that steers asks at least for the braking or accelerating that it begins with */
static double ease_at_most(Guesses *g, whole i, int k)
{
    const Case *q = g->q;
    const whole at = k * q->members + i;
    double *ease = g->slack + 2 * g->anchors * q->members + at;
    if (i < q->in_lane)
        tried(g, i, k, INFINITY);
    else if (!(g->known[at] & (SLACK | AT_LEAST))) {
        double level, until, v[LANES], a[LANES], way[LANES];
        const double *x = anchor_of(g, k)->begin.x;
        begun(q, i, AS_IT_IS, x[SPEED], &level, &until);
        pace(q, level, until, LANES, g->nodes->times, x[SPEED], x[ACCELERATION], v, a, way);
        for (int t = 0; t < LANES; t++) a[t] *= a[t];
        *ease = q->comfort - sqrt(most_of(a));
        g->known[at] |= AT_LEAST;
    }
    return *ease;
}

/* by how many metres a member is open at a start, and the same of a comfortable one */
static double open_at(Guesses *g, whole i, int n, double *easy)
{
    const Case *q = g->q;
    const Between b = g->between[n];
    const whole size = q->members, all = g->anchors * size, here = b.k * size + i, there = b.next * size + i;
    ask(g, i, b.k);
    if (b.next != b.k) ask(g, i, b.next);
    const double *s = g->slack;
    const double room = b.share * s[here] + b.rest * s[there], left = ABILITY_M * (b.share * s[all + here] + b.rest * s[all + there]);
    const double least_of = LESSER(room, left), ease = b.share * s[2 * all + here] + b.rest * s[2 * all + there];
    double open = LESSER(least_of, NOWHERE_M);
    for (whole j = 0; j < q->bodies; j++) {
        const double gap = g->apart[j * g->starts + n], *below = g->low + j * all, *above = g->high + j * all;
        const double under = b.share * below[here] + b.rest * below[there] - gap;
        const double over = gap - (b.share * above[here] + b.rest * above[there]), miss = GREATER(under, over);
        open = LESSER(open, miss);
    }
    *easy = LESSER(ease, open);
    return open;
}

/* whether it is not open there at all, of a member whose needs from the anchors around that start are known */
static int closed_at(const Guesses *g, whole i, int n)
{
    const Between b = g->between[n];
    const whole size = g->q->members, all = g->anchors * size, here = b.k * size + i, there = b.next * size + i;
    const double *s = g->slack, *gap = g->apart + n, *below = g->low, *above = g->high;
    if (!(b.share * s[here] + b.rest * s[there] > 0.0 && b.share * s[all + here] + b.rest * s[all + there] > 0.0)) return 1;
    for (whole j = 0; j < g->q->bodies; j++, gap += g->starts, below += all, above += all)
        if (!(b.share * below[here] + b.rest * below[there] - *gap > 0.0 || *gap - (b.share * above[here] + b.rest * above[there]) > 0.0)) return 1;
    return 0;
}

/* when a member closes that is open by `open` at start n, and at the next by `after` */
static double moment_of(const Guesses *g, int n, double open, double after)
{
    const double step = n < g->starts - 1 ? g->seconds[n + 1] - g->seconds[n] : 0.0, fall = open - after;
    return g->seconds[n] + open / GREATER(fall, 1e-9) * step;
}

/* Looks among the starts from `top` down to `bottom`, which lie between the same anchors, for the last one at which a member is open, and
 * open and comfortable, where that was not found later */
static void look(Guesses *g, whole i, int top, int bottom)
{
    double *last = g->last + i, *last_easy = last + g->q->members, easy, after_easy = 0.0, after = 0.0;
    const Between b = g->between[top];
    if (*last >= 0.0 && (*last_easy >= 0.0 || (ease_at_most(g, i, b.k) <= 0.0 && ease_at_most(g, i, b.next) <= 0.0))) return;
    if (tried(g, i, b.k, INFINITY) & (b.next == b.k ? NONE : tried(g, i, b.next, INFINITY))) return; /* so is everything in between */
    ask(g, i, b.k);
    ask(g, i, b.next);
    for (int n = top, after_of = g->starts; n >= bottom && (*last < 0.0 || *last_easy < 0.0); n--) {
        if (closed_at(g, i, n)) continue;
        if (after_of != n + 1) after = open_at(g, i, n + 1, &after_easy);
        const double open = open_at(g, i, n, &easy);
        if (*last < 0.0 && open > 0.0) *last = moment_of(g, n, open, after);
        if (*last_easy < 0.0 && easy > 0.0) *last_easy = moment_of(g, n, easy, after_easy);
        after = open;
        after_easy = easy;
        after_of = n;
    }
}

/* How far a kind's members (contiguous) have been looked at: those before `upto` from the last start down to `next`, the others down to
 * the start after it */
typedef struct {
    whole from, to, upto;
    int next;
} Depth;

static int counted(const double *last, const Depth *d, int wanted)
{
    int count = 0;
    for (whole i = d->from; i < d->to && count < wanted; i++) count += last[i] >= 0.0;
    return count;
}

/* Looks at earlier and earlier starts until so many of a kind's members, and so many comfortable ones, have a last start: no other has a
 * later one. At the very last start all that are open are equal, so that those of the least numbers do. */
static void deepen(Guesses *g, Depth *d, int plain, int easy)
{
    const double *last = g->last;
    const whole size = g->q->members;
    while (d->next >= 0 && d->from < d->to) {
        const int top = d->next, final = top == g->starts - 1;
        int bottom = top;
        while (!final && bottom > 0 && g->between[bottom - 1].k == g->between[top].k) bottom--;
        while (d->upto < d->to) {
            if ((final || d->upto == d->from) && counted(last, d, plain) == plain && counted(last + size, d, easy) == easy) return;
            look(g, d->upto++, top, bottom);
        }
        d->upto = d->from;
        d->next = bottom - 1;
    }
}
