/* The gaps between two rectangles on the axes of both, by the separating-axis test: `geometry.rectangle`, with its order of sums. */
#ifndef RECTANGLES_H
#define RECTANGLES_H
#include "mcdas.h"

typedef struct {
    double ahead, aside;             /* on the first one's axes */
    double its_ahead, its_aside;     /* on the other's */
} Gaps;

/* the other one lies at x, y from the first; sines and cosines of their headings, half lengths and half widths */
static inline Gaps gaps_between(double x, double y, double sine, double cosine, double its_sine, double its_cosine, double length,
                                double width, double its_length, double its_width)
{
    const double c = fabs(cosine * its_cosine + sine * its_sine), s = fabs(sine * its_cosine - cosine * its_sine);
    const Gaps gap = {
        fabs(x * cosine + y * sine) - (length + its_length * c + its_width * s),
        fabs(y * cosine - x * sine) - (width + its_length * s + its_width * c),
        fabs(x * its_cosine + y * its_sine) - (its_length + length * c + width * s),
        fabs(y * its_cosine - x * its_sine) - (its_width + length * s + width * c),
    };
    return gap;
}

#endif
