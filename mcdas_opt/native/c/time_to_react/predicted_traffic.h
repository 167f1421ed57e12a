/* The predicted traffic on the lattice, and the host under constant inputs. */

enum { AT, ASIDE, ALONG, ACROSS, FADE_S, SWELL, RATE, CHANGING_S, RESPONDS_S, BRAKES_WITH, LENGTH, WIDTH, MORE_LENGTH, MORE_WIDTH,
       CRUISER };

/* Where a body (CRUISER) is whose speed along changes, that responds, or whose speed across swells first; and for each box (TURNED_STEPS) how fast across it
 * goes at most from the step before it on, bare of its sign. `across` (lattice) is worked in. */
static void changing(whole lattice, const double *restrict x, const double *restrict times, double *restrict s, double *restrict d,
                     double *restrict v, double *restrict across, double *restrict fastest)
{
    const double at = x[AT], aside = x[ASIDE], along = x[ALONG], sideways = x[ACROSS], swell = x[SWELL], rate = x[RATE], until = x[CHANGING_S];
    const double settles = sideways * x[FADE_S], response = x[RESPONDS_S], braking = x[BRAKES_WITH];
    double later[LANES];
    for (int i = 0; i < LANES; i++) later[i] = exp(-LATTICE_S * i / x[FADE_S]);
    for (whole t = 0; t < lattice; t += LANES) { /* what is left of a speed that only fades */
        const double left = exp(-times[t] / x[FADE_S]);
        for (whole i = t; i < t + LANES && i < lattice; i++) d[i] = left * later[i - t];
    }
    for (whole t = 0; t < lattice; t++) {
        const double time = LESSER(times[t], response), lasted = LESSER(time, until), changed = rate * lasted;
        const double fade = d[t], risen = (1.0 + swell) / (1.0 + swell * fade);
        const double speed = times[t] > response ? GREATER(along + changed, 0.0) : along + changed;
        const double braked = LESSER(times[t] - time, GREATER(speed, 0.0) / braking);
        s[t] = at + along * time + changed * (time - 0.5 * lasted) + speed * braked - 0.5 * braking * braked * braked;
        v[t] = speed - braking * braked;
        d[t] = aside + settles * risen * (1.0 - fade);
        across[t] = fabs(sideways * risen * risen * fade);
    }
    for (whole t = 0; t < lattice; t += TURNED_STEPS) {
        const whole end = t + TURNED_STEPS < lattice ? t + TURNED_STEPS : lattice;
        double most = across[t > 0 ? t - 1 : 0];
        for (whole i = t; i < end; i++) most = GREATER(most, across[i]);
        fastest[t / TURNED_STEPS] = most;
    }
}

/* the same of one that keeps its speed, whose speed across only fades */
static void steady(whole lattice, const double *restrict x, const double *restrict times, const double *restrict fade, double *restrict s,
                   double *restrict d, double *restrict v, double *restrict fastest)
{
    const double at = x[AT], aside = x[ASIDE], along = x[ALONG], across = x[ACROSS], settles = across * x[FADE_S];
    for (whole t = 0; t < lattice; t++) {
        s[t] = at + along * times[t];
        d[t] = aside + settles * (1.0 - fade[t]);
        v[t] = along;
    }
    for (whole t = 0; t < lattice; t += TURNED_STEPS) fastest[t / TURNED_STEPS] = fabs(across * fade[t > 0 ? t - 1 : 0]);
}

/* half lengths and half widths of the boxes around a body that goes so fast across in each, as it is turned then; step by step */
static void boxed(whole lattice, const double *restrict x, double *restrict fastest, double *restrict half_length)
{
    const whole boxes = (lattice + TURNED_STEPS - 1) / TURNED_STEPS;
    const double slowest = GREATER(fabs(x[ALONG]), 1.0), length = x[LENGTH], width = x[WIDTH], longer = x[MORE_LENGTH], wider = x[MORE_WIDTH];
    double *half_width = fastest;
    for (whole i = 0; i < boxes; i++) {
        const double slope = fastest[i] / slowest, cosine = 1.0 / sqrt(1.0 + slope * slope), sine = slope * cosine;
        half_length[i] = 0.5 * (length + width * sine) + longer;
        half_width[i] = 0.5 * (width * cosine + length * sine) + wider;
    }
    for (whole i = boxes - 1, end = lattice; i >= 0; end = TURNED_STEPS * i--) {
        const double long_of = half_length[i], wide_of = half_width[i];
        for (whole t = TURNED_STEPS * i; t < end; t++) {
            half_length[t] = long_of;
            half_width[t] = wide_of;
        }
    }
}

/* Bodies that cruise (bodies, CRUISER) on the lattice, as `domain.prediction` has them, into tables (5, bodies, lattice):
 * places along and across, speeds, half lengths and half widths of the boxes around them. `fade` (lattice): what is left of speeds across
 * that fade in `fade_s` */
static void predicted(whole bodies, whole lattice, const double *begin, const double *times, double fade_s, const double *fade, double *tables)
{
    const whole all = bodies * lattice;
    for (whole j = 0; j < bodies; j++, begin += CRUISER) {
        double *s = tables + j * lattice, *d = s + all, *v = d + all, *half_length = v + all, *half_width = half_length + all;
        if (begin[SWELL] != 0.0 || begin[RATE] != 0.0 || begin[FADE_S] != fade_s || begin[RESPONDS_S] < HUGE_VAL)
            changing(lattice, begin, times, s, d, v, half_length, half_width);
        else
            steady(lattice, begin, times, fade, s, d, v, half_width);
        boxed(lattice, begin, half_width, half_length);
    }
}

/* The host that keeps its acceleration and its steering from x on, at times (q->moments), into the table (STATES, moments), with the sines and
 * the cosines of its headings in `path` (2, moments) */
static void constant_input(const Case *q, const double *x, const double *times, double *table, double *path)
{
    const whole n = q->moments;
    const double c = q->centre, turn = tan(x[STEERING]) / q->wheelbase, top = GREATER(q->speed_max, x[SPEED]);
    const double kappa0 = curvature(q, x[S]), psi0 = x[HEADING] + kappa0 * c, cosine0 = cos(psi0);
    const double d0 = x[D] - c * sin(psi0) + 0.5 * kappa0 * (c * cosine0) * (c * cosine0), s0 = x[S] - c * cosine0 / (1.0 - kappa0 * d0);
    double *s = table, *d = table + n, *psi = table + 2 * n, *v = table + 3 * n, *a = table + 4 * n, *way = table + 5 * n;
    double *sines = path, *cosines = path + n;
    for (whole t = 0; t < n; t++) {
        const double free = x[SPEED] + x[ACCELERATION] * times[t], capped = LESSER(free, top);
        v[t] = GREATER(capped, 0.0);
        a[t] = v[t] == free ? x[ACCELERATION] : 0.0;
        way[t] = t ? way[t - 1] + 0.5 * (v[t] + v[t - 1]) * (times[t] - times[t - 1]) : 0.0;
        s[t] = s0 + way[t];
        d[t] = d0;
    }
    for (int pass = 0; pass < (q->bend > 0.0 ? PASSES : 1); pass++) {
        double turned = 0.0, along = 0.0, across = 0.0, kappa_before = 0.0, s_before = 0.0, ratio_before = 0.0, sine_before = 0.0;
        for (whole t = 0; t < n; t++) {
            const double kappa = curvature(q, s[t]), step = t ? way[t] - way[t - 1] : 0.0;
            if (t) turned += 0.5 * (kappa + kappa_before) * (s[t] - s_before);
            s_before = s[t];
            kappa_before = kappa;
            psi[t] = psi0 + turn * way[t] - turned;
            const double sine = sines[t] = sin(psi[t]), cosine = cosines[t] = cos(psi[t]), ratio = cosine / (1.0 - kappa * d[t]);
            along += 0.5 * (ratio + ratio_before) * step;
            across += 0.5 * (sine + sine_before) * step;
            ratio_before = ratio;
            sine_before = sine;
            s[t] = s0 + along;
            d[t] = d0 + across;
        }
    }
    for (whole t = 0; t < n; t++) {
        const double kappa = curvature(q, s[t]), cosine = cosines[t], stretch = 1.0 - kappa * d[t];
        s[t] += c * cosine / stretch;
        d[t] += c * sines[t] - 0.5 * kappa * (c * cosine) * (c * cosine);
        psi[t] -= kappa * c;
        way[t] = x[STEERING];
        if (kappa == 0.0) continue;
        sines[t] = sin(psi[t]);
        cosines[t] = cos(psi[t]);
    }
}
