/* The whole map from plain numbers: the predicted traffic on the lattice, the host under constant inputs, the manoeuvres with the forces that there
 * are, and then the search. */

/* what neither the host nor the others change: a case without bodies and members, times, and what the search takes besides */
typedef struct {
    Case bare;
    const double *moments_s, *lattice_s;
    const Nodes *coarse, *exact;
    double near_d, latest_s;
} Ground;

/* the manoeuvres as shares of what there is: a lane on neither side, on one or on both */
typedef struct {
    const whole *kind, *matching, *comfortable;
    const double *pace, *until, *push;
    whole members, in_lane, comforts;
} Spread;

/* what a map is asked for: the host's state, where the lanes beside are, and the forces that there are; bodies (CRUISER) follow */
enum { LEFT = STATES, RIGHT, GRIP, BEND, BRAKING, ACCELERATING, COMFORT, GENTLE, ASKED };

/* what the members take of these forces: levels and pushes (members) */
static void taken(const Spread *p, const double *x, double *level, double *push)
{
    const double braking = x[BRAKING], accelerating = x[ACCELERATING], grip = x[GRIP], bend = x[BEND], comfort = x[COMFORT];
    const double least_push = 0.1 * grip, easy_push = LESSER(comfort, grip);
    for (whole i = 0; i < p->members; i++) level[i] = p->pace[i] * (p->pace[i] > 0.0 ? accelerating : braking);
    for (whole k = 0; k < p->comforts; k++) {
        double *own = level + p->comfortable[k];
        const double at_least = GREATER(*own, -comfort);
        *own = LESSER(at_least, comfort);
    }
    for (whole i = 0; i < p->members; i++) {
        const double left = sqrt(grip * grip - level[i] * level[i]) - bend, there = GREATER(left, least_push);
        push[i] = p->push[i] == 0.0 ? easy_push : p->push[i] * there;
    }
    for (whole i = 0; i < p->in_lane; i++) push[i] = x[GENTLE];
}

/* Speed of the nearest body ahead and behind in the host's way; -INFINITY and INFINITY where there is nobody */
static void speeds_of_nearest(const Case *q, const double *x, double near_d, double *front, double *rear)
{
    double ahead = INFINITY, behind = INFINITY;
    *front = -INFINITY;
    *rear = INFINITY;
    for (whole j = 0; j < q->bodies; j++) {
        const whole at = j * q->lattice;
        const double apart = q->others_s[at] - x[S];
        if (!(fabs(q->others_d[at] - x[D]) < near_d)) continue;
        if (apart > 0.0 && apart < ahead) ahead = apart, *front = q->others_mps[at];
        if (-apart > 0.0 && -apart < behind) behind = -apart, *rear = q->others_mps[at];
    }
}

/* the greatest half length of a body, and between which places across it stays */
static void extent(const Case *q, whole j, double *longest, double *rightmost, double *leftmost)
{
    const double *lengths = q->half_length + j * q->lattice, *widths = q->half_width + j * q->lattice, *d = q->others_d + j * q->lattice;
    double width = widths[0], low = d[0], high = d[0];
    *longest = lengths[0];
    for (whole t = TURNED_STEPS; t < q->lattice; t += TURNED_STEPS) {
        *longest = GREATER(*longest, lengths[t]);
        width = GREATER(width, widths[t]);
    }
    for (whole t = 1; t < q->lattice; t++) {
        low = LESSER(low, d[t]);
        high = GREATER(high, d[t]);
    }
    *rightmost = low - width;
    *leftmost = high + width;
}

/* The map, into `work`, of so many bodies, whose motions follow what is asked (`fade` as for the predicted traffic), or are in `tables` (5, bodies,
 * lattice) already. Returns how many numbers it works with, and does nothing where there is room for less. */
PUBLIC whole mcdas_escape_answer(const Ground *ground, const Spread *p, const double *x, whole bodies, double fade_s, const double *fade,
                                 double *tables, whole room, double *work)
{
    Case q = ground->bare;
    const whole size = p->members, all = bodies * q.lattice;
    const whole own = room_of_map(q.moments, bodies, size), wanted = own + (STATES + 2) * q.moments + 4 * size + bodies * (5 * q.lattice + 3);
    if (wanted > room) return wanted;
    double *table = work + own, *path = table + STATES * q.moments, *level = path + 2 * q.moments, *push = level + size;
    double *target = push + size, *until_mps = target + size, *longest = until_mps + size, *rightmost = longest + bodies;
    double *leftmost = rightmost + bodies, *places = tables ? tables : leftmost + bodies;
    double ends[3] = {0.0, 0.0, NAN}, sides[4] = {NAN, NAN, x[LEFT], x[RIGHT]};
    if (!tables) predicted(bodies, q.lattice, x + ASKED, ground->lattice_s, fade_s, fade, places);
    q.bodies = bodies;
    q.others_s = places, q.others_d = places + all, q.others_mps = places + 2 * all;
    q.half_length = places + 3 * all, q.half_width = places + 4 * all;
    for (whole j = 0; j < bodies; j++) extent(&q, j, longest + j, rightmost + j, leftmost + j);
    speeds_of_nearest(&q, x, ground->near_d, ends, ends + 1);
    taken(p, x, level, push);
    for (whole i = 0; i < size; i++) {
        target[i] = sides[p->kind[i]];
        until_mps[i] = ends[p->matching[i]];
    }
    q.longest = longest, q.rightmost = rightmost, q.leftmost = leftmost, q.table = table, q.level = level, q.until = p->until, q.until_mps = until_mps, q.target = target, q.lateral = push;
    q.members = size, q.in_lane = p->in_lane;
    constant_input(&q, x, ground->moments_s, table, path);
    Search o = {&q, p->kind, ground->moments_s, ground->coarse, ground->exact, NULL, x[D], ground->near_d, ground->latest_s, path, path + q.moments};
    map(&o, work);
    return wanted;
}
