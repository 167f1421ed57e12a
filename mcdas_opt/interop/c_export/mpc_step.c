/* The MPC step around the kernel above: start, Newton steps until the answer has settled, and the warm start for the next step.
 * The same decisions as the Python engine's, in the same order. No memory is taken. */

struct mcdas_mpc {
    Work work;
    double z[(NODES + 1) * NZ], h[NODES + 1];
};

enum { STEP, RESIDUAL, COMPLEMENTARITY, PRIMAL, DUAL, TOTAL, NUMBERS };

size_t mcdas_mpc_bytes(void) { return sizeof(struct mcdas_mpc) + 64; }

mcdas_mpc *mcdas_mpc_init(void *memory, size_t bytes)
{
    const size_t past = (size_t)((uintptr_t)memory % 64);
    mcdas_mpc *mpc = (mcdas_mpc *)((char *)memory + (past ? 64 - past : 0));
    if (memory == NULL || bytes < mcdas_mpc_bytes()) return NULL;
    memset(mpc, 0, sizeof *mpc);
    mcdas_prepare(&mpc->work);
    return mpc;
}

static int centred(const double *now, double longest)
{
    return now[COMPLEMENTARITY] < CENTRED * MU_END && now[PRIMAL] > STEP_LENGTH * longest;
}

static int settled(const double *now, double longest)
{
    return now[STEP] < STEP_TOLERANCE && now[RESIDUAL] < GAP_TOLERANCE && centred(now, longest);
}

static int turns_back(const double *before, const double *now, double longest)
{
    return centred(now, longest) && now[STEP] > SHRUNK * before[STEP] && now[TOTAL] * before[TOTAL] < 0.0;
}

static int load(mcdas_mpc *mpc, const double *x0, const double *p, const double *steps_s, const mcdas_iterate *guess)
{
    for (int k = 0; k <= NODES; k++) {
        for (int j = 0; j < NX; j++) mpc->z[k * NZ + j] = k > 0 ? guess->x[k * NX + j] : x0[j];
        for (int j = 0; j < NU; j++) mpc->z[k * NZ + NX + j] = k < NODES ? guess->u[k * NU + j] : 0.0;
        mpc->h[k] = steps_s[k < NODES ? k : NODES - 1];
    }
    if (guess->warm)
        return mcdas_warm(&mpc->work, mpc->z, p, mpc->h, guess->s, guess->t, guess->multiplier, MU_END, LEAST_WARM);
    return mcdas_cold(&mpc->work, mpc->z, p, mpc->h, MU_COLD, LEAST_COLD);
}

static void unload(mcdas_mpc *mpc, mcdas_answer *answer)
{
    double worth[2];
    mcdas_iterate *to = &answer->iterate;
    mcdas_measure(&mpc->work, worth, mpc->z, to->s, to->t, to->multiplier, answer->slack);
    for (int k = 0; k <= NODES; k++) {
        for (int j = 0; j < NX; j++) to->x[k * NX + j] = mpc->z[k * NZ + j];
        for (int j = 0; j < NU && k < NODES; j++) to->u[k * NU + j] = mpc->z[k * NZ + NX + j];
    }
    to->warm = 1;
    answer->objective = worth[0];
    answer->gap = worth[1];
}

mcdas_ending mcdas_mpc_solve(mcdas_mpc *mpc, const double *x0, const double *p, const double *steps_s, const mcdas_iterate *guess,
                             int iterations, mcdas_answer *answer)
{
    double now[NUMBERS], before[NUMBERS], longest = 1.0;
    const int warm = guess->warm, most = iterations > 0 ? iterations : MCDAS_ITERATIONS;
    const int finite = load(mpc, x0, p, steps_s, guess);

    for (int i = 0; i < NUMBERS; i++) now[i] = NAN;
    if (&answer->iterate != guess) answer->iterate = *guess;
    memset(answer->slack, 0, sizeof answer->slack);
    answer->iterations = 0;
    answer->objective = answer->gap = NAN;
    answer->ending = MCDAS_NOT_FINITE;
    if (!finite) {
        answer->iterate.warm = 0;
        return answer->ending;
    }
    for (int done = 1; done <= most; done++) {
        answer->iterations = done;
        memcpy(before, now, sizeof now);
        mcdas_newton(&mpc->work, !warm || done > PLAIN_ITERATIONS, MU_END, BOUNDARY, longest, now);
        if (!(isfinite(now[TOTAL]) && now[STEP] < DIVERGED)) {
            answer->iterate.warm = 0;
            return answer->ending;
        }
        if (now[COMPLEMENTARITY] > UNBOUNDED * MU_COLD && now[PRIMAL] < BLOCKED) {
            answer->iterate.warm = 0;
            return answer->ending = MCDAS_INFEASIBLE;
        }
        if (settled(now, longest)) {
            unload(mpc, answer);
            if (answer->gap < GAP_TOLERANCE) return answer->ending = MCDAS_CONVERGED;
        }
        longest = turns_back(before, now, longest) ? HALF : 1.0;
    }
    unload(mpc, answer);
    return answer->ending = MCDAS_LIMIT;
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
    memmove(iterate->t, iterate->t + NC, sizeof(double) * NODES * NC);
    memmove(iterate->multiplier, iterate->multiplier + NC, sizeof(double) * NODES * NC);
    /* the inputs' bounds did not hold at the node that was the last: there is neither distance nor multiplier */
    memset(iterate->t + (NODES - 1) * NC + NINNER, 0, sizeof(double) * (NC - NINNER));
    memset(iterate->multiplier + (NODES - 1) * NC + NINNER, 0, sizeof(double) * (NC - NINNER));
}
