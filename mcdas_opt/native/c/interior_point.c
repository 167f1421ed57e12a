/* The interior point's iteration over a horizon of any length, with any number of repeated rows (the bodies). Stage functions, their sizes
 * and the slack penalties are generated. No memory is taken, so instances may run in threads.
 *
 * Nodes lie in blocks of LANES: entry j of node k of an array of m entries a node is [(k / LANES * m + j) * LANES + k % LANES]. Those of the
 * repeated rows come row by row within a block. Nodes beyond the last one pad its block: no inequality is active there and nothing moves. */
#include "stage_functions.h"
#include "generated/lane_stage.h"

#define NEACH (3 * NZ + 4 * NS + 6 * NC + NP + ND + NVALUE + 3 * NX + NFEEDBACK + NMEMORY + NSUMS + 12) /* doubles of a node ... */
#define NREPEATED (6 + NROWP + NROWDATA)                                                                /* ... and of each body there */
#define BLOCKS(nodes) ((nodes) / LANES + 1)
#define WORK_DOUBLES(nodes, bodies) ((NEACH + (bodies) * NREPEATED) * LANES * BLOCKS(nodes))

typedef struct {
    int nodes, bodies, blocks, columns; /* columns: parameters of a node, as they come */
    whole first_of_body;                /* the column of the first of the bodies' parameters */
    whole column[NP + 1];               /* of the others, or -1: then it is `fixed` */
    double fixed[NP + 1], numbers[NNUMBERS];
    double *z, *s, *t, *lam, *p, *h, *flags, *data, *reach, *target, *gradient, *slack, *value, *costate, *feedback, *memory;
    double *dx, *dz, *ds, *dt, *dlam, *ratios, *cost, *gap, *least, *following, *sums, *worst, *spare;
    double *body_t, *body_lam, *body_p, *body_data, *body_target, *body_dt, *body_dlam, *body_spare;
} Work;

static double *of_node(double *a, int k, int entries) { return a + k / LANES * entries * LANES + k % LANES; }

static double largest_of(double *a, int entries, int entry, int blocks)
{
    double m[LANES], all;
    for (int j = 0; j < LANES; j++) m[j] = a[entry * LANES + j];
    for (int b = 1; b < blocks; b++)
        for (int j = 0; j < LANES; j++) m[j] = GREATER(a[(b * entries + entry) * LANES + j], m[j]);
    all = m[0];
    for (int j = 1; j < LANES; j++) all = GREATER(m[j], all);
    return all;
}

static double total_of(const Work *w, double *a, int entries, int entry)
{
    double m = 0.0;
    for (int k = 0; k <= w->nodes; k++) m += of_node(a, k, entries)[entry * LANES];
    return m;
}

static int base_size(const Work *w) { return NC * LANES * w->blocks; }
static int body_size(const Work *w) { return w->bodies * LANES * w->blocks; }

static void add_products(double *m, int n, const double *t, const double *dt, const double *lam, const double *dlam, double primal, double dual)
{
    for (int i = 0; i < n; i += LANES)
        for (int j = 0; j < LANES; j++) m[j] += (t[i + j] + primal * dt[i + j]) * (lam[i + j] + dual * dlam[i + j]);
}

/* mean of (t + primal dt) (lam + dual dlam); what is inactive has lam = dlam = 0 */
static double complementarity(const Work *w, double primal, double dual)
{
    const int active = w->nodes * (NC + w->bodies);
    double m[LANES] = {0.0};
    add_products(m, base_size(w), w->t, w->dt, w->lam, w->dlam, primal, dual);
    add_products(m, body_size(w), w->body_t, w->body_dt, w->body_lam, w->body_dlam, primal, dual);
    return (((m[0] + m[1]) + (m[2] + m[3])) + ((m[4] + m[5]) + (m[6] + m[7]))) / GREATER(active, 1);
}

/* `size` entries of each node from `from`, where they lie `apart` from those of the node before, to those from `first` on of `entries`;
 * returns 0, or NaN when one is not finite */
static double gather(const Work *w, double *to, int entries, int first, const double *from, int size, int apart)
{
    double nothing = 0.0;
    for (int k = 0; k < w->blocks * LANES; k++)
        for (int j = 0; j < size; j++) {
            const double entry = from[(k <= w->nodes ? k : w->nodes) * apart + j];
            of_node(to, k, entries)[(first + j) * LANES] = entry;
            nothing += 0.0 * entry;
        }
    return nothing;
}

static void scatter(const Work *w, double *to, double *from, int entries, int first, int size, int apart)
{
    for (int k = 0; k <= w->nodes; k++)
        for (int j = 0; j < size; j++) to[k * apart + j] = of_node(from, k, entries)[(first + j) * LANES];
}

/* of the inequalities: the soft rows, the bodies, and the rest */
static double gather_rows(const Work *w, double *to, double *bodies, const double *from)
{
    const int all = NC + w->bodies;
    const double rows = gather(w, to, NC, 0, from, NROWS, all) + gather(w, bodies, w->bodies, 0, from + NROWS, w->bodies, all);
    return rows + gather(w, to, NC, NROWS, from + NROWS + w->bodies, NC - NROWS, all);
}

static void scatter_rows(const Work *w, double *to, double *from, double *bodies)
{
    const int all = NC + w->bodies;
    scatter(w, to, from, NC, 0, NROWS, all);
    scatter(w, to + NROWS, bodies, w->bodies, 0, w->bodies, all);
    scatter(w, to + NROWS + w->bodies, from, NC, NROWS, NC - NROWS, all);
}

static double gather_problem(Work *w, const double *z, const double *p, const double *h)
{
    double nothing = gather(w, w->z, NZ, 0, z, NZ, NZ) + gather(w, w->h, 1, 0, h, 1, 1);
    for (int j = 0; j < NP; j++) {
        if (w->column[j] >= 0) nothing += gather(w, w->p, NP, j, p + w->column[j], 1, w->columns);
        else nothing += gather(w, w->p, NP, j, w->fixed + j, 1, 0);
    }
    return nothing + gather(w, w->body_p, w->bodies * NROWP, 0, p + w->first_of_body, w->bodies * NROWP, w->columns);
}

/* the state of the node after each */
static void look_ahead(const Work *w)
{
    for (int b = 0; b < w->blocks; b++) {
        const double *z = w->z + b * NZ * LANES, *next = b + 1 < w->blocks ? z + NZ * LANES : z;
        double *to = w->following + b * NX * LANES;
        for (int j = 0; j < NX; j++) {
            for (int k = 0; k < LANES - 1; k++) to[j * LANES + k] = z[j * LANES + k + 1];
            to[j * LANES + LANES - 1] = next[j * LANES];
        }
    }
}

#define BLOCK(a, entries) (w->a + b * (entries) * LANES)
#define BODY(a, entries) (w->a + b * w->bodies * (entries) * LANES)

static void evaluate_all(Work *w)
{
    look_ahead(w);
    memset(w->sums, 0, sizeof(double) * NSUMS * LANES * w->blocks);
    for (int b = 0; b < w->blocks; b++) {
        row_evaluate(w->bodies, BLOCK(z, NZ), BLOCK(s, NS), BODY(body_t, 1), BODY(body_lam, 1), BODY(body_p, NROWP), BLOCK(flags, 2),
                     BLOCK(sums, NSUMS), w->numbers, BODY(body_data, NROWDATA), BODY(body_spare, 1));
        evaluate(BLOCK(z, NZ), BLOCK(s, NS), BLOCK(t, NC), BLOCK(lam, NC), BLOCK(p, NP), BLOCK(h, 1), BLOCK(flags, 2),
                 BLOCK(following, NX), BLOCK(sums, NSUMS), w->numbers, BLOCK(data, ND), BLOCK(spare, NC), BLOCK(reach, 2));
    }
    memcpy(w->t, w->spare, sizeof(double) * base_size(w));
    memcpy(w->body_t, w->body_spare, sizeof(double) * body_size(w));
}

/* Newton's step for the targets; the first of two factorises. Gives the step lengths that reach the boundary. */
static void newton_step(Work *w, int factorise, double *primal, double *dual)
{
    const int last = w->nodes;
    memset(w->sums, 0, sizeof(double) * NYSUMS * LANES * w->blocks);
    for (int b = 0; b < w->blocks; b++) {
        row_gradient(w->bodies, BODY(body_data, NROWDATA), BODY(body_t, 1), BODY(body_target, 1), BLOCK(sums, NYSUMS));
        gradient(BLOCK(data, ND), BLOCK(s, NS), BLOCK(t, NC), BLOCK(target, NC), BLOCK(flags, 2), BLOCK(sums, NYSUMS),
                 BLOCK(gradient, NZ), BLOCK(slack, NS));
    }
#define NODE(a, k, entries) of_node(w->a, k, entries)
    if (factorise) {
        terminal(NODE(data, last, ND), NODE(gradient, last, NZ), NODE(value, last, NVALUE));
        for (int k = last - 1; k >= 0; k--)
            backward(NODE(value, k + 1, NVALUE), NODE(data, k, ND), NODE(gradient, k, NZ), NODE(value, k, NVALUE), NODE(feedback, k, NFEEDBACK),
                     NODE(memory, k, NMEMORY));
    } else {
        for (int j = 0; j < NX; j++) NODE(costate, last, NX)[j * LANES] = NODE(gradient, last, NZ)[j * LANES];
        for (int k = last - 1; k >= 0; k--)
            again(NODE(costate, k + 1, NX), NODE(data, k, ND), NODE(memory, k, NMEMORY), NODE(gradient, k, NZ), NODE(costate, k, NX),
                  NODE(feedback, k, NFEEDBACK) + NU * NX * LANES);
    }
    for (int j = 0; j < NX; j++) w->dx[j * LANES] = 0.0;
    for (int k = 0; k < last; k++)
        forward(NODE(dx, k, NX), NODE(data, k, ND), NODE(feedback, k, NFEEDBACK), NODE(dx, k + 1, NX), NODE(dz, k, NZ));
    for (int j = 0; j < NX; j++) NODE(dz, last, NZ)[j * LANES] = NODE(dx, last, NX)[j * LANES];
    for (int b = 0; b < w->blocks; b++) {
        steps(BLOCK(data, ND), BLOCK(slack, NS), BLOCK(t, NC), BLOCK(lam, NC), BLOCK(target, NC), BLOCK(flags, 2), BLOCK(dz, NZ),
              BLOCK(ds, NS), BLOCK(dt, NC), BLOCK(dlam, NC), BLOCK(ratios, 4));
        row_steps(w->bodies, BODY(body_data, NROWDATA), BODY(body_t, 1), BODY(body_lam, 1), BODY(body_target, 1), BLOCK(dz, NZ),
                  BLOCK(ds, NS), BLOCK(flags, 2), BLOCK(ratios, 4), BODY(body_dt, 1), BODY(body_dlam, 1));
    }
    *primal = 1.0 / GREATER(largest_of(w->ratios, 4, 0, w->blocks), 1e-9);
    *dual = 1.0 / GREATER(largest_of(w->ratios, 4, 1, w->blocks), 1e-9);
}

/* Bytes of an instance, which must begin at a multiple of 64. */
PUBLIC whole mcdas_size(whole nodes, whole bodies)
{
    return (whole)(sizeof(double) * (size_t)WORK_DOUBLES(nodes, bodies)) + (whole)((sizeof(Work) + 63) / 64 * 64);
}

/* `work` must be zeroed. `numbers`: what the problems of the family differ in; `column`: where each parameter of the text stands among the
 * `columns` of a node, or -1 where it is `fixed`; from `first_of_body` on stand those of the bodies, one body after the other. */
PUBLIC void mcdas_prepare(Work *w, whole nodes, whole bodies, const double *numbers, whole columns, const whole *column,
                          const double *fixed, whole first_of_body)
{
    double *free = (double *)((char *)w + (sizeof(Work) + 63) / 64 * 64);
    w->nodes = (int)nodes, w->bodies = (int)bodies, w->blocks = (int)BLOCKS(nodes), w->columns = (int)columns;
    w->first_of_body = first_of_body;
    for (int j = 0; j < NP; j++) w->column[j] = column[j], w->fixed[j] = fixed[j];
    memcpy(w->numbers, numbers, sizeof w->numbers);
#define TAKE(a, entries) (w->a = free, free += (entries) * LANES * w->blocks)
    TAKE(z, NZ), TAKE(gradient, NZ), TAKE(dz, NZ), TAKE(s, NS), TAKE(slack, NS), TAKE(ds, NS), TAKE(least, NS);
    TAKE(t, NC), TAKE(lam, NC), TAKE(target, NC), TAKE(dt, NC), TAKE(dlam, NC), TAKE(spare, NC), TAKE(p, NP), TAKE(h, 1), TAKE(flags, 2);
    TAKE(data, ND), TAKE(reach, 2), TAKE(value, NVALUE), TAKE(costate, NX), TAKE(feedback, NFEEDBACK), TAKE(memory, NMEMORY);
    TAKE(dx, NX), TAKE(following, NX), TAKE(ratios, 4), TAKE(cost, 1), TAKE(gap, 1), TAKE(sums, NSUMS), TAKE(worst, 1);
    TAKE(body_t, w->bodies), TAKE(body_lam, w->bodies), TAKE(body_target, w->bodies), TAKE(body_dt, w->bodies);
    TAKE(body_dlam, w->bodies), TAKE(body_spare, w->bodies), TAKE(body_p, w->bodies * NROWP), TAKE(body_data, w->bodies * NROWDATA);
    for (int k = 0; k <= w->nodes; k++) {
        of_node(w->flags, k, 2)[0] = k > 0;
        of_node(w->flags, k, 2)[LANES] = k < w->nodes;
    }
}

static void least_all(Work *w)
{
    memset(w->worst, 0, sizeof(double) * LANES * w->blocks);
    for (int b = 0; b < w->blocks; b++) row_least(w->bodies, BLOCK(z, NZ), BODY(body_p, NROWP), BLOCK(worst, 1), w->numbers);
}

/* These two start the iterate; they return 0 when something that was handed in is not finite. */
PUBLIC int mcdas_cold(Work *w, const double *z, const double *p, const double *h, double mu, double least)
{
    const double nothing = gather_problem(w, z, p, h);
    least_all(w);
    for (int b = 0; b < w->blocks; b++) {
        cold(BLOCK(z, NZ), BLOCK(p, NP), BLOCK(h, 1), BLOCK(flags, 2), mu, least, BLOCK(worst, 1), w->numbers, BLOCK(s, NS), BLOCK(t, NC),
             BLOCK(lam, NC));
        row_cold(w->bodies, BLOCK(z, NZ), BODY(body_p, NROWP), BLOCK(s, NS), BLOCK(flags, 2), mu, least, w->numbers, BODY(body_t, 1),
                 BODY(body_lam, 1));
    }
    return nothing == 0.0;
}

PUBLIC int mcdas_warm(Work *w, const double *z, const double *p, const double *h, const double *s, const double *t, const double *lam,
                      double mu, double least)
{
    const double nothing = gather_problem(w, z, p, h);
    const double more = gather(w, w->ds, NS, 0, s, NS, NS) + gather_rows(w, w->dt, w->body_dt, t) + gather_rows(w, w->dlam, w->body_dlam, lam);
    for (int b = 0; b < w->blocks; b++) {
        warm(BLOCK(z, NZ), BLOCK(ds, NS), BLOCK(dt, NC), BLOCK(dlam, NC), BLOCK(p, NP), BLOCK(h, 1), BLOCK(flags, 2), mu, least, w->numbers,
             BLOCK(s, NS), BLOCK(t, NC), BLOCK(lam, NC));
        row_warm(w->bodies, BLOCK(z, NZ), BLOCK(ds, NS), BODY(body_dt, 1), BODY(body_dlam, 1), BODY(body_p, NROWP), BLOCK(flags, 2), mu, least,
                 w->numbers, BODY(body_t, 1), BODY(body_lam, 1));
    }
    return nothing + more == 0.0;
}

static void aim(Work *w, double mu)
{
    for (int b = 0; b < w->blocks; b++) {
        const double *node = BLOCK(flags, 2), *moving = node + LANES;
        double *target = BLOCK(target, NC), *body = BODY(body_target, 1);
        for (int i = 0; i < NC; i++)
            for (int j = 0; j < LANES; j++) target[i * LANES + j] = (i < NINNER ? node[j] : moving[j]) * mu;
        for (int i = 0; i < w->bodies; i++)
            for (int j = 0; j < LANES; j++) body[i * LANES + j] = node[j] * mu;
    }
}

static void correct(double *target, const double *dt, const double *dlam, const double *active, double centre)
{
    const double cut = CORRECTION * centre;
    for (int j = 0; j < LANES; j++) {
        const double second = dt[j] * dlam[j], upper = LESSER(second, cut);
        target[j] = active[j] * (centre - GREATER(upper, -cut));
    }
}

static void move(double *to, const double *by, double length, int n)
{
    for (int i = 0; i < n; i++) to[i] += length * by[i];
}

/* numbers: step, residual, complementarity, primal, dual, total (see Progress) */
PUBLIC void mcdas_newton(Work *w, int corrected, double mu, double boundary, double longest, double *numbers)
{
    const int base = base_size(w), bodies = body_size(w);
    double primal, dual, left, other;
    evaluate_all(w);
    left = largest_of(w->reach, 2, 0, w->blocks), other = largest_of(w->reach, 2, 1, w->blocks);
    left = GREATER(left, other);
    if (corrected) {
        double average, reached, share, centre;
        memset(w->target, 0, sizeof(double) * base);
        memset(w->dt, 0, sizeof(double) * base);
        memset(w->dlam, 0, sizeof(double) * base);
        memset(w->body_target, 0, sizeof(double) * bodies);
        memset(w->body_dt, 0, sizeof(double) * bodies);
        memset(w->body_dlam, 0, sizeof(double) * bodies);
        average = complementarity(w, 0.0, 0.0);
        newton_step(w, 1, &primal, &dual);
        reached = complementarity(w, LESSER(1.0, primal), LESSER(1.0, dual));
        share = reached / average, centre = share * share * share * average;
        centre = GREATER(mu, centre);
        for (int b = 0; b < w->blocks; b++) {
            const double *node = BLOCK(flags, 2), *moving = node + LANES;
            for (int i = 0; i < NC; i++)
                correct(BLOCK(target, NC) + i * LANES, BLOCK(dt, NC) + i * LANES, BLOCK(dlam, NC) + i * LANES, i < NINNER ? node : moving, centre);
            for (int i = 0; i < w->bodies; i++)
                correct(BODY(body_target, 1) + i * LANES, BODY(body_dt, 1) + i * LANES, BODY(body_dlam, 1) + i * LANES, node, centre);
        }
        newton_step(w, 0, &primal, &dual);
    } else {
        aim(w, mu);
        newton_step(w, 1, &primal, &dual);
    }
    primal = LESSER(longest, boundary * primal);
    dual = LESSER(longest, boundary * dual);
    numbers[0] = largest_of(w->ratios, 4, 2, w->blocks);
    numbers[1] = (1.0 - primal) * left;
    numbers[2] = complementarity(w, primal, dual);
    numbers[3] = primal;
    numbers[4] = dual;
    numbers[5] = total_of(w, w->ratios, 4, 3);
    move(w->z, w->dz, primal, NZ * LANES * w->blocks);
    move(w->s, w->ds, primal, NS * LANES * w->blocks);
    move(w->t, w->dt, primal, base);
    move(w->lam, w->dlam, dual, base);
    move(w->body_t, w->body_dt, primal, bodies);
    move(w->body_lam, w->body_dlam, dual, bodies);
}

/* numbers: objective with the least slacks, largest scaled gap; and the iterate is written back */
PUBLIC void mcdas_measure(Work *w, double *numbers, double *z, double *s, double *t, double *lam, double *least)
{
    double objective;
    look_ahead(w);
    least_all(w);
    for (int b = 0; b < w->blocks; b++)
        measure(BLOCK(z, NZ), BLOCK(p, NP), BLOCK(h, 1), BLOCK(flags, 2), BLOCK(following, NX), BLOCK(worst, 1), w->numbers, BLOCK(cost, 1),
                BLOCK(gap, 1), BLOCK(least, NS));
    objective = total_of(w, w->cost, 1, 0);
    for (int j = 0; j < NS; j++)
        for (int k = 0; k <= w->nodes; k++) {
            const double slack = of_node(w->least, k, NS)[j * LANES];
            objective += slack * (PRICE_LINEAR[j] + 0.5 * PRICE_QUADRATIC[j] * slack);
        }
    numbers[0] = objective;
    numbers[1] = largest_of(w->gap, 1, 0, w->blocks);
    scatter(w, z, w->z, NZ, 0, NZ, NZ);
    scatter(w, s, w->s, NS, 0, NS, NS);
    scatter_rows(w, t, w->t, w->body_t);
    scatter_rows(w, lam, w->lam, w->body_lam);
    scatter(w, least, w->least, NS, 0, NS, NS);
}

enum { STEP, RESIDUAL, COMPLEMENTARITY, PRIMAL, DUAL, TOTAL, OBJECTIVE, GAP, DONE, NUMBERS };
enum { CONVERGED, LIMIT, NOT_FINITE, INFEASIBLE };

typedef struct {
    double step_tolerance, gap_tolerance, mu, boundary, plain_iterations, unbounded, step_length, half, shrunk, centred, diverged, blocked;
} Rule;

static int centred(const Rule *rule, const double *now, double longest)
{
    return now[COMPLEMENTARITY] < rule->centred * rule->mu && now[PRIMAL] > rule->step_length * longest;
}

static int settled(const Rule *rule, const double *now, double longest)
{
    return now[STEP] < rule->step_tolerance && now[RESIDUAL] < rule->gap_tolerance && centred(rule, now, longest);
}

static int turns_back(const Rule *rule, const double *before, const double *now, double longest)
{
    return centred(rule, now, longest) && now[STEP] > rule->shrunk * before[STEP] && now[TOTAL] * before[TOTAL] < 0.0;
}

/* Newton steps of a started iterate until the answer has settled, as `solvers/newton_loop.py` decides; `now` as the first enum has it. An
 * answer is written back as by mcdas_measure. */
PUBLIC int mcdas_loop(Work *w, int warm, int iterations, const Rule *rule, double *now, double *z, double *s, double *t, double *lam,
                      double *least)
{
    double before[NUMBERS], longest = 1.0;
    for (int i = 0; i < NUMBERS; i++) now[i] = NAN;
    now[DONE] = 0.0;
    for (int done = 1; done <= iterations; done++) {
        memcpy(before, now, sizeof before);
        now[DONE] = done;
        mcdas_newton(w, !warm || done > rule->plain_iterations, rule->mu, rule->boundary, longest, now);
        if (!(isfinite(now[TOTAL]) && now[STEP] < rule->diverged)) return NOT_FINITE;
        if (now[COMPLEMENTARITY] > rule->unbounded && now[PRIMAL] < rule->blocked) return INFEASIBLE;
        if (settled(rule, now, longest)) {
            mcdas_measure(w, now + OBJECTIVE, z, s, t, lam, least);
            if (now[GAP] < rule->gap_tolerance) return CONVERGED;
        }
        longest = turns_back(rule, before, now, longest) ? rule->half : 1.0;
    }
    mcdas_measure(w, now + OBJECTIVE, z, s, t, lam, least);
    return LIMIT;
}
