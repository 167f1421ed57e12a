/* The search for the last start of each kind, and what it begins with, for one situation in one call. */

enum { KINDS = 4, SIDEWAYS = 2 };
enum { NOBODY = -1, FRONT, REAR, BESIDE, EDGE, FRICTION };

typedef struct {
    const Case *q;
    const whole *kind;   /* (members) */
    const double *times; /* (moments) */
    const Nodes *coarse, *exact;
    Drive *drive;
    double host_d, near_d, latest_s;
    double *sine, *cosine; /* (moments): of the headings of the host under constant inputs */
} Search;

static whole closer_of(const Search *o, whole who, double moment, double own_s)
{
    const Case *q = o->q;
    whole k = (whole)rint(moment / LATTICE_S);
    if (k > q->lattice - 1) k = q->lattice - 1;
    if (fabs(q->others_d[who * q->lattice + k] - o->host_d) > o->near_d) return BESIDE;
    return q->others_s[who * q->lattice + k] > own_s ? FRONT : REAR;
}

/* when constant input ends, and by what */
static double end_of_constant_input(const Search *o, whole *clock, whole *ender)
{
    const Case *q = o->q;
    const whole n = q->moments;
    const double *s = q->table, *d = q->table + n, *sine = o->sine, *cosine = o->cosine;
    double leaves = INFINITY, moment = INFINITY;
    whole who;
    for (whole t = 0; t < n; t++) clock[t] = CONSTANT_STEPS * t;
    const int step = touched(q, 0, (int)n, 0, clock, s, d, sine, cosine, INFINITY, -INFINITY, 0.0, 0, &who);
    if (step >= 0) moment = o->times[step];
    for (whole t = 0; t < n; t++) {
        const double room = 0.5 * (q->width * cosine[t] + q->length * fabs(sine[t])) + EDGE_M;
        const int off = q->count_of_edges ? beyond_here(q, s[t], d[t], sine[t], cosine[t]) + EDGE_M > 0.0 : d[t] + room > q->left || d[t] - room < q->right;
        if (off || s[t] + 0.5 * q->length + EDGE_M > q->end) {
            leaves = o->times[t > 0 ? t - 1 : 0];
            break;
        }
    }
    *ender = NOBODY;
    if (LESSER(moment, leaves) >= o->latest_s) return o->latest_s;
    *ender = leaves < moment ? EDGE : closer_of(o, who, moment, s[step]);
    return LESSER(leaves, moment);
}

static int sound_as(const Search *o, whole member, const double *factor, whole start, double most, double *demand)
{
    return sound_one(o->q, o->drive, member, factor, start, o->exact, 1, most, demand);
}

/* The `most` members of a kind of the greatest value, of those that have at least `least_of`, the greatest first; how many */
static int greatest_of(const Search *o, whole kind, const double *value, double least_of, int most, whole *found)
{
    int count = 0;
    for (whole i = 0; i < o->q->members; i++) {
        if (o->kind[i] != kind || !(value[i] >= least_of) || (count == most && value[i] <= value[found[count - 1]])) continue;
        int j = count < most ? count++ : count - 1;
        for (; j > 0 && value[found[j - 1]] < value[i]; j--) found[j] = found[j - 1];
        found[j] = i;
    }
    return count;
}

/* Of rows (member, start) the latest start that is sound, -1 without, and whose: from the latest on, until one is */
static whole latest_sound(const Search *o, int rows, const whole *member, whole *start, double most, whole *who)
{
    for (;;) {
        int latest = -1;
        double demand;
        for (int r = 0; r < rows; r++)
            if (start[r] >= 0 && (latest < 0 || start[r] > start[latest])) latest = r;
        if (latest < 0) return -1;
        if (sound_as(o, member[latest], AS_IT_IS, start[latest], most, &demand)) {
            *who = member[latest];
            return start[latest];
        }
        start[latest] = -1;
    }
}

/* whether a member, times these factors, still is what the car can do; and, in the lane, more than next to nothing */
static int within(const Search *o, whole member, const double *factor)
{
    const Case *q = o->q;
    const double level = q->level[member] * factor[0], until = q->until[member] * factor[1];
    const double share = level < 0.0 ? -level / q->brake : level / q->accelerate;
    const int timed = q->until_mps[member] != q->until_mps[member];
    return share <= MOST && (o->kind[member] >= SIDEWAYS || (share >= LEAST && (!timed || until >= q->shortest)));
}

/* a later start than this one that a member is still sound from when it is varied a little */
static whole refined(const Search *o, whole member, whole sound, whole latest)
{
    static const double in_lane[][3] = IN_LANE, steered[][3] = STEERED;
    static const whole farther[] = FARTHER;
    const int sideways = o->kind[member] >= SIDEWAYS, steady = sideways && o->q->level[member] == 0.0;
    const double(*varied)[3] = sideways ? steered : in_lane;
    const int count = steady ? STEADY : (int)(sideways ? sizeof steered / sizeof *steered : sizeof in_lane / sizeof *in_lane);
    double so_far[3] = {1.0, 1.0, 1.0}, demand;
    for (int round = 0, moved = 1; round < REFINED && moved; round++) {
        moved = 0;
        for (size_t k = 0; k < sizeof farther / sizeof *farther && !moved; k++)
            for (int v = 0; v < count && !moved && sound + farther[k] <= latest; v++) {
                double factor[3];
                for (int i = 0; i < 3; i++) factor[i] = so_far[i] * varied[v][i];
                if (!within(o, member, factor)) continue;
                if (!sound_as(o, member, factor, sound + farther[k], INFINITY, &demand)) continue;
                memcpy(so_far, factor, sizeof factor);
                sound += farther[k];
                moved = 1;
            }
    }
    return sound;
}

static whole last_sound(const Search *o, Guesses *g, Depth *depth, int easy, whole kind, whole latest)
{
    static const whole tried[] = TRIED, tried_easy[] = TRIED_EASY, down[] = DOWN, up[] = UP;
    static const double between[] = BETWEEN;
    enum { COUNT = sizeof tried / sizeof *tried, COUNT_EASY = sizeof tried_easy / sizeof *tried_easy };
    enum { MEMBERS = BEST > WIDER ? BEST : WIDER, ROWS = BEST * COUNT > 8 * WIDER ? BEST * COUNT : 8 * WIDER };
    const double most = easy ? o->q->comfort : INFINITY, *guess = g->last + (easy ? o->q->members : 0);
    whole likely[MEMBERS], member[ROWS], start[ROWS], wanted[8], sound = -1, limit = latest + 1, who = NOBODY, best_of = NOBODY;
    if (easy)
        deepen(g, depth, 0, BEST_EASY);
    else
        deepen(g, depth, MEMBERS, BEST_EASY); /* comfortable ones on the way: they are looked for next */
    int all = greatest_of(o, kind, guess, 0.0, MEMBERS, likely), rows = 0;
    const int count = easy ? COUNT_EASY : COUNT, first = easy ? BEST_EASY : BEST, best = all < first ? all : first;
    for (int i = 0; i < best; i++) {
        const whole near = (whole)floor(guess[likely[i]] / LATTICE_S + 1e-9);
        for (int k = 0; k < count; k++) {
            const whole at = near + (easy ? tried_easy[k] : tried[k]);
            member[rows] = likely[i];
            start[rows++] = at < 0 ? 0 : (at > latest ? latest : at);
        }
    }
    for (int round = 0; round < SEARCH_ROUNDS && rows; round++) {
        whole asked[ROWS];
        memcpy(asked, start, sizeof(whole) * (size_t)rows);
        const whole found = latest_sound(o, rows, member, start, most, &who);
        int wishes = 0;
        if (found > sound) {
            sound = found;
            best_of = who;
        }
        if (limit <= sound) limit = latest + 1;
        for (int r = 0; r < rows; r++)
            if (asked[r] > sound && asked[r] < limit) limit = asked[r];
        rows = 0;
        if (easy && sound < 0 && round == 0) { /* then more of them, which may lie deeper */
            deepen(g, depth, 0, WIDER);
            all = greatest_of(o, kind, guess, 0.0, MEMBERS, likely);
        }
        const int wider = all < WIDER ? all : WIDER;
        if (sound < 0)
            for (size_t k = 0; k < sizeof down / sizeof *down; k++) wanted[wishes++] = limit > down[k] ? limit - down[k] : 0;
        else if (easy)
            continue;
        else if (limit > latest)
            for (size_t k = 0; k < sizeof up / sizeof *up; k++) wanted[wishes++] = sound + up[k];
        else if (limit - sound > CLOSE)
            for (size_t k = 0; k < sizeof between / sizeof *between; k++) wanted[wishes++] = sound + (whole)(between[k] * (double)(limit - sound));
        for (int k = 0; k < wishes; k++)
            if (sound < wanted[k] && wanted[k] <= latest && wanted[k] != limit)
                for (int i = 0; i < wider; i++) {
                    member[rows] = likely[i];
                    start[rows++] = wanted[k];
                }
    }
    return sound < 0 || easy ? sound : refined(o, best_of, sound, latest);
}

/* what a kind asks of the tyres that begins now with one of its most comfortable members, INFINITY without; members that cannot be among
 * those, by their braking or accelerating alone, are not driven */
static double asked_now(const Search *o, Guesses *g, const Depth *d, whole kind, double *ease)
{
    const Case *q = o->q;
    const double *at_most = g->slack + 2 * g->anchors * q->members;
    double best[GENTLEST], now = INFINITY, demand, easy;
    whole gentle[GENTLEST];
    for (int j = 0; j < GENTLEST; j++) best[j] = -INFINITY;
    for (whole i = d->from; i < d->to; i++) {
        ease[i] = NAN;
        ease_at_most(g, i, 0);
    }
    for (;;) {
        whole next = NOBODY;
        double most = best[GENTLEST - 1];
        for (whole i = d->from; i < d->to; i++)
            if (ease[i] != ease[i] && at_most[i] >= most) most = at_most[next = i];
        if (next == NOBODY) break;
        const int none = tried(g, next, 0, q->comfort - best[GENTLEST - 1] + 1e-9); /* COSTLY: then it is not among them */
        const int opened = !none && open_at(g, next, 0, &easy) > 0.0;
        double value = ease[next] = opened ? at_most[next] : -INFINITY;
        for (int j = 0; j < GENTLEST; j++)
            if (value > best[j]) {
                const double lesser = best[j];
                best[j] = value;
                value = lesser;
            }
    }
    const int count = greatest_of(o, kind, ease, -NOWHERE_M, GENTLEST, gentle);
    for (int i = 0; i < count; i++)
        if (sound_as(o, gentle[i], AS_IT_IS, 0, INFINITY, &demand) && demand < now) now = demand;
    return now;
}

/* what is in the way of a kind at a start: of its members that car and road allow, the one that comes nearest to being clear */
static whole in_the_way(const Search *o, Guesses *g, const Depth *d, int n)
{
    const Case *q = o->q;
    const Between b = g->between[n];
    const whole size = q->members, all = g->anchors * size;
    const double *low = g->low, *high = g->high, *slack = g->slack;
    int possible = 0;
    double best = -INFINITY;
    whole who = NOBODY;
    for (whole i = d->from; i < d->to; i++) {
        const whole here = b.k * size + i, there = b.next * size + i;
        if (tried(g, i, b.k, INFINITY) & tried(g, i, b.next, INFINITY) & UNABLE) continue;
        ask(g, i, b.k);
        ask(g, i, b.next);
        if (!(b.share * slack[all + here] + b.rest * slack[all + there] >= 0.0)) continue;
        possible = 1;
        if (!(b.share * slack[here] + b.rest * slack[there] >= 0.0)) continue;
        double nearest = INFINITY;
        whole whom = NOBODY;
        for (whole j = 0; j < q->bodies; j++) {
            const double gap = g->apart[j * g->starts + n], *below = low + j * all, *above = high + j * all;
            const double under = b.share * below[here] + b.rest * below[there] - gap;
            const double over = gap - (b.share * above[here] + b.rest * above[there]), miss = GREATER(under, over);
            if (miss < nearest) {
                nearest = miss;
                whom = j;
            }
        }
        if (whom >= 0 && nearest > best) {
            best = nearest;
            who = whom;
        }
    }
    if (who == NOBODY) return possible || d->from == d->to ? EDGE : FRICTION;
    return closer_of(o, who, 0.0, q->table[S]);
}

enum { ANSWERS = 2 + 4 * KINDS };

/* how many numbers the map works with */
static whole room_of_map(whole moments, whole bodies, whole members)
{
    return ANSWERS + moments + STARTS * (1 + bodies) + members * (2 * bodies * ANCHORS + 3 * ANCHORS + 4);
}

/* The whole map, into `work`: when constant input ends, what each kind asks that begins now (INFINITY without); whole numbers: what ends it, the
 * last steps of each kind (of any demand, of a comfortable one; -1 without), what closes each (NOBODY where it lasts until constant input ends). */
static void map(Search *o, double *work)
{
    const Case *q = o->q;
    const whole size = q->members, all = ANCHORS * size;
    double *now_of = work + 1;
    whole *ender = (whole *)(now_of + KINDS), *start_of = ender + 1, *closers = start_of + 2 * KINDS;
    double *seconds = work + ANSWERS, *apart = seconds + STARTS;
    double *low = apart + STARTS * q->bodies, *high = low + q->bodies * all, *slack = high + q->bodies * all;
    double *last = slack + 3 * all, *ease = last + 2 * size;
    whole *clock = (whole *)(ease + size);
    unsigned char *known = (unsigned char *)(clock + q->moments);
    whole anchor[ANCHORS];
    Between between[STARTS];
    int anchors = 0;
    const double end = work[0] = end_of_constant_input(o, clock, ender), step = end / (STARTS - 1);
    const int wanted = 1 + (int)ceil(end / APART_S), least_of = GREATER(wanted, LEAST_ANCHORS), count_of = LESSER(least_of, ANCHORS);
    for (int k = 0; k < count_of; k++) {
        const whole at = (whole)rint((k < count_of - 1 ? k * (end / (count_of - 1)) : end) / LATTICE_S);
        if (!anchors || at > anchor[anchors - 1]) anchor[anchors++] = at;
    }
    for (int n = 0, k = 0; n < STARTS; n++) {
        seconds[n] = n < STARTS - 1 ? n * step : end;
        while (k < anchors - 1 && seconds[n] >= LATTICE_S * (double)anchor[k + 1]) k++;
        double w[ANCHORS] = {0.0};
        w[k] = 1.0;
        if (k < anchors - 1) {
            const double from = LATTICE_S * (double)anchor[k], per = 1.0 / (LATTICE_S * (double)anchor[k + 1] - from);
            w[k] = -per * (seconds[n] - from) + 1.0;
            w[k + 1] = per * (seconds[n] - from);
        }
        between[n] = between_of(w, anchors);
        const whole at = (whole)rint(seconds[n] / LATTICE_S), before = at / CONSTANT_STEPS < q->moments - 1 ? at / CONSTANT_STEPS : q->moments - 2;
        const double *s = q->table + before, *t = o->times + before;
        const double own = (s[1] - s[0]) / (t[1] - t[0]) * (LATTICE_S * (double)at - t[0]) + s[0];
        for (whole j = 0; j < q->bodies; j++) apart[j * STARTS + n] = q->others_s[j * q->lattice + at] - own;
    }
    Guesses g = {q, o->coarse, anchor, anchors, STARTS, seconds, apart, between, low, high, slack, last, known, .ready = {0}};
    Drive drive;
    drive.start = NOBODY;
    o->drive = &drive;
    memset(known, 0, (size_t)(anchors * size));
    for (whole i = 0; i < 2 * size; i++) last[i] = -1.0;
    const whole latest = (whole)floor(end / LATTICE_S + 1e-9);
    for (whole kind = 0, i = 0; kind < KINDS; kind++) {
        Depth d = {i, i, i, STARTS - 1};
        while (i < size && o->kind[i] == kind) i++;
        d.to = i;
        const double now = now_of[kind] = asked_now(o, &g, &d, kind, ease);
        for (int easy = 0; easy < 2; easy++) start_of[easy * KINDS + kind] = last_sound(o, &g, &d, easy, kind, latest);
        if (start_of[kind] < 0 && now < INFINITY) start_of[kind] = 0;
        if (start_of[KINDS + kind] < 0 && now <= o->q->comfort) start_of[KINDS + kind] = 0;
        if (start_of[kind] < start_of[KINDS + kind]) start_of[kind] = start_of[KINDS + kind]; /* what is comfortable is sound */
        const whole start = start_of[kind];
        int after = 0;
        if (start >= 0)
            while (after < STARTS - 1 && seconds[after] <= LATTICE_S * (double)start) after++;
        closers[kind] = start < latest ? in_the_way(o, &g, &d, after) : NOBODY;
    }
}
