/* The interior point's iteration over a horizon. The stage functions, their sizes (NX ... NFEEDBACK) and the slack penalties are generated
 * and stand before this text. No memory is taken, so instances may run in threads.
 *
 * Arrays hold entry j of node k at [j * LD + k]. Nodes beyond N pad the vectors: no inequality is active there and nothing moves. */

typedef struct {
    double z[NZ * LD], s[NS * LD + 1], t[NC * LD + 1], lam[NC * LD + 1];
    double p[NP * LD + 1], h[LD], flags[2 * LD], active[NC * LD + 1];
    double data[ND * LD], reach[2 * LD], target[NC * LD + 1], gradient[NZ * LD], slack[NS * LD + 1];
    double value[NVALUE * LD], costate[NX * LD], feedback[NFEEDBACK * LD], memory[NMEMORY * LD];
    double dx[NX * LD], dz[NZ * LD], ds[NS * LD + 1], dt[NC * LD + 1], dlam[NC * LD + 1], ratios[4 * LD];
    double cost[LD], gap[LD], least[NS * LD + 1];
    double spare[NC * LD + 1];
} Work;

static double largest(const double *a)
{
    double m[8];
    for (int j = 0; j < 8; j++) m[j] = a[j];
    for (int k = 8; k < LD; k += 8)
        for (int j = 0; j < 8; j++) m[j] = GREATER(a[k + j], m[j]);
    for (int j = 1; j < 8; j++) m[0] = GREATER(m[j], m[0]);
    return m[0];
}

static double total(const double *a)
{
    double m = 0.0;
    for (int k = 0; k <= NODES; k++) m += a[k];
    return m;
}

/* sum of (t + primal dt) (lam + dual dlam); what is inactive has lam = dlam = 0 */
static double complementarity(const Work *w, double primal, double dual)
{
    double m[8] = {0.0};
    for (int i = 0; i < NC * LD; i += 8)
        for (int j = 0; j < 8; j++) m[j] += (w->t[i + j] + primal * w->dt[i + j]) * (w->lam[i + j] + dual * w->dlam[i + j]);
    return (((m[0] + m[1]) + (m[2] + m[3])) + ((m[4] + m[5]) + (m[6] + m[7]))) / NACTIVE;
}

/* returns 0, or NaN when an entry is not finite */
static double gather(double *to, const double *from, int size)
{
    double nothing = 0.0;
    for (int k = 0; k < LD; k++)
        for (int j = 0; j < size; j++) {
            const double entry = from[(k <= NODES ? k : NODES) * size + j];
            to[j * LD + k] = entry;
            nothing += 0.0 * entry;
        }
    return nothing;
}

static void scatter(double *to, const double *from, int size)
{
    for (int k = 0; k <= NODES; k++)
        for (int j = 0; j < size; j++) to[k * size + j] = from[j * LD + k];
}

/* Newton's step for the targets; the first of two factorises. Gives the step lengths that reach the boundary. */
static void newton_step(Work *w, int factorise, double *primal, double *dual)
{
    gradient(w->data, w->s, w->t, w->target, w->flags, w->gradient, w->slack);
    if (factorise) {
        terminal(NODES, w->data, w->gradient, w->value);
        for (int k = NODES - 1; k >= 0; k--) backward(k, w->value + 1, w->data, w->gradient, w->value, w->feedback, w->memory);
    } else {
        for (int j = 0; j < NX; j++) w->costate[j * LD + NODES] = w->gradient[j * LD + NODES];
        for (int k = NODES - 1; k >= 0; k--)
            again(k, w->costate + 1, w->data, w->memory, w->gradient, w->costate, w->feedback + NU * NX * LD);
    }
    for (int j = 0; j < NX; j++) w->dx[j * LD] = 0.0;
    for (int k = 0; k < NODES; k++) forward(k, w->dx, w->data, w->feedback, w->dx + 1, w->dz);
    for (int j = 0; j < NX; j++) w->dz[j * LD + NODES] = w->dx[j * LD + NODES];
    steps(w->data, w->slack, w->t, w->lam, w->target, w->flags, w->dz, w->ds, w->dt, w->dlam, w->ratios);
    *primal = 1.0 / GREATER(largest(w->ratios), 1e-9);
    *dual = 1.0 / GREATER(largest(w->ratios + LD), 1e-9);
}

PUBLIC whole mcdas_size(void) { return (whole)sizeof(Work); }

/* `work` must be zeroed; arrays from outside hold the entries of a node side by side */
PUBLIC void mcdas_prepare(Work *w)
{
    for (int k = 0; k <= NODES; k++) {
        w->flags[k] = k > 0;
        w->flags[LD + k] = k < NODES;
        for (int i = 0; i < NC; i++) w->active[i * LD + k] = i < NINNER ? k > 0 : k < NODES;
    }
}

/* These two start the iterate; they return 0 when something that was handed in is not finite. */
PUBLIC int mcdas_cold(Work *w, const double *z, const double *p, const double *h, double mu, double least)
{
    const double nothing = gather(w->z, z, NZ) + gather(w->p, p, NP) + gather(w->h, h, 1);
    cold(w->z, w->p, w->h, w->flags, mu, least, w->s, w->t, w->lam);
    return nothing == 0.0;
}

PUBLIC int mcdas_warm(Work *w, const double *z, const double *p, const double *h, const double *s, const double *t, const double *lam,
                      double mu, double least)
{
    const double nothing = gather(w->z, z, NZ) + gather(w->p, p, NP) + gather(w->h, h, 1);
    const double more = gather(w->ds, s, NS) + gather(w->dt, t, NC) + gather(w->dlam, lam, NC);
    warm(w->z, w->ds, w->dt, w->dlam, w->p, w->h, w->flags, mu, least, w->s, w->t, w->lam);
    return nothing + more == 0.0;
}

/* numbers: step, residual, complementarity, primal, dual, total (see Progress) */
PUBLIC void mcdas_newton(Work *w, int corrected, double mu, double boundary, double longest, double *numbers)
{
    double primal, dual;
    evaluate(w->z, w->s, w->t, w->lam, w->p, w->h, w->flags, w->z + 1, w->data, w->spare, w->reach);
    memcpy(w->t, w->spare, sizeof(double) * NC * LD);
    const double left = GREATER(largest(w->reach), largest(w->reach + LD));
    if (corrected) {
        memset(w->target, 0, sizeof w->target);
        memset(w->dt, 0, sizeof w->dt);
        memset(w->dlam, 0, sizeof w->dlam);
        const double average = complementarity(w, 0.0, 0.0);
        newton_step(w, 1, &primal, &dual);
        const double reached = complementarity(w, LESSER(1.0, primal), LESSER(1.0, dual));
        const double share = reached / average;
        const double centre = GREATER(mu, share * share * share * average), cut = CORRECTION * centre;
        for (int i = 0; i < NC * LD; i++) {
            const double second = w->dt[i] * w->dlam[i], upper = LESSER(second, cut);
            w->target[i] = w->active[i] * (centre - GREATER(upper, -cut));
        }
        newton_step(w, 0, &primal, &dual);
    } else {
        for (int i = 0; i < NC * LD; i++) w->target[i] = w->active[i] * mu;
        newton_step(w, 1, &primal, &dual);
    }
    primal = LESSER(longest, boundary * primal);
    dual = LESSER(longest, boundary * dual);
    numbers[0] = largest(w->ratios + 2 * LD);
    numbers[1] = (1.0 - primal) * left;
    numbers[2] = complementarity(w, primal, dual);
    numbers[3] = primal;
    numbers[4] = dual;
    numbers[5] = total(w->ratios + 3 * LD);
    for (int i = 0; i < NZ * LD; i++) w->z[i] += primal * w->dz[i];
    for (int i = 0; i < NS * LD; i++) w->s[i] += primal * w->ds[i];
    for (int i = 0; i < NC * LD; i++) w->t[i] += primal * w->dt[i];
    for (int i = 0; i < NC * LD; i++) w->lam[i] += dual * w->dlam[i];
}

/* numbers: objective with the least slacks, largest scaled gap; and the iterate is written back */
PUBLIC void mcdas_measure(Work *w, double *numbers, double *z, double *s, double *t, double *lam, double *least)
{
    measure(w->z, w->p, w->h, w->flags, w->z + 1, w->cost, w->gap, w->least);
    double objective = total(w->cost);
    for (int j = 0; j < NS; j++)
        for (int k = 0; k <= NODES; k++) {
            const double slack = w->least[j * LD + k];
            objective += slack * (PRICE_LINEAR[j] + 0.5 * PRICE_QUADRATIC[j] * slack);
        }
    numbers[0] = objective;
    numbers[1] = largest(w->gap);
    scatter(z, w->z, NZ);
    scatter(s, w->s, NS);
    scatter(t, w->t, NC);
    scatter(lam, w->lam, NC);
    scatter(least, w->least, NS);
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
