/* The judge's examination of one trajectory, as `judge._examined` makes it, with two answers: nothing is wrong with the drive itself, or
 * that is not for sure; and of each body that it is apart, or that that is not for sure.
 *
 * Every limit is kept with CERTAINLY to spare, which is more than rounding, and bodies must be apart by CLEAR on an axis that stands
 * still for the step: what is accepted here, the array operations find nothing against. All the rest is theirs to examine.
 * The equations of motion are written out again, as in `dynamics.bicycle`. */
#include "edges.h"
#include "frenet.h"

#ifdef VECTOR_MATH
double sin(double) OF_VECTORS;
double cos(double) OF_VECTORS;
double tan(double) OF_VECTORS;
#endif

#define CERTAINLY 1e-9
#define CLEAR 0.05
#define REACHES 5.0 /* `geometry.edges._REACHES` */
#define FOUND 1e-6 /* of a corner's foot, which is sought: more than what two ways to seek it differ by */
#define FAR 0.001  /* besides, of what is looked at no closer: more than rounding of a place */
#define MOST_STEPS 5
#define MOST_FINE 16  /* more than 2 MOST_STEPS + 1, and whole vectors: what lies behind an interval's last fine time repeats that */
#define PI 3.14159265358979323846

enum { T, S, D, PSI, V, A, DELTA, RATE, JERK };  /* rows of a trajectory's table */
enum { BODY_S, BODY_D, BODY_VS, BODY_VD, BODY_FADE, BODY_SWELL, BODY_CHANGE, BODY_UNTIL, BODY_RESPONSE, BODY_BRAKING,
       BODY_LENGTH, BODY_WIDTH, OF_BODY };

typedef struct {
    double wheelbase, centre, length, width, steering_max, rate_max, slowest, fastest, jerk_min, jerk_max, top; /* the car */
    double grip, left, right, end, edge_doubt;                                                             /* the road */
    double limit, reverse, edge, start_position, start_heading, start_speed, start_acceleration, start_steering, start_time;
    double end_position, end_heading, residual_position, residual_heading, residual_speed, residual_acceleration, residual_steering;
    double longest_step, largest, fine_step, along_reaches;
} Rules;

static int within(double value, double limit) { return value <= limit - CERTAINLY; }  /* never of what is no number */

static int between(double value, double low, double high) { return value >= low + CERTAINLY && value <= high - CERTAINLY; }

static double length_of(double x, double y) { return sqrt(x * x + y * y); }

static double wrapped(double angle) { return angle - 2.0 * PI * floor((angle + PI) / (2.0 * PI)); }

static int readable(const double *table, whole n, const Rules *rule)
{
    if (n < 2) return 0;
    for (whole i = 0; i < 9 * n; i++)
        if (!between(table[i], -rule->largest, rule->largest)) return 0;
    if (!within(fabs(table[0]), rule->start_time)) return 0;
    for (whole k = 1; k < n; k++)
        if (!(table[k] > table[k - 1]) || !within(table[k] - table[k - 1], rule->longest_step)) return 0;
    return 1;
}

static int starts_there(const double *table, whole n, const double *start, const Rules *rule)
{
    const double *first = table;
    return within(length_of(first[S * n] - start[0], first[D * n] - start[1]), rule->start_position)
        && within(fabs(remainder(first[PSI * n] - start[2], 2.0 * PI)), rule->start_heading)
        && within(fabs(first[V * n] - start[3]), rule->start_speed)
        && within(fabs(first[A * n] - start[4]), rule->start_acceleration)
        && within(fabs(first[DELTA * n] - start[5]), rule->start_steering);
}

/* integral of f at the ends and middles of `steps` steps of length h, by the parabola through each step's values */
static void integral(const double *f, int steps, double h, double *sum)
{
    const double share = h / 24.0;
    sum[0] = 0.0;
    for (int i = 0; i < steps; i++) {
        const double *at = f + 2 * i;
        sum[2 * i + 1] = sum[2 * i] + (5.0 * at[0] + 8.0 * at[1] - at[2]) * share;
        sum[2 * i + 2] = sum[2 * i] + (4.0 * at[0] + 16.0 * at[1] + 4.0 * at[2]) * share;
    }
}

typedef struct { double v, a, delta, yaw, x, y; } State;  /* of the rear axle, in the plane */
typedef struct {
    double v[MOST_FINE], a[MOST_FINE], delta[MOST_FINE], yaw[MOST_FINE], x[MOST_FINE], y[MOST_FINE];
    double turn[MOST_FINE], cosine[MOST_FINE], sine[MOST_FINE];  /* yaw rate, and of the yaw */
} Piece;

/* one interval under constant inputs from `from`, at its 2 steps + 1 fine times tau; a car that stops stays at rest */
static void driven(const State *from, double jerk, double rate, const double *tau, int steps, int stops, const Rules *rule, Piece *out)
{
    const int count = 2 * steps + 1;
    double along[MOST_FINE], across[MOST_FINE], h = 2.0 * tau[1];
    for (int i = 0; i < MOST_FINE; i++) {
        const double gained = jerk * tau[i];
        out->a[i] = from->a + gained;
        out->v[i] = from->v + tau[i] * (from->a + 0.5 * gained);
        out->delta[i] = from->delta + rate * tau[i];
    }
    if (stops)
        for (int i = 0, rests = 0; i < MOST_FINE; i++) {
            rests |= out->v[i] <= rule->reverse;
            if (rests) out->a[i] = out->v[i] = 0.0;
        }
    for (int i = 0; i < MOST_FINE; i++) out->turn[i] = out->v[i] * tan(out->delta[i]) / rule->wheelbase;
    integral(out->turn, steps, h, out->yaw);
    for (int i = 0; i < count; i++) out->yaw[i] += from->yaw;
    for (int i = count; i < MOST_FINE; i++) out->yaw[i] = out->yaw[count - 1];
    for (int i = 0; i < MOST_FINE; i++) out->cosine[i] = cos(out->yaw[i]);
    for (int i = 0; i < MOST_FINE; i++) out->sine[i] = sin(out->yaw[i]);
    for (int i = 0; i < MOST_FINE; i++) {
        along[i] = out->v[i] * out->cosine[i];
        across[i] = out->v[i] * out->sine[i];
    }
    integral(along, steps, h, out->x);
    integral(across, steps, h, out->y);
    for (int i = 0; i < count; i++) {
        out->x[i] += from->x;
        out->y[i] += from->y;
    }
}

/* where the speed would fall through 0 the car may stand, its deceleration 0 at once */
static int brought_to_rest(double v, double a, double jerk, const double *tau, int steps, double next_a, double rest)
{
    double least = v;
    const double end_a = a + jerk * tau[2 * steps];
    for (int i = 1; i <= 2 * steps; i++) {
        const double here = v + tau[i] * (a + 0.5 * jerk * tau[i]);
        if (here < least) least = here;
    }
    return least <= rest && end_a < 0.0 && fabs(next_a) < fabs(next_a - end_a);
}

static int kept_limits(const Piece *one, int steps, const Rules *rule)
{
    const double more = 1.0 + rule->limit;
    for (int i = 0; i <= 2 * steps; i += 2) {
        const double across = one->v[i] * one->turn[i];
        if (!between(one->v[i], -rule->reverse, rule->top * more)) return 0;
        if (!between(one->a[i], rule->slowest * more, rule->fastest * more)) return 0;
        if (!within(fabs(one->delta[i]), rule->steering_max * more)) return 0;
        if (!within(length_of(one->a[i], across), rule->grip)) return 0;
    }
    return 1;
}

/* the body centre's poses at every fine time and between (`node`: 2 per fine step, and the last); 0 where the drive is not sound */
static int followed(const double *table, whole n, const Frame *frame, const Rules *rule, int steps, double *node, double *time, whole stride)
{
    double tau[MOST_FINE], *node_x = node, *node_y = node + stride, *node_yaw = node + 2 * stride;
    double here[3], next[3], begun[3];
    State run;
    Piece piece, all;
    whole out = 0;
    if (!to_plane(frame, table[S * n], table[D * n], table[PSI * n], here, here + 1, here + 2)) return 0;
    memcpy(begun, here, sizeof begun);
    run.v = table[V * n], run.a = table[A * n], run.delta = table[DELTA * n], run.yaw = here[2];
    run.x = here[0] - rule->centre * cos(here[2]), run.y = here[1] - rule->centre * sin(here[2]);
    for (whole k = 0; k + 1 < n; k++) {
        const double jerk = table[JERK * n + k], rate = table[RATE * n + k], dt = table[k + 1] - table[k];
        const int last = 2 * steps;
        State from = {table[V * n + k], table[A * n + k], table[DELTA * n + k], here[2], 0.0, 0.0};
        double miss_x, miss_y, miss_yaw;
        int stops;
        from.x = here[0] - rule->centre * cos(here[2]);
        from.y = here[1] - rule->centre * sin(here[2]);
        for (int i = 0; i < MOST_FINE; i++) tau[i] = i < last ? dt * i / last : dt;
        stops = brought_to_rest(from.v, from.a, jerk, tau, steps, table[A * n + k + 1], rule->reverse);
        driven(&from, jerk, rate, tau, steps, stops, rule, &piece);
        driven(&run, jerk, rate, tau, steps, stops, rule, &all);
        run.v = stops ? 0.0 : run.v + (run.a + 0.5 * jerk * dt) * dt;
        run.a = stops ? 0.0 : run.a + jerk * dt;
        run.delta += rate * dt;
        run.yaw = all.yaw[last], run.x = all.x[last], run.y = all.y[last];
        if (!to_plane(frame, table[S * n + k + 1], table[D * n + k + 1], table[PSI * n + k + 1], next, next + 1, next + 2)) return 0;
        miss_x = next[0] - piece.x[last] - rule->centre * piece.cosine[last];
        miss_y = next[1] - piece.y[last] - rule->centre * piece.sine[last];
        miss_yaw = wrapped(next[2] - piece.yaw[last]);
        if (!within(length_of(miss_x, miss_y), rule->residual_position) || !within(fabs(miss_yaw), rule->residual_heading)
            || !within(fabs(table[V * n + k + 1] - piece.v[last]), rule->residual_speed)
            || !within(fabs(table[A * n + k + 1] - piece.a[last]), rule->residual_acceleration)
            || !within(fabs(table[DELTA * n + k + 1] - piece.delta[last]), rule->residual_steering)) return 0;
        if (!kept_limits(&piece, steps, rule)) return 0;
        for (int i = 0; i < last + (k + 2 == n); i++, out++) {  /* bent to pass through every sample */
            const double share = (double)i / last;
            time[out] = table[k] + tau[i];
            node_x[out] = piece.x[i] + rule->centre * piece.cosine[i] + miss_x * share;
            node_y[out] = piece.y[i] + rule->centre * piece.sine[i] + miss_y * share;
            node_yaw[out] = piece.yaw[i] + miss_yaw * share;
        }
        memcpy(here, next, sizeof here);
    }
    run.x += rule->centre * cos(run.yaw) - here[0];
    run.y += rule->centre * sin(run.yaw) - here[1];
    return within(length_of(run.x, run.y), rule->end_position) && within(fabs(wrapped(here[2] - run.yaw)), rule->end_heading);
}

/* the road's edges where they are narrowest between two places */
static void narrowest(const Edges *edges, const Rules *rule, double low, double high, double *left, double *right)
{
    *left = rule->left, *right = rule->right;
    if (!edges->count) return;
    const whole count = edges->count;
    const double *at = edges->table, *lefts = at + count, *rights = lefts + count, ends[2] = {low, high};
    *left = HUGE_VAL, *right = -HUGE_VAL;
    for (int i = 0; i < 2; i++) {
        const whole k = knot_before(ends[i], count, at);
        *left = LESSER(*left, value_behind(k, ends[i], count, at, lefts));
        *right = GREATER(*right, value_behind(k, ends[i], count, at, rights));
    }
    for (whole k = knot_before(low, count, at); k < count && at[k] < high; k++) {
        if (at[k] <= low) continue;
        *left = LESSER(*left, lefts[k]);
        *right = GREATER(*right, rights[k]);
    }
}

static int last_sample_and_inputs(const double *table, whole n, const Edges *edges, const Rules *rule)
{
    const double more = 1.0 + rule->limit;
    const double across = table[V * n + n - 1] * table[V * n + n - 1] * tan(table[DELTA * n + n - 1]) / rule->wheelbase;
    for (whole k = 0; k < n; k++) {
        double left, right;
        if (!between(table[JERK * n + k], rule->jerk_min * more, rule->jerk_max * more)) return 0;
        if (!within(fabs(table[RATE * n + k]), rule->rate_max * more)) return 0;
        narrowest(edges, rule, table[S * n + k], table[S * n + k], &left, &right);
        if (!between(table[D * n + k], right - rule->edge, left + rule->edge)) return 0;
    }
    return between(table[V * n + n - 1], -rule->reverse, rule->top * more)
        && between(table[A * n + n - 1], rule->slowest * more, rule->fastest * more)
        && within(fabs(table[DELTA * n + n - 1]), rule->steering_max * more) && within(length_of(table[A * n + n - 1], across), rule->grip);
}

/* the sharpest bends to the left and to the right between two places, 0 where there is none */
typedef struct {
    double left, right;
} Bends;

static Bends bends_between(const Frame *frame, double low, double high)
{
    const double first = road_curvature(frame, low), last = road_curvature(frame, high);
    Bends most = {GREATER(GREATER(first, last), 0.0), GREATER(GREATER(-first, -last), 0.0)};
    for (whole i = knot_before(low, frame->knots, frame->at); i < frame->knots && frame->at[i] < high; i++)
        if (frame->at[i] > low) {
            most.left = GREATER(most.left, frame->kappa[i]);
            most.right = GREATER(most.right, -frame->kappa[i]);
        }
    return most;
}

/* How far corners may be to the right of where they would be were the road straight on from the centre's foot, between two samples, where it
 * bends to the left, and to the left where it bends to the right; and, in `along`, how far along the road their feet may be from that. On the
 * way to a corner, x along the tangent, its foot moves by at most x / least, least = 1 - kappa d (a road keeps it above 0.1), and the road's
 * heading by kappa times that: kappa x^2 / (2 least), with the sharpest curvature of what is passed. */
static Bends bent_by(const Frame *frame, const double *table, whole n, whole k, double radius, double *along)
{
    const whole next = k + 1 < n ? k + 1 : k;
    const double aside = GREATER(fabs(table[D * n + k]), fabs(table[D * n + next])) + 1.5 * radius;
    const double low = LESSER(table[S * n + k], table[S * n + next]), high = GREATER(table[S * n + k], table[S * n + next]);
    const Bends around = bends_between(frame, low - 10.0 * radius, high + 10.0 * radius);
    const double least = GREATER(1.0 - GREATER(around.left, around.right) * aside, 0.1), share = radius * radius / (2.0 * least);
    Bends most;
    *along = radius / least;
    most = bends_between(frame, low - *along, high + *along);
    most.left *= share;
    most.right *= share;
    return most;
}

/* the foot s of (x, y) on the road, and its d, sought from a guess; 0 where the line is not tabulated so far, or it is not found */
static int foot_of(const Frame *frame, double x, double y, double guess, double *s, double *d)
{
    *s = frame->samples ? guess : x;
    *d = y;
    for (int i = 0; i < 12 && frame->samples; i++) {
        double px, py, theta, along;
        if (!to_plane(frame, *s, 0.0, 0.0, &px, &py, &theta)) return 0;
        along = (x - px) * cos(theta) + (y - py) * sin(theta);
        *d = (y - py) * cos(theta) - (x - px) * sin(theta);
        if (fabs(along) < CERTAINLY) return 1;
        *s += along / GREATER(1.0 - *d * road_curvature(frame, *s), 0.1);
    }
    return !frame->samples;
}

/* a body on the road, as `surface._between_changing_edges` has it: each corner between the edges where it is, none beyond the end, and
 * no knot of an edge in the body; its centre is at (x, y), turned by yaw, with its foot at (s, d) */
static int stands_on_road(const Frame *frame, const Edges *edges, const Rules *rule, double x, double y, double yaw, double s, double d)
{
    const double c = cos(yaw), q = sin(yaw), *at = edges->table;
    const double psi = frame->samples ? yaw - road_heading(frame, s) : yaw, kappa = frame->samples ? road_curvature(frame, s) : 0.0;
    const double slack = rule->edge - FOUND, reach = REACHES * length_of(rule->length, rule->width);
    for (int corner = 0; corner < 4; corner++) {
        const double ahead = (corner & 1 ? -0.5 : 0.5) * rule->length, aside = (corner & 2 ? -0.5 : 0.5) * rule->width;
        double foot, offset, left, right;
        if (!foot_of(frame, x + c * ahead - q * aside, y + q * ahead + c * aside, s + ahead, &foot, &offset)) return 0;
        narrowest(edges, rule, foot, foot, &left, &right);
        if (!(offset <= left + slack && offset >= right - slack && foot <= rule->end + slack)) return 0;
    }
    for (whole i = 0; i < 2 * edges->count; i++) {
        const double ds = at[i % edges->count] - s, side = at[edges->count + i], bend = 1.0 - kappa * side;
        const double ahead = ds * bend, aside = side - d + 0.5 * kappa * ds * ds * bend;
        const double in_length = 0.5 * rule->length - fabs(cos(psi) * ahead + sin(psi) * aside);
        const double in_width = 0.5 * rule->width - fabs(cos(psi) * aside - sin(psi) * ahead);
        if (fabs(ds) < reach && in_length > slack && in_width > slack) return 0;
    }
    return 1;
}

/* Every corner inside the edges, where they are narrowest beside the body between two samples, and before the end. By an estimate
 * that errs to the safe side, and by the corners' own feet where that is not enough. */
static int on_road(const double *table, whole n, const Frame *frame, const Edges *edges, const Rules *rule, int steps, const double *node,
                   whole stride)
{
    const double radius = 0.5 * length_of(rule->length, rule->width), slack = frame->samples ? 0.0 : rule->edge;
    for (whole k = 0, i = 0; k < n; k++) {
        double along = radius, left, right;
        const Bends bent = frame->samples ? bent_by(frame, table, n, k, radius, &along) : (Bends){0.0, 0.0};
        const double here = table[S * n + k], next = k + 1 < n ? table[S * n + k + 1] : here;
        along += rule->edge_doubt;
        narrowest(edges, rule, LESSER(here, next) - along, GREATER(here, next) + along, &left, &right);
        if (frame->samples) left -= bent.right + rule->edge_doubt, right += bent.left + rule->edge_doubt;
        for (int j = 0; j < steps && i < stride; j++, i += 2) {
            const double share = (double)j / steps, x = node[i], y = node[stride + i], yaw = node[2 * stride + i];
            double s = x, d = y, psi = yaw, c, q, ahead, aside;
            if (frame->samples) {
                s = here + (next - here) * share;
                d = k + 1 < n ? table[D * n + k] + (table[D * n + k + 1] - table[D * n + k]) * share : table[D * n + k];
                psi -= road_heading(frame, s);
            }
            q = fabs(psi);  /* not less than its sine: what is on the road by this and a cosine of 1 is so */
            if (q < 0.5 && within(fabs(d) + 0.5 * (rule->length * q + rule->width), LESSER(left, -right))
                && within(s + (frame->samples ? 10.0 * radius : 0.5 * (rule->length + rule->width * q)), rule->end)) continue;
            c = fabs(cos(psi)), q = fabs(sin(psi));
            ahead = 0.5 * (rule->length * c + rule->width * q), aside = 0.5 * (rule->length * q + rule->width * c);
            if (frame->samples) ahead = 10.0 * radius;
            if (between(d - aside, right - slack, HUGE_VAL) && within(d + aside, left + slack) && within(s + ahead, rule->end + slack)) continue;
            if (!stands_on_road(frame, edges, rule, x, y, yaw, s, d)) return 0;
        }
    }
    return 1;
}

/* the gap on the axes of the angle `turn` that is kept at both ends of a step, on one and the same side */
static double kept_gap(double turn, const double *x, const double *y, const double *yaw, const double *other_yaw, const double *size,
                       const double *other)
{
    const double c = cos(turn), s = sin(turn);
    double before[2], behind[2];
    for (int axis = 0; axis < 2; axis++) {
        before[axis] = behind[axis] = HUGE_VAL;
        for (int end = 0; end < 2; end++) {
            const double offset = axis ? c * y[end] - s * x[end] : c * x[end] + s * y[end];
            const double p = cos(yaw[end] - turn), q = sin(yaw[end] - turn), u = cos(other_yaw[end] - turn), w = sin(other_yaw[end] - turn);
            const double own = 0.5 * (size[axis] * fabs(p) + size[1 - axis] * fabs(q));
            const double its = 0.5 * (other[axis] * fabs(u) + other[1 - axis] * fabs(w));
            before[axis] = LESSER(before[axis], offset - own - its);
            behind[axis] = LESSER(behind[axis], -offset - own - its);
        }
    }
    return GREATER(GREATER(before[0], behind[0]), GREATER(before[1], behind[1]));
}

/* where a body is along the road: at constant speed, but for an acceleration until then, and for who responds braking after that */
static double place_along(const double *body, double time)
{
    const double free = LESSER(time, body[BODY_RESPONSE]), lasting = LESSER(free, body[BODY_UNTIL]);
    const double place = body[BODY_S] + body[BODY_VS] * free + body[BODY_CHANGE] * lasting * (free - 0.5 * lasting);
    if (!(time > body[BODY_RESPONSE])) return place;
    const double speed = GREATER(body[BODY_VS] + body[BODY_CHANGE] * lasting, 0.0);
    const double braked = LESSER(time - body[BODY_RESPONSE], speed / body[BODY_BRAKING]);
    return place + speed * braked - 0.5 * body[BODY_BRAKING] * braked * braked;
}

/* on a straight road: so far before or behind all the time, however it swings to the side, that the rest need not be looked at */
static int far_along(const double *body, double reach, const Rules *rule, const double *node, const double *time, whole stride)
{
    const double swing = fabs(body[BODY_VD]) * body[BODY_FADE] * (1.0 + body[BODY_SWELL]);
    double was = 0.0;
    if (!(body[BODY_FADE] > 0.0 && body[BODY_SWELL] >= 0.0 && fabs(body[BODY_D]) + swing < rule->largest)) return 0;
    for (whole i = 0; i < stride; i += 2) {
        const double s = place_along(body, time[i]), along = s - node[i];
        const double moved = i > 0 ? fabs(along - was) + fabs(node[stride + i] - node[stride + i - 2]) + swing : 0.0;
        const double nearest = i > 0 ? LESSER(fabs(along), fabs(was)) : fabs(along);
        if (!(fabs(s) < rule->largest) || !(nearest > reach + moved + FAR) || along * was < 0.0) return 0;
        was = along;
    }
    return 1;
}

/* a body that cruises, or changes its speed until then, or responds, its lateral speed swelling and fading, apart from the host for sure in every
 * fine step */
static int apart(const double *body, const double *table, whole n, const Frame *frame, const Rules *rule, int steps, const double *node,
                 const double *time, whole stride)
{
    const double size[2] = {rule->length, rule->width}, other[2] = {body[BODY_LENGTH], body[BODY_WIDTH]};
    const double reach = 0.5 * (length_of(size[0], size[1]) + length_of(other[0], other[1])), vs = body[BODY_VS];
    const double slow = copysign(GREATER(fabs(vs), 1.0), vs);
    double x[2], y[2], yaw[2], its[2], was = 0.0;
    if (!(reach < rule->largest)) return 0;
    if (!frame->samples && far_along(body, reach, rule, node, time, stride)) return 1;
    for (whole i = 0, k = 0; i < stride; i += 2) {
        const double s = place_along(body, time[i]);
        double fade, risen, d, psi, px, py, pyaw, now;
        if (!(fabs(s) < rule->largest)) return 0;  /* nor what is no number */
        if (frame->samples) {
            const double share = (double)(i / 2 % steps) / steps;
            k = i / 2 / steps;
            const double away = s - (k + 1 < n ? table[S * n + k] + (table[S * n + k + 1] - table[S * n + k]) * share : table[S * n + k]);
            if (fabs(away) > rule->along_reaches * reach + 1.0) {  /* cannot touch on a road that may be */
                was = HUGE_VAL;
                continue;
            }
        }
        fade = exp(-time[i] / body[BODY_FADE]), risen = (1.0 + body[BODY_SWELL]) / (1.0 + body[BODY_SWELL] * fade);
        d = body[BODY_D] + body[BODY_VD] * body[BODY_FADE] * risen * (1.0 - fade), psi = atan(body[BODY_VD] * risen * risen * fade / slow);
        if (!(fabs(d) < rule->largest && fabs(psi) < 2.0)) return 0;
        px = s, py = d, pyaw = psi;
        if (frame->samples && !to_plane(frame, s, d, psi, &px, &py, &pyaw)) return 0;
        x[1] = px - node[i], y[1] = py - node[stride + i], yaw[1] = node[2 * stride + i], its[1] = pyaw;
        now = length_of(x[1], y[1]);
        if (i > 0 && was < HUGE_VAL && LESSER(was, now) <= reach + length_of(x[1] - x[0], y[1] - y[0]) + CERTAINLY) {
            if (!(kept_gap(yaw[0], x, y, yaw, its, size, other) >= CLEAR + CERTAINLY)
                && !(kept_gap(its[0], x, y, yaw, its, size, other) >= CLEAR + CERTAINLY)) return 0;
        }
        x[0] = x[1], y[0] = y[1], yaw[0] = yaw[1], its[0] = its[1], was = now;
    }
    return 1;
}

/* table (9, n) of a trajectory; start (6) or none; bodies (count, OF_BODY); edge_table (3, edge_knots), or none: the rules' edges;
 * work (4, 2 MOST_STEPS (n - 1) + 1). How many bodies are not apart from it for sure, and in doubtful (count) which; -1 where something else may be wrong with it */
PUBLIC int mcdas_conservative_accept(const double *table, whole n, const double *start, const double *rules, const double *bodies,
                                     whole count, whole samples, const double *line, whole knots, const double *bends, const double *edge_table,
                                     whole edge_knots, double *work, whole *doubtful)
{
    Rules rule;
    const Frame frame = frame_of(samples, line, knots, bends);
    const Edges edges = {edge_table, edge_knots};
    double longest = 0.0;
    whole stride;
    int steps, open = 0;
    memcpy(&rule, rules, sizeof rule);
    if (!readable(table, n, &rule) || (start && !starts_there(table, n, start, &rule))) return -1;
    for (whole k = 1; k < n; k++) longest = GREATER(longest, table[k] - table[k - 1]);
    steps = (int)ceil(longest / rule.fine_step - 1e-6);
    steps = steps < 1 ? 1 : steps > MOST_STEPS ? MOST_STEPS : steps;
    stride = 2 * steps * (n - 1) + 1;
    if (!last_sample_and_inputs(table, n, &edges, &rule) || !followed(table, n, &frame, &rule, steps, work, work + 3 * stride, stride)) return -1;
    if (!on_road(table, n, &frame, &edges, &rule, steps, work, stride)) return -1;
    for (whole i = 0; i < count; i++)
        if (!apart(bodies + OF_BODY * i, table, n, &frame, &rule, steps, work, work + 3 * stride, stride)) doubtful[open++] = i;
    return open;
}
