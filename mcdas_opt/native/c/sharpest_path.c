/* The search of `reference.offset_path` for the steepest path that keeps a bound on curvature. */
#include "mcdas.h"
#include "generated/sharpest_path_numbers.h"

#ifdef VECTOR_MATH
double exp(double) OF_VECTORS;
double sin(double) OF_VECTORS;
#endif

typedef struct {
    const double *along, *rising;    /* (ALONG): shares of the path's length, the sigmoid there */
    const double *around, *squeezed; /* (AROUND): shares of the bend's width, the hump there */
    double bound, b, amplitude, bend, bend_x, width, end;
} Search;

static int over_bound(const Search *q, double a, double inside, double shape, double share, double h)
{
    const double gain = (q->b + 1.0) / (q->b - 1.0), r = (shape - 1.0 / (1.0 + q->b)) * gain;
    const double r1 = (shape - shape * shape) * inside * (gain * a), slope = (-2.0 / q->width) * share * h, level = q->amplitude + h;
    const double first = r1 * level + r * slope, bow = (4.0 * share * share - 2.0) / (q->width * q->width);
    const double second = r1 * (a * (1.0 - 2.0 * shape) * level + 2.0 * slope) + r * h * bow, straight = 1.0 + first * first;
    return !(fabs(second) <= q->bound * straight * sqrt(straight));
}

static int keeps(const Search *q, double a)
{
    int over = 0;
    for (int i = 0; i < ALONG; i++) {
        const double share = (q->along[i] * q->end / a - q->bend_x) / q->width;
        over += over_bound(q, a, 1.0, q->rising[i], share, q->bend * exp(-share * share));
    }
    if (over) return 0;
    for (int i = 0; i < AROUND; i++) {
        const double x = a * (q->bend_x + q->width * q->around[i]), low = GREATER(x, 0.0), on = LESSER(low, q->end);
        const double inside = x == on ? 1.0 : 0.0, shape = 1.0 / (1.0 + q->b * exp(-on));
        over += over_bound(q, a, inside, shape, q->around[i], q->bend * q->squeezed[i]);
    }
    return !over;
}

PUBLIC double mcdas_sharpest(const double *tables, double low, double high, double bound, double b, double amplitude, double bend,
                             double bend_x, double width)
{
    const double *around = tables + 2 * ALONG;
    const Search q = {tables, tables + ALONG, around, around + AROUND, bound, b, amplitude, bend, bend_x, width, 2.0 * log(b)};
    if (!keeps(&q, low)) return low;
    for (int round = 0; round < ROUNDS; round++) {
        const double step = (high - low) / (TRIED - 1);
        double kept = low, next = high;
        int i = 1;
        for (; i < TRIED; i++) {
            next = i == TRIED - 1 ? high : low + i * step;
            if ((round > 0 && i == TRIED - 1) || !keeps(&q, next)) break;
            kept = next;
        }
        if (i == TRIED) return high;
        low = kept, high = next;
    }
    return low;
}
