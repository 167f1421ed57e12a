/* Signed separations of rectangles by the separating-axis test: `geometry.rectangle.separation_of_poses`, with its order of sums. */
#include "rectangles.h"

/* what `numpy.maximum` does: what is no number stays none */
static double larger(double a, double b) { return a > b || a != a ? a : b; }

/* One family against another at n times. Of each (count, n): x, y, and sine and cosine of the heading; `own` is (half length, half width),
 * `its` the same of each of the others, side by side. `apart` is (mine, others, n). */
PUBLIC void mcdas_separations(whole mine, whole others, whole n, const double *x, const double *y, const double *sine, const double *cosine,
                              const double *own, const double *its_x, const double *its_y, const double *its_sine,
                              const double *its_cosine, const double *its, double *apart)
{
    const double length = own[0], width = own[1];
    for (whole i = 0; i < mine; i++)
        for (whole j = 0; j < others; j++) {
            const double its_length = its[2 * j], its_width = its[2 * j + 1];
            for (whole k = 0; k < n; k++) {
                const whole a = i * n + k, b = j * n + k;
                const Gaps gap = gaps_between(its_x[b] - x[a], its_y[b] - y[a], sine[a], cosine[a], its_sine[b], its_cosine[b], length, width,
                                              its_length, its_width);
                apart[(i * others + j) * n + k] = larger(larger(larger(gap.ahead, gap.aside), gap.its_ahead), gap.its_aside);
            }
        }
}
