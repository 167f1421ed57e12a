/* How fast a car drives that goes towards a speed: `reference.speed_profile.speeds_along`, in its order of sums. */
#include "mcdas.h"

typedef struct {
    double speed, towards;                      /* now and in the end [m/s] */
    double rising, falling, late;               /* as fast as that, and where it comes too fast [m/s^2] */
    double step;                                /* between the places of the profile [m] */
    double closing_s, closing_mps2, near;       /* to who is ahead */
    double behind, as_hard;                     /* how hard who follows brakes: at least, and as a multiple */
    double standing, stopping_s, nearest;
    double two;                                 /* squares are powers, as they are of numbers of Python: the last bit differs from a product's */
} Speeds;

/* places: of the profile, 0 of none; ahead (cars, 3, n): room, speed, time gap; least (cars) is written over; found (n) */
PUBLIC void mcdas_speeds_along(whole n, const double *t, whole places, const double *profile, whole cars, const double *ahead,
                               const Speeds *of, double *least, double *found)
{
    double s = 0.0, v = of->speed;
    for (whole c = 0; c < cars; c++) {
        const double *its = ahead + (3 * c + 1) * n;
        least[c] = GREATER(of->behind, of->as_hard * (its[0] - its[1]) / (t[1] - t[0]));
    }
    found[0] = v;
    for (whole k = 1; k < n; k++) {
        const double h = t[k] - t[k - 1];
        s += v * h;
        double aim = of->towards > v ? LESSER(of->towards, v + of->rising * h) : GREATER(of->towards, v - of->falling * h);
        if (places > 0) {
            const whole at = (whole)(s / of->step), i = LESSER(at, places - 2);
            const double share = LESSER(s / of->step - (double)i, 1.0), low = pow(profile[GREATER(i, 0)], of->two), high = pow(profile[i + 1], of->two);
            const double most = sqrt(low + share * (high - low));
            if (most < aim)
                aim = GREATER(most, LESSER(aim, v - of->late * h));
        }
        for (whole c = 0; c < cars; c++) {
            const double *its = ahead + 3 * c * n + k, room = its[0] - s, speed = its[n], more = room - its[2 * n] * v;
            double most = speed + (more <= of->near ? more / of->closing_s : sqrt(2.0 * of->closing_mps2 * (more - 0.5 * of->near)));
            if (speed < of->standing)
                most = GREATER(most, room / of->stopping_s);
            if (most < aim) {
                const double needed = pow(GREATER(v - speed, 0.0), of->two) / (2.0 * GREATER(room, of->nearest));
                aim = GREATER(most, LESSER(aim, v - LESSER(GREATER(needed, least[c]), of->late) * h));
            }
        }
        found[k] = v = GREATER(aim, 0.0);
    }
}
