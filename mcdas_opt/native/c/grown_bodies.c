/* Half of neighbours' bodies, grown by a clearance and by what is not known of them: `planning.grown_bodies`, in its order of sums. */
#include "mcdas.h"

typedef struct {
    double half[2];                         /* of the body and its clearance, along and across [m] */
    double sigmas, growth, cap[2];          /* of the uncertainty: how many, until when it grows [s], at most [m] */
    double place[2], both[2], speed[2];     /* of the covariance, along and across */
} Grown;

/* grown (bodies, 2, n): along and across, at n times */
PUBLIC void mcdas_grown(whole bodies, whole n, const double *t, const Grown *of, double *grown)
{
    for (whole j = 0; j < bodies; j++, of++)
        for (int axis = 0; axis < 2; axis++)
            for (whole k = 0; k < n; k++) {
                const double grows = LESSER(t[k], of->growth);
                const double variance = of->place[axis] + 2.0 * grows * of->both[axis] + grows * grows * of->speed[axis];
                *grown++ = of->half[axis] + LESSER(of->sigmas * sqrt(GREATER(variance, 0.0)), of->cap[axis]);
            }
}
