/* The MPC step around the kernel above: start, the kernel's loop, and the warm start for the next step.
 * The same decisions as the Python engine's, in the same order. No memory is taken. */

#define ROWS (NC + BODIES) /* inequalities of a node */
#define INNER (NINNER + BODIES)

struct mcdas_mpc { /* behind it the kernel's own memory */
    double z[(NODES + 1) * NZ], h[NODES + 1];
};

static Work *work_of(mcdas_mpc *mpc) { return (Work *)((char *)mpc + (sizeof *mpc + 63) / 64 * 64); }

size_t mcdas_mpc_bytes(void) { return (sizeof(struct mcdas_mpc) + 63) / 64 * 64 + (size_t)mcdas_size(NODES, BODIES) + 64; }

mcdas_mpc *mcdas_mpc_init(void *memory, size_t bytes)
{
    const size_t past = (size_t)((uintptr_t)memory % 64);
    mcdas_mpc *mpc = (mcdas_mpc *)((char *)memory + (past ? 64 - past : 0));
    if (memory == NULL || bytes < mcdas_mpc_bytes()) return NULL;
    memset(mpc, 0, mcdas_mpc_bytes() - 64);
    mcdas_prepare(work_of(mpc), NODES, BODIES, VEHICLE, COLUMNS, COLUMN, FIXED, FIRST_OF_BODY);
    return mpc;
}

static int load(mcdas_mpc *mpc, const double *x0, const double *p, const double *steps_s, const mcdas_iterate *guess)
{
    for (int k = 0; k <= NODES; k++) {
        for (int j = 0; j < NX; j++) mpc->z[k * NZ + j] = k > 0 ? guess->x[k * NX + j] : x0[j];
        for (int j = 0; j < NU; j++) mpc->z[k * NZ + NX + j] = k < NODES ? guess->u[k * NU + j] : 0.0;
        mpc->h[k] = steps_s[k < NODES ? k : NODES - 1];
    }
    if (guess->warm)
        return mcdas_warm(work_of(mpc), mpc->z, p, mpc->h, guess->s, guess->t, guess->multiplier, RULE.mu, LEAST_WARM);
    return mcdas_cold(work_of(mpc), mpc->z, p, mpc->h, MU_COLD, LEAST_COLD);
}

mcdas_ending mcdas_mpc_solve(mcdas_mpc *mpc, const double *x0, const double *p, const double *steps_s, const mcdas_iterate *guess,
                             int iterations, mcdas_answer *answer)
{
    double now[NUMBERS];
    const int warm = guess->warm, most = iterations > 0 ? iterations : MCDAS_ITERATIONS;
    const int finite = load(mpc, x0, p, steps_s, guess);
    mcdas_iterate *to = &answer->iterate;
    int ending = NOT_FINITE;

    if (to != guess) *to = *guess;
    memset(answer->slack, 0, sizeof answer->slack);
    answer->iterations = 0;
    answer->objective = answer->gap = NAN;
    answer->ending = MCDAS_NOT_FINITE;
    to->warm = 0;
    if (!finite) return answer->ending;
    ending = mcdas_loop(work_of(mpc), warm, most, &RULE, now, mpc->z, to->s, to->t, to->multiplier, answer->slack);
    answer->iterations = (int)now[DONE];
    if (ending == NOT_FINITE) return answer->ending;
    if (ending == INFEASIBLE) return answer->ending = MCDAS_INFEASIBLE;
    for (int k = 0; k <= NODES; k++) {
        for (int j = 0; j < NX; j++) to->x[k * NX + j] = mpc->z[k * NZ + j];
        for (int j = 0; j < NU && k < NODES; j++) to->u[k * NU + j] = mpc->z[k * NZ + NX + j];
    }
    to->warm = 1;
    answer->objective = now[OBJECTIVE];
    answer->gap = now[GAP];
    return answer->ending = ending == CONVERGED ? MCDAS_CONVERGED : MCDAS_LIMIT;
}

void mcdas_mpc_shift(mcdas_iterate *iterate)
{
    double *x = iterate->x, last[NX];
    for (int j = 0; j < NX; j++) {
        const double drawn_on = 2.0 * x[NODES * NX + j] - x[(NODES - 1) * NX + j];
        last[j] = LESSER(GREATER(drawn_on, X_LOWER[j]), X_UPPER[j]);
    }
    memmove(x, x + NX, sizeof(double) * NODES * NX);
    memcpy(x + NODES * NX, last, sizeof last);
    memmove(iterate->u, iterate->u + NU, sizeof(double) * (NODES - 1) * NU);
    memset(iterate->u + (NODES - 1) * NU, 0, sizeof(double) * NU);
    memmove(iterate->s, iterate->s + NS, sizeof(double) * NODES * NS);
    memmove(iterate->t, iterate->t + ROWS, sizeof(double) * NODES * ROWS);
    memmove(iterate->multiplier, iterate->multiplier + ROWS, sizeof(double) * NODES * ROWS);
    /* the inputs' bounds did not hold at the node that was the last: there is neither distance nor multiplier */
    memset(iterate->t + (NODES - 1) * ROWS + INNER, 0, sizeof(double) * (ROWS - INNER));
    memset(iterate->multiplier + (NODES - 1) * ROWS + INNER, 0, sizeof(double) * (ROWS - INNER));
}
