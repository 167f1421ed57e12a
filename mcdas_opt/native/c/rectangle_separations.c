/* Signed separations of rectangles by the separating-axis test: `geometry.rectangle.separation_of_poses`, with its order of sums. */
#include "mcdas.h"

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
                const double dx = its_x[b] - x[a], dy = its_y[b] - y[a];
                const double c = fabs(cosine[a] * its_cosine[b] + sine[a] * its_sine[b]);
                const double s = fabs(sine[a] * its_cosine[b] - cosine[a] * its_sine[b]);
                double gap = fabs(dx * cosine[a] + dy * sine[a]) - (length + its_length * c + its_width * s);
                gap = larger(gap, fabs(dy * cosine[a] - dx * sine[a]) - (width + its_length * s + its_width * c));
                gap = larger(gap, fabs(dx * its_cosine[b] + dy * its_sine[b]) - (its_length + length * c + width * s));
                apart[(i * others + j) * n + k] = larger(gap, fabs(dy * its_cosine[b] - dx * its_sine[b]) - (its_width + length * s + width * c));
            }
        }
}
