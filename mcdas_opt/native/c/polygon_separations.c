/* Signed separation of one rectangle's poses from convex polygons: `PolygonField.separation`, with its order of sums. */
#include "mcdas.h"

typedef struct {
    double c, s, x[4], y[4], ahead, left; /* cosine and sine of the heading, corners, and the origin in the body's axes */
} Placed;

/* The body's pose, `corners` (4, 2) of it about its own origin. */
static Placed placed(const double *pose, double c, double s, const double *corners)
{
    Placed at = {.c = c, .s = s, .ahead = c * pose[0] + s * pose[1], .left = c * pose[1] - s * pose[0]};
    for (int q = 0; q < 4; q++) {
        at.x[q] = pose[0] + c * corners[2 * q] - s * corners[2 * q + 1];
        at.y[q] = pose[1] + s * corners[2 * q] + c * corners[2 * q + 1];
    }
    return at;
}

/* From one polygon, edges `from` to before `until`; `body` is (rear, front, half width). Rows of `edges` (9, total): vertex, normal, its
 * offset, tangent, its start, length. */
static double apart_from(const Placed *at, const double *body, const double *edges, whole total, whole from, whole until)
{
    const double rear = body[0], front = body[1], half = body[2];
    const double *px = edges, *py = px + total, *nx = py + total, *ny = nx + total, *offset = ny + total;
    const double *tx = offset + total, *ty = tx + total, *start = ty + total, *length = start + total;
    double nearest = INFINITY, gap = -INFINITY;
    double ahead_least = INFINITY, ahead_most = -INFINITY, left_least = INFINITY, left_most = -INFINITY;
    for (whole e = from; e < until; e++) {
        double out = INFINITY;
        for (int q = 0; q < 4; q++) {
            const double outward = at->x[q] * nx[e] + at->y[q] * ny[e] - offset[e];
            const double along = at->x[q] * tx[e] + at->y[q] * ty[e] - start[e];
            const double past = GREATER(along - length[e], -along), beyond = GREATER(past, 0.0);
            nearest = LESSER(outward * outward + beyond * beyond, nearest);
            out = LESSER(outward, out);
        }
        gap = GREATER(out, gap);
        const double ahead = at->c * px[e] + at->s * py[e] - at->ahead, left = at->c * py[e] - at->s * px[e] - at->left;
        const double lengthwise = GREATER(ahead - front, rear - ahead), sideways = fabs(left) - half;
        const double out_x = GREATER(lengthwise, 0.0), out_y = GREATER(sideways, 0.0);
        nearest = LESSER(out_x * out_x + out_y * out_y, nearest);
        ahead_least = LESSER(ahead, ahead_least);
        ahead_most = GREATER(ahead, ahead_most);
        left_least = LESSER(left, left_least);
        left_most = GREATER(left, left_most);
    }
    gap = GREATER(ahead_least - front, gap);
    gap = GREATER(rear - ahead_most, gap);
    gap = GREATER(left_least - half, gap);
    gap = GREATER(-half - left_most, gap);
    return gap > 0.0 ? sqrt(nearest) : gap;
}

/* Of n poses, with cosine and sine of their headings: `apart` (n, polygons), or the least of each pose (n,) where that is asked for.
 * `first` says where each polygon's edges begin and, last, how many there are. */
PUBLIC void mcdas_polygon_separations(whole n, whole polygons, whole least, const whole *first, const double *poses,
                                     const double *cosine, const double *sine, const double *body, const double *corners,
                                     const double *edges, double *apart)
{
    for (whole i = 0; i < n; i++) {
        const Placed at = placed(poses + 3 * i, cosine[i], sine[i], corners);
        double smallest = INFINITY;
        for (whole k = 0; k < polygons; k++) {
            const double found = apart_from(&at, body, edges, first[polygons], first[k], first[k + 1]);
            smallest = LESSER(found, smallest);
            if (!least)
                apart[i * polygons + k] = found;
        }
        if (least)
            apart[i] = smallest;
    }
}
