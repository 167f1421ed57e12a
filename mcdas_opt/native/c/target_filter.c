/* One target's constant-velocity filter and the fixes that it takes in: `cv_filter`, `fix` and `association` operation by operation. */
#include "frenet.h"

enum { N = 4, BELIEF = N + N * N };  /* x = (s, vs, d, vd), then its covariance row by row */
enum { KIND, PLACE_S, PLACE_D, RANGE, EXTENT, BEARING, KAPPA, STRETCH, RELATIVE, SIDEWAYS, VARIANCE, LENGTH = VARIANCE + 4, WIDTH, OF_FIX };
enum { RADAR, BODY };  /* kinds; a body's whole state stands at RANGE.., its variances at VARIANCE.. */

#define LEAST_M 1e-12

/* x and P a time dt later (or earlier), the noise of |dt| added */
static void moved(const double *belief, double dt, double along, double across, double *out)
{
    const double h = fabs(dt), p = 0.25 * (h * h * h * h), c = 0.5 * (h * h * h), v = h * h;
    double *P = out + N;
    memcpy(out, belief, sizeof(double) * BELIEF);
    out[0] += dt * out[1];
    out[2] += dt * out[3];
    for (int j = 0; j < N; j++) {
        P[j] += dt * P[N + j];
        P[2 * N + j] += dt * P[3 * N + j];
    }
    for (int i = 0; i < N; i++) {
        P[N * i] += dt * P[N * i + 1];
        P[N * i + 2] += dt * P[N * i + 3];
    }
    for (int axis = 0; axis < 2; axis++) {
        const double q = axis ? across * across : along * along;
        double *block = P + 2 * axis * (N + 1);
        block[0] += q * p;
        block[1] += q * c;
        block[N] += q * c;
        block[N + 1] += q * v;
    }
}

static void evened(double *P)
{
    for (int i = 0; i < N; i++)
        for (int j = 0; j < i; j++) P[N * i + j] = P[N * j + i] = 0.5 * (P[N * i + j] + P[N * j + i]);
}

PUBLIC void mcdas_at(const double *belief, double dt, double along, double across, double *out)
{
    moved(belief, dt, along, across, out);
    evened(out + N);
}

static double half_extent(double bearing, double length, double width)
{
    return LESSER(0.5 * length / GREATER(fabs(cos(bearing)), LEAST_M), 0.5 * width / GREATER(fabs(sin(bearing)), LEAST_M));
}

/* z = H x + noise of covariance R, for a target of that belief; how many rows */
static int reading(const double *belief, const double *fix, double *z, double *H, double *R)
{
    const double heading_sd = 0.1, slowest = 3.0;
    memset(H, 0, sizeof(double) * N * N);
    memset(R, 0, sizeof(double) * N * N);
    if (fix[KIND] == BODY) {
        for (int i = 0; i < N; i++) {
            z[i] = fix[RANGE + i];
            H[N * i + i] = 1.0;
            R[N * i + i] = fix[VARIANCE + i];
        }
        return N;
    }
    {
        const double vs = belief[1], vd = belief[3], stretch = fix[STRETCH], forward = vs * stretch;
        const double along = cos(fix[BEARING]), across = sin(fix[BEARING]);
        double shift = 0.0, slope = 0.0, doubt = 0.0, r, turned, jacobian[3][3], variance[3];
        if (fix[LENGTH] > 0.0) {
            const double speed = GREATER(fabs(forward), slowest);
            const double weight = heading_sd * heading_sd / (heading_sd * heading_sd + belief[N + 15] / (speed * speed));
            const double seen = fix[BEARING] - weight * atan(vd / copysign(speed, forward)), c = cos(seen), s = sin(seen);
            double extent;
            if (fix[WIDTH] * fabs(c) >= fix[LENGTH] * fabs(s)) {
                extent = 0.5 * fix[LENGTH] / fabs(c);
                slope = extent * s / c;
            } else {
                extent = 0.5 * fix[WIDTH] / fabs(s);
                slope = -extent * c / s;
            }
            shift = extent - fix[EXTENT];
            doubt = slope * slope * (heading_sd * heading_sd) * (1.0 - weight);
        }
        r = fix[RANGE] + shift;
        turned = vd * along - forward * across;
        jacobian[0][0] = along / stretch;
        jacobian[0][1] = (slope * along - r * across) / stretch;
        jacobian[0][2] = 0.0;
        jacobian[1][0] = across;
        jacobian[1][1] = slope * across + r * along;
        jacobian[1][2] = 0.0;
        jacobian[2][0] = fix[KAPPA] * (turned * jacobian[0][0] + vs * along * jacobian[1][0]);
        jacobian[2][1] = fix[KAPPA] * (turned * jacobian[0][1] + vs * along * jacobian[1][1]) + fix[SIDEWAYS] - turned;
        jacobian[2][2] = 1.0;
        variance[0] = fix[VARIANCE] + doubt;
        variance[1] = fix[VARIANCE + 1];
        variance[2] = fix[VARIANCE + 2];
        z[0] = fix[PLACE_S] + shift * along / stretch;
        z[1] = fix[PLACE_D] + shift * across;
        z[2] = fix[RELATIVE];
        H[0] = H[N + 2] = 1.0;
        H[2 * N + 1] = stretch * along;
        H[2 * N + 3] = across;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                for (int k = 0; k < 3; k++) R[N * i + j] += jacobian[i][k] * variance[k] * jacobian[j][k];
    }
    return 3;
}

/* PH' (N x m, rows of N), S = H P H' + R and its inverse; S's determinant */
static double innovation(const double *P, const double *H, const double *R, int m, double *PH, double *inverse)
{
    double S[N][2 * N], determinant = 1.0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < m; j++) {
            PH[N * i + j] = 0.0;
            for (int k = 0; k < N; k++) PH[N * i + j] += P[N * i + k] * H[N * j + k];
        }
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) {
            S[i][j] = R[N * i + j];
            S[i][m + j] = i == j;
            for (int k = 0; k < N; k++) S[i][j] += H[N * i + k] * PH[N * k + j];
        }
    for (int i = 0; i < m; i++) {  /* Gauss and Jordan, by the largest pivot */
        int best = i;
        for (int k = i + 1; k < m; k++)
            if (fabs(S[k][i]) > fabs(S[best][i])) best = k;
        if (best != i) {
            for (int j = 0; j < 2 * m; j++) {
                const double kept = S[i][j];
                S[i][j] = S[best][j];
                S[best][j] = kept;
            }
            determinant = -determinant;
        }
        determinant *= S[i][i];
        for (int j = 2 * m - 1; j >= i; j--) S[i][j] /= S[i][i];
        for (int k = 0; k < m; k++)
            if (k != i)
                for (int j = 2 * m - 1; j >= i; j--) S[k][j] -= S[k][i] * S[i][j];
    }
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) inverse[N * i + j] = S[i][m + j];
    return determinant;
}

static void missed(const double *x, const double *z, const double *H, int m, double *y)
{
    for (int i = 0; i < m; i++) {
        y[i] = z[i];
        for (int k = 0; k < N; k++) y[i] -= H[N * i + k] * x[k];
    }
}

/* d^2 + ln det S inside the gate, infinite outside */
PUBLIC double mcdas_cost(const double *belief, double dt, double along, double across, const double *fix, double gate, double far_m,
                         double far_sd)
{
    double now[BELIEF], z[N], H[N * N], R[N * N], PH[N * N], inverse[N * N], y[N], distance = 0.0, determinant;
    int m;
    mcdas_at(belief, dt, along, across, now);
    if (fabs(fix[PLACE_S] - now[0]) > far_m + far_sd * sqrt(now[N]) || fabs(fix[PLACE_D] - now[2]) > far_m + far_sd * sqrt(now[N + 10]))
        return HUGE_VAL;
    m = reading(now, fix, z, H, R);
    determinant = innovation(now + N, H, R, m, PH, inverse);
    missed(now, z, H, m, y);
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) distance += y[i] * inverse[N * i + j] * y[j];
    return distance <= gate ? distance + log(determinant) : HUGE_VAL;
}

/* the belief takes a fix in that is dt younger, or a little older, than it */
PUBLIC void mcdas_correct(double *belief, double dt, double along, double across, const double *fix)
{
    double now[BELIEF], z[N], H[N * N], R[N * N], PH[N * N], inverse[N * N], y[N], K[N * N] = {0.0}, L[N * N], LP[N * N];
    double *P = belief + N;
    int m;
    mcdas_at(belief, dt, along, across, now);
    m = reading(now, fix, z, H, R);
    if (dt > 0.0) {
        moved(belief, dt, along, across, now);
        memcpy(belief, now, sizeof now);
    } else if (dt < 0.0) {  /* taken in where the filter stands: H F(dt), the noise of the lag in R */
        double none[BELIEF] = {0.0}, noise[N * N], HQ[N * N];
        moved(none, -dt, along, across, now);
        memcpy(noise, now + N, sizeof noise);
        for (int i = 0; i < m; i++)
            for (int j = 0; j < N; j++) {
                HQ[N * i + j] = 0.0;
                for (int k = 0; k < N; k++) HQ[N * i + j] += H[N * i + k] * noise[N * k + j];
            }
        for (int i = 0; i < m; i++)
            for (int j = 0; j < m; j++)
                for (int k = 0; k < N; k++) R[N * i + j] += HQ[N * i + k] * H[N * j + k];
        for (int i = 0; i < m; i++) {
            H[N * i + 1] += dt * H[N * i];
            H[N * i + 3] += dt * H[N * i + 2];
        }
    }
    innovation(P, H, R, m, PH, inverse);
    missed(belief, z, H, m, y);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < m; j++)
            for (int k = 0; k < m; k++) K[N * i + j] += PH[N * i + k] * inverse[N * k + j];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < m; j++) belief[i] += K[N * i + j] * y[j];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            L[N * i + j] = i == j;
            for (int k = 0; k < m; k++) L[N * i + j] -= K[N * i + k] * H[N * k + j];
        }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            LP[N * i + j] = 0.0;
            for (int k = 0; k < N; k++) LP[N * i + j] += L[N * i + k] * P[N * k + j];
        }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            P[N * i + j] = 0.0;
            for (int k = 0; k < N; k++) P[N * i + j] += LP[N * i + k] * L[N * j + k];
            for (int k = 0; k < m; k++)
                for (int q = 0; q < m; q++) P[N * i + j] += K[N * i + k] * R[N * k + q] * K[N * j + q];
        }
    evened(P);
}

/* points (count, 6): range, azimuth, range rate and their variances; view: x, y, yaw, vx, vy, host's s; fixes (count, OF_FIX) */
PUBLIC void mcdas_fixes(whole count, const double *points, const double *view, double length, double width, whole samples,
                        const double *line, whole knots, const double *bends, double *fixes)
{
    const Frame frame = frame_of(samples, line, knots, bends);
    const Window sought = window_near(&frame, view[5]);
    const double here = samples ? road_heading(&frame, view[5]) : 0.0;
    for (whole i = 0; i < count; i++, points += 6, fixes += OF_FIX) {
        const double theta = view[2] + points[1], ux = cos(theta), uy = sin(theta);
        double r = points[0], extent = 0.0, s, d, bearing, kappa, near = 0.0;
        if (length > 0.0) {  /* the road's heading near the point is good enough for a first half extent */
            if (samples) near = road_heading(&frame, view[5] + r * ux * cos(here) + r * uy * sin(here));
            extent = half_extent(theta - near, length, width);
            r += extent;
        }
        to_road(&frame, view[0] + r * ux, view[1] + r * uy, sought, &s, &d);
        bearing = samples ? theta - road_heading(&frame, s) : theta;
        if (length > 0.0 && samples)
            for (int round = 0; round < 2; round++) {  /* now with the heading at the centre itself */
                const double correction = half_extent(bearing, length, width) - extent;
                const double stretch = 1.0 - d * road_curvature(&frame, s);
                r += correction;
                extent += correction;
                s += correction * cos(bearing) / stretch;
                d += correction * sin(bearing);
                bearing = theta - road_heading(&frame, s);
            }
        kappa = samples ? road_curvature(&frame, s) : 0.0;
        fixes[KIND] = RADAR;
        fixes[PLACE_S] = s;
        fixes[PLACE_D] = d;
        fixes[RANGE] = r;
        fixes[EXTENT] = extent;
        fixes[BEARING] = bearing;
        fixes[KAPPA] = kappa;
        fixes[STRETCH] = 1.0 - d * kappa;
        fixes[RELATIVE] = points[2] + ux * view[3] + uy * view[4];
        fixes[SIDEWAYS] = ux * view[4] - uy * view[3];
        for (int k = 0; k < 3; k++) fixes[VARIANCE + k] = points[3 + k];
        fixes[LENGTH] = length;
        fixes[WIDTH] = width;
    }
}
