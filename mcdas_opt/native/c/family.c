/* The family of `manoeuvres.family`, member by member: speeds of `phases`, paths of `lane_change_profiles`, separations of `clearance`, costs.
 * Operation by operation as there. Rows of samples are ROW long, a whole number of LANES, filled up with the last sample: the usual number
 * of them, or (native/build.py) that of the family. Loops over them are written so that a compiler can vectorise them. */
#include "edges.h"
#include "rectangles.h"
#include "generated/family_numbers.h"

#ifndef ROW
#define ROW USUAL_ROW
#endif

#ifdef VECTOR_MATH
double exp(double) OF_VECTORS;
double sin(double) OF_VECTORS;
#endif

enum { ACCELERATION, SPEED, WAY, FADE, FADE_N, SLOPE, SLOPE_N, CURL, CURL_N, ROAD, OF_PHASE };
enum { BODY_S, BODY_D, BODY_SINE, BODY_COSINE, BODY_KAPPA, BODY_LONG, BODY_WIDE, OF_BODY };
enum { WAY_S, WAY_D, SINE, COSINE, CURVATURE, SCRATCH, NEAREST, WHO, OF_MEMBER };
enum { SEPARATION, CONTACT, WITH, POSSIBLE, ON_ROAD, COST, OF_RESULT };

typedef struct {
    const double *phases;                       /* (phases, 3): first, switch, then */
    const double *steps;                        /* (steps, 4): target, lateral, delay, b */
    const double *times, *weights;              /* (ROW): weights are 1, and 0 for what fills it up */
    const double *bodies;                       /* (bodies, OF_BODY, ROW) */
    const double *sizes;                        /* (bodies, 4): length, width, speed along the road at the end, bow */
    const double *knots, *kappas, *edges;
    double *by_phase;                           /* (phases, OF_PHASE, ROW), filled by mcdas_family_speeds */
    double *work;                               /* (OF_MEMBER, ROW) */
    whole count_of_phases, count_of_steps, samples, count_of_bodies, count_of_knots, count_of_edges, row;
    double s0, d0, sine0, bend0, speed0, acceleration0, join;          /* the rear axle now */
    double centre, wheelbase, length, width, rise, fall, top;          /* the car, and its limits as far as they are used */
    double grip_squared, curvature_max, turn_max;                      /* tangents of steering angle and of its step, over the wheelbase */
    double left, right, end;                                           /* the road */
    double wanted, lane_d, half_lane, clear, reach;
    double cost_acceleration, cost_speed, cost_lateral, cost_near, nearness, cost_change, cost_closing, end_room;
} Family;

/* NAME(n, x): the one of all that CHOSEN chooses of two. */
#define ONE_OF_ALL(NAME, CHOSEN)                                                       \
    static double NAME(whole n, const double *x)                                       \
    {                                                                                  \
        double of[LANES], m;                                                           \
        memcpy(of, x, sizeof of);                                                      \
        for (whole t = LANES; t < n; t += LANES)                                       \
            for (int j = 0; j < LANES; j++) of[j] = CHOSEN(of[j], x[t + j]);           \
        m = of[0];                                                                     \
        for (int j = 1; j < LANES; j++) m = CHOSEN(m, of[j]);                          \
        return m;                                                                      \
    }
ONE_OF_ALL(greatest, GREATER)
ONE_OF_ALL(least, LESSER)

static double total(whole n, const double *restrict x, const double *restrict weights)
{
    double part[LANES] = {0.0}, sum = 0.0;
    for (whole t = 0; t < n; t += LANES)
        for (int j = 0; j < LANES; j++) part[j] += x[t + j] * weights[t + j];
    for (int j = 0; j < LANES; j++) sum += part[j];
    return sum;
}

static double ramp(double t, double change, double rise, double fall)
{
    return change >= 0.0 ? LESSER(rise * t, change) : GREATER(fall * t, change);
}

static void summed(whole n, const double *a, double v0, double h, double *v)
{
    double sum = 0.0;
    v[0] = v0;
    for (whole t = 1; t < n; t++) {
        sum += 0.5 * h * (a[t] + a[t - 1]);
        v[t] = v0 + sum;
    }
}

static void speed_history(const Family *f, const double *phase, double *a, double *v, double *way)
{
    const whole n = f->samples;
    const double first = phase[0], then = phase[2], change = first - f->acceleration0, h = f->times[1] - f->times[0];
    const double reached = change / (change >= 0.0 ? f->rise : f->fall), begins = GREATER(phase[1], reached);
    double last = 0.0, passed = 0.0;
    whole since = -1;
    for (whole t = 0; t < n; t++) {
        const double after = GREATER(f->times[t] - begins, 0.0);
        a[t] = f->acceleration0 + ramp(f->times[t], change, f->rise, f->fall) + ramp(after, then - first, f->rise, f->fall);
    }
    summed(n, a, f->speed0, h, v);
    for (whole t = 0; t < n && since < 0; t++)
        if (v[t] > f->top) since = t;
    if (since >= 0) {
        last = a[since > 0 ? since - 1 : 0];
        for (whole t = since; t < n; t++) {
            const double eased = last + f->fall * h * (double)(t - since + 1);
            a[t] = GREATER(eased, 0.0);
        }
        summed(n, a, f->speed0, h, v);
    }
    since = n;
    for (whole t = n - 1; t >= 0; t--)
        if (v[t] <= 1e-6) since = t;
    way[0] = 0.0;
    for (whole t = 1; t < n; t++) {
        double step = h * (v[t - 1] + h * (2.0 * a[t - 1] + a[t]) / 6.0);
        if (t > since) step = 0.0;
        if (t == since) {
            const double braked = 0.5 * (v[t - 1] * v[t - 1]) / GREATER(-a[t - 1], 1e-3), kept = h * GREATER(v[t - 1], 0.0);
            step = LESSER(braked, kept);
        }
        passed += step;
        way[t] = passed;
    }
    for (whole t = since; t < n; t++) a[t] = v[t] = 0.0;
    for (whole t = n; t < ROW; t++) a[t] = a[n - 1], v[t] = v[n - 1], way[t] = way[n - 1];
}

/* what all members of a phase share: its speeds, and how the car's own heading and curvature fade over its way */
PUBLIC void mcdas_family_speeds(const Family *f)
{
    const whole n = ROW;
    const double join = f->join;
    for (whole p = 0; p < f->count_of_phases; p++) {
        double *restrict q = f->by_phase + p * OF_PHASE * n;
        speed_history(f, f->phases + 3 * p, q + ACCELERATION * n, q + SPEED * n, q + WAY * n);
        for (whole t = 0; t < n; t++) {
            const double x = q[WAY * n + t] / join, fade = exp(-x);
            q[FADE * n + t] = x * fade;
            q[FADE_N * n + t] = x * x * fade;
            q[SLOPE * n + t] = (1.0 - x) * fade / join;
            q[SLOPE_N * n + t] = (2.0 - x) * x * fade / join;
            q[CURL * n + t] = (x - 2.0) * fade / (join * join);
            q[CURL_N * n + t] = (2.0 - 4.0 * x + x * x) * fade / (join * join);
            q[ROAD * n + t] = f->count_of_knots ? curvature_at(f->s0 + q[WAY * n + t], f->count_of_knots, f->knots, f->kappas) : 0.0;
        }
    }
}

static double nearest(const Family *f, const double *history, double index)
{
    const double last = (double)(f->samples - 1), at = rint(index);
    return history[(whole)(at < 0.0 ? 0.0 : LESSER(at, last))];
}

/* the body's path (OF_MEMBER, ROW) of a lane-change profile at the speeds of a phase */
static void roll_out(const Family *f, const double *q, const double *step, double *restrict w)
{
    const whole n = ROW;
    const double h = f->times[1] - f->times[0], target = step[0], lateral = step[1], delay = step[2], b = step[3], join = f->join, c = f->centre;
    const double shift = target - f->d0, size = GREATER(fabs(shift), LEAST_SHIFT_M);
    const double v = nearest(f, q + SPEED * n, (delay + 1.22 * sqrt(size / lateral)) / h);
    const double a = -sqrt(PEAK * lateral / size) / GREATER(v, SPEED_FLOOR_MPS);
    const double begin = nearest(f, q + WAY * n, delay / h), rest = b * exp(-a * begin), height = shift * (1.0 + rest) / rest;
    const double at_0 = 1.0 / (1.0 + b * exp(-a * begin)), gain = height * a;
    const double slope0 = -gain * at_0 * (1.0 - at_0), curl0 = gain * a * at_0 * (1.0 - at_0) * (1.0 - 2.0 * at_0);
    const double m = f->sine0 - slope0, turn = 0.5 * (f->bend0 - curl0) + m / join;
    const double base = f->d0 - height * at_0, of_m = m * join, of_n = turn * (join * join);
    double *restrict d = w + WAY_D * n, *restrict s = w + WAY_S * n, *restrict sine = w + SINE * n, *restrict cosine = w + COSINE * n;
    double *restrict curvature = w + CURVATURE * n, *restrict ratio = w + SCRATCH * n, passed = 0.0;
    const double *way = q + WAY * n, *kappa = q + ROAD * n;
    for (whole t = 0; t < n; t++) {
        const double x = (way[t] - begin) * a;
        ratio[t] = exp(LESSER(x, 80.0));
    }
    for (whole t = 0; t < n; t++) {
        const double e = ratio[t] * b, shape = 1.0 / (1.0 + e), bell = e * shape * shape, slope = -gain * bell;
        const double tilt = slope + of_m * q[SLOPE * n + t] + of_n * q[SLOPE_N * n + t];
        const double curl = slope * (shape * -2.0 + 1.0) * -a + of_m * q[CURL * n + t] + of_n * q[CURL_N * n + t];
        d[t] = height * shape + base + of_m * q[FADE * n + t] + of_n * q[FADE_N * n + t];
        sine[t] = GREATER(LESSER(tilt, 0.9), -0.9);
        cosine[t] = sqrt(1.0 - sine[t] * sine[t]);
        ratio[t] = cosine[t] / (1.0 - kappa[t] * d[t]);
        curvature[t] = curl / cosine[t];
    }
    s[0] = f->s0;
    for (whole t = 1; t < n; t++) {
        passed += 0.5 * (way[t] - way[t - 1]) * (ratio[t] + ratio[t - 1]);
        s[t] = f->s0 + passed;
    }
    if (!f->count_of_knots) {
        for (whole t = 0; t < n; t++) {
            d[t] += c * sine[t];
            s[t] += c * cosine[t];
        }
        return;
    }
    for (whole t = 0, knot = 0; t < n; t++) {
        knot = t ? knot_beside(knot, s[t], f->count_of_knots, f->knots) : knot_before(s[t], f->count_of_knots, f->knots);
        ratio[t] = value_behind(knot, s[t], f->count_of_knots, f->knots, f->kappas);
    }
    for (whole t = 0; t < n; t++) {
        const double k = ratio[t], along = cosine[t], across = sine[t], turned = sin(k * c), straight = sqrt(1.0 - turned * turned);
        curvature[t] += k * along / (1.0 - k * d[t]);
        s[t] += c * along / (1.0 - k * d[t]);
        d[t] += c * across - 0.5 * k * ((c * along) * (c * along));
        sine[t] = across * straight - along * turned;
        cosine[t] = along * straight + across * turned;
    }
}

static int possible(const Family *f, const double *restrict q, double *restrict w)
{
    const whole n = ROW;
    const double *restrict curvature = w + CURVATURE * n;
    double *restrict used = w + SCRATCH * n;
    for (whole t = 0; t < n; t++) {
        const double v = q[SPEED * n + t], a = q[ACCELERATION * n + t], lateral = v * v * curvature[t];
        used[t] = a * a + lateral * lateral;
    }
    if (greatest(n, used) > f->grip_squared) return 0;
    for (whole t = 0; t < n; t++) used[t] = fabs(curvature[t]);
    if (greatest(n, used) > f->curvature_max) return 0;
    used[n - 1] = -1.0;
    for (whole t = 0; t < n - 1; t++) /* the tangent of a difference of steering angles, brought to one side */
        used[t] = fabs(curvature[t + 1] - curvature[t]) - f->turn_max * (1.0 + f->wheelbase * f->wheelbase * curvature[t + 1] * curvature[t]);
    return greatest(n, used) <= 0.0;
}

static int on_road(const Family *f, double *restrict w)
{
    const whole n = ROW;
    double *restrict out = w + SCRATCH * n;
    if (f->count_of_edges) {
        const Edges edges = {f->edges, f->count_of_edges};
        for (whole t = 0; t < n; t++) {
            const double room = 0.5 * (f->width * w[COSINE * n + t] + f->length * fabs(w[SINE * n + t])) + EDGE_M, d = w[WAY_D * n + t];
            out[t] = beyond_edges(&edges, w[WAY_S * n + t], 0.5 * f->length, d + room, d - room);
        }
    } else for (whole t = 0; t < n; t++) {
        const double room = 0.5 * (f->width * w[COSINE * n + t] + f->length * fabs(w[SINE * n + t])) + EDGE_M, d = w[WAY_D * n + t];
        out[t] = GREATER(d + room - f->left, f->right - (d - room));
    }
    if (greatest(n, out) > 0.0) return 0;
    return greatest(n, w + WAY_S * n) + 0.5 * f->length + EDGE_M <= f->end;
}

/* the separation from the nearest body at each sample, of those up to the first that comes no farther off than `enough`; whether any is near */
static int separations(const Family *f, double enough, double *restrict w)
{
    const whole n = ROW;
    const double *restrict s = w + WAY_S * n, *restrict d = w + WAY_D * n, *restrict sine = w + SINE * n, *restrict cosine = w + COSINE * n;
    double *restrict best = w + NEAREST * n, *restrict who = w + WHO * n, *restrict room = w + SCRATCH * n;
    const double long_half = 0.5 * f->length, wide_half = 0.5 * f->width;
    for (whole t = 0; t < n; t++) best[t] = NEAR_M, who[t] = -1.0;
    for (whole i = 0; i < f->count_of_bodies; i++) {
        const double *restrict o = f->bodies + i * OF_BODY * n, bow = f->sizes[4 * i + 3], wider = bow != 0.0 ? 2.0 : 1.0;
        for (whole t = 0; t < n; t++) {
            const double a = o[BODY_LONG * n + t], b = o[BODY_WIDE * n + t];
            room[t] = fabs(s[t] - o[BODY_S * n + t]) - (f->reach + sqrt(a * a + b * b) + NEAR_M) * wider;
        }
        if (least(n, room) >= 0.0) continue;
        for (whole t = 0; t < n; t++) {
            const double y = o[BODY_D * n + t] - d[t], other_long = o[BODY_LONG * n + t], other_wide = o[BODY_WIDE * n + t];
            const double x = (o[BODY_S * n + t] - s[t]) * (1.0 - o[BODY_KAPPA * n + t] * 0.5 * (o[BODY_D * n + t] + d[t]));
            const double its_sine = o[BODY_SINE * n + t], its_cosine = o[BODY_COSINE * n + t];
            const Gaps g = gaps_between(x, y, sine[t], cosine[t], its_sine, its_cosine, long_half, wide_half, other_long, other_wide);
            const double own = GREATER(g.ahead, g.aside), its = GREATER(g.its_ahead, g.its_aside), gap = GREATER(own, its) - bow;
            const double near = room[t] < 0.0 ? gap : NEAR_M;
            who[t] = near < best[t] ? (double)i : who[t];
            best[t] = LESSER(near, best[t]);
        }
        if (least(n, best) <= enough) break;
    }
    return greatest(n, who) >= 0.0;
}

static double end_closing(const Family *f, const double *q, const double *w)
{
    const whole n = ROW, t = n - 1;
    const double s = w[WAY_S * n + t], d = w[WAY_D * n + t], v = q[SPEED * n + t];
    double cost = 0.0;
    for (whole i = 0; i < f->count_of_bodies; i++) {
        const double *o = f->bodies + i * OF_BODY * n, *size = f->sizes + 4 * i;
        const double ahead = o[BODY_S * n + t] - s, apart = fabs(ahead) - 0.5 * (f->length + size[0]), gap = GREATER(apart, 1.0);
        const double sign = (double)((ahead > 0.0) - (ahead < 0.0)), faster = sign * (v - size[2]), closing = GREATER(faster, 0.0);
        if (fabs(o[BODY_D * n + t] - d) - 0.5 * (size[1] + f->width) <= f->end_room) cost += f->cost_closing * closing * closing / gap;
    }
    return cost;
}

/* what a phase costs, whatever its lane change */
static double cost_along(const Family *f, const double *restrict q)
{
    const whole n = ROW;
    const double *restrict v = q + SPEED * n, *restrict a = q + ACCELERATION * n, h = f->times[1] - f->times[0];
    double *restrict scratch = f->work + SCRATCH * n, push;
    for (whole t = 0; t < n; t++) scratch[t] = a[t] * a[t];
    push = f->cost_acceleration * total(n, scratch, f->weights);
    for (whole t = 0; t < n; t++) scratch[t] = (v[t] - f->wanted) * (v[t] - f->wanted);
    return h * (push + f->cost_speed * total(n, scratch, f->weights));
}

static double cost_across(const Family *f, const double *restrict q, const double *restrict w)
{
    const whole n = ROW;
    const double *restrict v = q + SPEED * n, *restrict curvature = w + CURVATURE * n, h = f->times[1] - f->times[0];
    double *restrict scratch = f->work + SCRATCH * n;
    for (whole t = 0; t < n; t++) {
        const double lateral = v[t] * v[t] * curvature[t];
        scratch[t] = lateral * lateral;
    }
    return h * f->cost_lateral * total(n, scratch, f->weights);
}

static double cost_near(const Family *f, const double *restrict gap)
{
    const whole n = ROW;
    double *restrict scratch = f->work + SCRATCH * n;
    for (whole t = 0; t < n; t++) scratch[t] = exp(GREATER(gap[t], 0.0) * (-1.0 / f->nearness));
    return (f->times[1] - f->times[0]) * f->cost_near * total(n, scratch, f->weights);
}

static double cost_change(const Family *f, const double *w)
{
    return fabs(w[WAY_D * ROW + ROW - 1] - f->lane_d) > f->half_lane ? f->cost_change : 0.0;
}

/* results (OF_RESULT, phases, steps) of every member */
PUBLIC void mcdas_family_score(const Family *f, double *result)
{
    const whole n = ROW, size = f->count_of_phases * f->count_of_steps;
    double *w = f->work;
    for (whole p = 0; p < f->count_of_phases; p++) {
        const double *q = f->by_phase + p * OF_PHASE * n, along = cost_along(f, q);
        for (whole k = 0; k < f->count_of_steps; k++) {
            double *to = result + p * f->count_of_steps + k, cost;
            roll_out(f, q, f->steps + 4 * k, w);
            cost = cost_across(f, q, w) + along;
            to[POSSIBLE * size] = possible(f, q, w);
            to[ON_ROAD * size] = on_road(f, w);
            to[SEPARATION * size] = NEAR_M;
            to[CONTACT * size] = HUGE_VAL;
            to[WITH * size] = -1.0;
            if (separations(f, -HUGE_VAL, w)) {
                const double *gap = w + NEAREST * n, lowest = least(n, gap);
                to[SEPARATION * size] = lowest;
                for (whole t = 0; t < n && lowest <= f->clear; t++)
                    if (gap[t] <= f->clear) {
                        to[CONTACT * size] = f->times[t];
                        to[WITH * size] = w[WHO * n + t];
                        break;
                    }
                cost += cost_near(f, gap);
            }
            cost += cost_change(f, w);
            to[COST * size] = cost + end_closing(f, q, w);
        }
    }
}

/* The cheapest feasible member of each kind, costs in whole TICKs, ties to the first: its index, or -1, its cost and its separation. What
 * is already dearer without nearness than the best of its kind is looked at no further: sums of what is not negative, rounded, never
 * shrink. `order` (phases) is room to work in; `values` (3, kinds): ticks,
 * costs, separations. */
PUBLIC void mcdas_family_best(const Family *f, const whole *kinds, whole count_of_kinds, double *order, whole *best, double *values)
{
    const whole n = ROW;
    double *w = f->work, *ticks = values, *cost = ticks + count_of_kinds, *separation = cost + count_of_kinds;
    for (whole i = 0; i < count_of_kinds; i++) best[i] = -1, ticks[i] = cost[i] = HUGE_VAL, separation[i] = NEAR_M;
    for (whole p = 0; p < f->count_of_phases; p++) order[p] = cost_along(f, f->by_phase + p * OF_PHASE * n);
    for (whole done = 0; done < f->count_of_phases; done++) {
        whole p = 0;
        for (whole i = 1; i < f->count_of_phases; i++)
            if (order[i] < order[p]) p = i;
        const double *q = f->by_phase + p * OF_PHASE * n, along = order[p];
        order[p] = HUGE_VAL;
        for (whole k = 0; k < f->count_of_steps; k++) {
            const whole index = p * f->count_of_steps + k, kind = kinds[index];
            double sum, change, closing, tick, lowest = NEAR_M;
            if (rint(along / TICK) > ticks[kind]) continue;
            roll_out(f, q, f->steps + 4 * k, w);
            sum = cost_across(f, q, w) + along;
            change = cost_change(f, w);
            closing = end_closing(f, q, w);
            if (rint((sum + change + closing) / TICK) > ticks[kind] || !possible(f, q, w) || !on_road(f, w)) continue;
            if (separations(f, f->clear, w)) {
                lowest = least(n, w + NEAREST * n);
                if (lowest <= f->clear) continue;
                sum += cost_near(f, w + NEAREST * n);
            }
            sum = sum + change + closing;
            tick = rint(sum / TICK);
            if (tick < ticks[kind] || (tick == ticks[kind] && index < best[kind]))
                best[kind] = index, ticks[kind] = tick, cost[kind] = sum, separation[kind] = lowest;
        }
    }
}

/* (samples, 6): s, d, psi, v, a, delta of one member */
PUBLIC void mcdas_family_states(const Family *f, whole phase, whole step, double *x)
{
    const whole n = ROW;
    const double *q = f->by_phase + phase * OF_PHASE * n;
    double *w = f->work;
    roll_out(f, q, f->steps + 4 * step, w);
    for (whole t = 0; t < f->samples; t++, x += 6) {
        x[0] = w[WAY_S * n + t];
        x[1] = w[WAY_D * n + t];
        x[2] = asin(w[SINE * n + t]);
        x[3] = q[SPEED * n + t];
        x[4] = q[ACCELERATION * n + t];
        x[5] = atan(f->wheelbase * w[CURVATURE * n + t]);
    }
}
