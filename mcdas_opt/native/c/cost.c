/* What drives cost over time: `planning.cost.driving_costs`, in its order of sums. */
#include "mcdas.h"

typedef struct {
    double acceleration, lateral, jerk, speed, headway, nearness, discomfort;   /* weights */
    double most_acceleration, most_braking, most_jerk;                          /* that is comfortable */
} Costs;

/* Of drives (drives, 9, n): lateral acceleration (drives, n), the desired speed, one number (each 0) or (drives, n) (each 1), where there is
 * anybody the share of the headway that is missing and exp of how near he is (drives, n); the cost of each interval (drives, n - 1). */
PUBLIC void mcdas_interval_costs(whole drives, whole n, const double *tables, const double *lateral, const double *desired, whole each,
                                 const double *missing, const double *near, const Costs *of, double *costs)
{
    for (whole i = 0; i < drives; i++, tables += 9 * n) {
        const double *v = tables + 4 * n, *a = tables + 5 * n, *jerk = tables + 8 * n;
        double before = 0.0;
        for (whole k = 0; k < n; k++) {
            const whole at = i * n + k;
            const double off = v[k] - desired[each * at];
            double rate = of->acceleration * (a[k] * a[k]) + of->lateral * (lateral[at] * lateral[at]) + of->jerk * (jerk[k] * jerk[k]);
            rate = rate + of->speed * (off * off);
            if (of->discomfort > 0.0) {
                const double along = GREATER(a[k] / of->most_acceleration, -a[k] / of->most_braking);
                const double beyond = GREATER(GREATER(along, fabs(jerk[k]) / of->most_jerk) - 1.0, 0.0);
                rate = rate + of->discomfort * (beyond * beyond);
            }
            if (missing) {
                rate = rate + of->headway * (missing[at] * missing[at]);
                rate = rate + of->nearness * near[at];
            }
            if (k > 0)
                *costs++ = 0.5 * (rate + before) * (tables[k] - tables[k - 1]);
            before = rate;
        }
    }
}
