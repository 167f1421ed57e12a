/* What drives cost over time: `planning.cost`, in its order of sums. */
#include "mcdas.h"

typedef struct {
    double acceleration, lateral, jerk, speed, headway, nearness, discomfort;   /* weights */
    double most_acceleration, most_braking, most_jerk;                          /* that is comfortable */
} Costs;

/* Of drives (drives, 9, n): lateral acceleration (drives, n), the desired speed, one number (each 0) or (drives, n) (each 1), where there is
 * anybody the share of the headway that is missing and exp of how near he is (drives, n); the cost per second (drives, n). */
PUBLIC void mcdas_cost_rate(whole drives, whole n, const double *tables, const double *lateral, const double *desired, whole each,
                            const double *missing, const double *near, const Costs *of, double *rate)
{
    for (whole i = 0; i < drives; i++, tables += 9 * n) {
        const double *v = tables + 4 * n, *a = tables + 5 * n, *jerk = tables + 8 * n;
        for (whole k = 0; k < n; k++) {
            const whole at = i * n + k;
            const double off = v[k] - desired[each * at];
            double sum = of->acceleration * (a[k] * a[k]) + of->lateral * (lateral[at] * lateral[at]) + of->jerk * (jerk[k] * jerk[k]);
            sum = sum + of->speed * (off * off);
            if (of->discomfort > 0.0) {
                const double along = GREATER(a[k] / of->most_acceleration, -a[k] / of->most_braking);
                const double beyond = GREATER(GREATER(along, fabs(jerk[k]) / of->most_jerk) - 1.0, 0.0);
                sum = sum + of->discomfort * (beyond * beyond);
            }
            if (missing) {
                sum = sum + of->headway * (missing[at] * missing[at]);
                sum = sum + of->nearness * near[at];
            }
            rate[at] = sum;
        }
    }
}
