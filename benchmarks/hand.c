/* Written by hand for one model each, as well as its author can: the yardstick of generated code. Plain C, arrays of
 * structures turned inside out, everything that stays the same taken out of the loops by hand. */

enum { LANES = 8 };

static const double PI = 3.14159265358979323846;
static const double TURNS = 940.0, AREA = 3.141592653589793e-4, LENGTH = 0.1, CUT_OFF = 3e4;
static const double MU_0 = 1.2566370614359173e-6, R_0 = 3.0, MASS = 1.2501374, SPRING = 3e6, DAMPING = 6.79 + 349.2303;

/* M1, magnetostrictive transducer. Of a frequency alone: omega, chi, and the mechanical impedance without the rod. */
void m1_prepare(const size_t n, const double *restrict f, double *restrict s)
{
    for (size_t i = 0; i < n; ++i) {
        const double p = f[i] / CUT_OFF;
        s[0 * n + i] = 2.0 * PI * f[i];
        s[1 * n + i] = 1.0 - p * p / 48.0 + 19.0 * p * p * p * p / 30720.0;
        s[2 * n + i] = -(p / 8.0 - 11.0 * p * p * p / 3072.0 + 473.0 * p * p * p * p * p / 4423680.0);
        s[3 * n + i] = s[0 * n + i] * MASS - SPRING / s[0 * n + i];
        s[4 * n + i] = 1.0 / s[0 * n + i];
    }
}

/* With m = mu' chi + j mu'', S, d: Z = R_0 + j w c (m - d^2/(mu_0 S)) + T^2/Z_t, where c = mu_0 N^2 A/l, T = N A d/(S l),
 * Z_t = R + j (w M - K/w) + K_G/(j w), K_G = A/(l S). */
typedef struct { double c, mr, mi, er, ei, gr, gi, tr, ti; } m1_set;

static m1_set m1_hoist(const double *restrict t)
{
    const double scale = 1.0 / (t[2] * t[2] + t[3] * t[3]);
    const double ir = t[2] * scale, ii = -t[3] * scale; /* 1/S */
    const double dr = t[4] * t[4] - t[5] * t[5], di = 2.0 * t[4] * t[5];
    const double kr = dr * ir - di * ii, ki = dr * ii + di * ir; /* d^2/S */
    const double c = TURNS * TURNS * AREA / LENGTH, q = TURNS * AREA / LENGTH;
    const double ur = q * (t[4] * ir - t[5] * ii), ui = q * (t[4] * ii + t[5] * ir);
    m1_set h;
    h.c = c;
    h.mr = c * MU_0 * t[0];
    h.mi = c * MU_0 * t[1];
    h.er = c * kr;
    h.ei = c * ki;
    h.gr = AREA / LENGTH * ir;
    h.gi = AREA / LENGTH * ii;
    h.tr = ur * ur - ui * ui;
    h.ti = 2.0 * ur * ui;
    return h;
}

void m1_batch(const size_t m, const size_t n, const double *restrict s, const double *restrict re,
              const double *restrict im, const double *restrict theta, double *restrict out)
{
    const double *restrict w = s, *restrict xr = s + n, *restrict xi = s + 2 * n, *restrict x = s + 3 * n,
        *restrict v = s + 4 * n;
    for (size_t k = 0; k < m; ++k) {
        const m1_set h = m1_hoist(theta + 6 * k);
        double lanes[LANES] = { 0.0 };
        const size_t whole = n / LANES * LANES;
        for (size_t b = 0; b < n; b += LANES) {
            const size_t count = b < whole ? LANES : n - whole;
            for (size_t l = 0; l < count; ++l) {
                const size_t i = b + l;
                const double zr = DAMPING + h.gi * v[i], zi = x[i] - h.gr * v[i];
                const double g = 1.0 / (zr * zr + zi * zi);
                const double lr = h.mr * xr[i] - h.er, li = h.mr * xi[i] + h.mi - h.ei;
                const double a = R_0 - w[i] * li + g * (h.tr * zr + h.ti * zi) - re[i];
                const double d = w[i] * lr + g * (h.ti * zr - h.tr * zi) - im[i];
                lanes[l] += a * a + d * d;
            }
        }
        double sum = 0.0;
        for (size_t l = 0; l < LANES; ++l) {
            sum += lanes[l];
        }
        out[k] = sum;
    }
}

/* Z and its derivatives by mu', mu'', S', S'', d', d''. With D = K - w^2 M + j w R + A/(l S) and P = (D - A/(l S))/D:
 * Z = R_0 + j w c (mu_0 mu - d^2 P/S), dZ/dd = -2 j w c P d/S, dZ/dS = j w c P^2 (d/S)^2; by imaginary parts j times. */
void m1_jacobian(const size_t n, const double *restrict s, const double *restrict t, double *restrict out,
                 double *restrict jac)
{
    const double scale = 1.0 / (t[2] * t[2] + t[3] * t[3]);
    const double ir = t[2] * scale, ii = -t[3] * scale, c = TURNS * TURNS * AREA / LENGTH, m = c * MU_0;
    const double kr = AREA / LENGTH * ir, ki = AREA / LENGTH * ii;
    const double vr = t[4] * ir - t[5] * ii, vi = t[4] * ii + t[5] * ir; /* d/S */
    const double er = c * (t[4] * vr - t[5] * vi), ei = c * (t[4] * vi + t[5] * vr);
    const double qr = c * (vi * vi - vr * vr), qi = -2.0 * c * vr * vi, ar = 2.0 * c * vr, ai = 2.0 * c * vi;
#pragma GCC ivdep
    for (size_t i = 0; i < n; ++i) {
        const double w = s[i], xr = s[n + i], xi = s[2 * n + i];
        const double br = -w * s[3 * n + i], bi = w * DAMPING;
        const double dr = br + kr, di = bi + ki, g = 1.0 / (dr * dr + di * di);
        const double pr = g * (br * dr + bi * di), pi = g * (bi * dr - br * di);
        const double lr = m * t[0] * xr - (er * pr - ei * pi);
        const double li = m * (t[0] * xi + t[1]) - (er * pi + ei * pr);
        const double yr = w * pi, yi = -w * pr; /* -j w P */
        const double hr = ar * yr - ai * yi, hi = ar * yi + ai * yr;
        const double zr = pr * yr - pi * yi, zi = pr * yi + pi * yr;
        const double sr = qr * zr - qi * zi, si = qr * zi + qi * zr;
        out[i] = R_0 - w * li;
        out[n + i] = w * lr;
        jac[i] = -w * m * xi;
        jac[n + i] = -w * m;
        jac[2 * n + i] = sr;
        jac[3 * n + i] = -si;
        jac[4 * n + i] = hr;
        jac[5 * n + i] = -hi;
        jac[6 * n + i] = w * m * xr;
        jac[7 * n + i] = 0.0;
        jac[8 * n + i] = si;
        jac[9 * n + i] = sr;
        jac[10 * n + i] = hi;
        jac[11 * n + i] = hr;
    }
}

/* M2, modified Dahl, b = 1, no turning point inside a step: r <- s + (r - s) exp(-rho |dz|), F = h r + k z + c v + F_0.
 * Of the samples alone: |dz| and its sign. */
enum { TILE = 256, PARTS = 8 };

/* x[i + 1] = a[i] x[i] + b[i] in PARTS side by side: first as maps, then with the values at which parts start. */
static void scan(const size_t n, const double *restrict a, const double *restrict b, double *restrict x)
{
    const size_t part = n / PARTS;
    double factor[PARTS], rest[PARTS] = { 0.0 }, at[PARTS], start = x[0];
    for (size_t l = 0; l < PARTS; ++l) {
        factor[l] = 1.0;
    }
    for (size_t k = 0; k < part; ++k) {
        for (size_t l = 0; l < PARTS; ++l) {
            factor[l] *= a[l * part + k];
            rest[l] = a[l * part + k] * rest[l] + b[l * part + k];
        }
    }
    for (size_t l = 0; l < PARTS; ++l) {
        at[l] = start;
        start = factor[l] * start + rest[l];
    }
    for (size_t k = 0; k < part; ++k) {
        for (size_t l = 0; l < PARTS; ++l) {
            at[l] = a[l * part + k] * at[l] + b[l * part + k];
            x[1 + l * part + k] = at[l];
        }
    }
    for (size_t i = PARTS * part; i < n; ++i) {
        x[i + 1] = a[i] * x[i] + b[i];
    }
}

/* exp(-x) for 0 <= x < 700, without a branch. */
static inline double decay(const double x)
{
    union { double value; unsigned long long bits; } power;
    const double k = (-x * 1.4426950408889634 + 6755399441055744.0) - 6755399441055744.0;
    const double r = (-x - k * 0.6931471805592082) - k * 7.371002565167799e-13;
    double p = 2.0914686968086876e-09;
    p = p * r + 2.5105217004720745e-08;
    p = p * r + 2.75572736431103e-07;
    p = p * r + 2.7557255400206422e-06;
    p = p * r + 2.4801587325547743e-05;
    p = p * r + 0.00019841269874820627;
    p = p * r + 0.0013888888888883748;
    p = p * r + 0.008333333333326136;
    p = p * r + 0.04166666666666667;
    p = p * r + 0.1666666666666667;
    p = p * r + 0.5;
    power.value = k + 6755399441055744.0;
    power.bits = (power.bits + 1023U) << 52U;
    return (1.0 + (r + r * r * p)) * power.value;
}

/* p: k, c, h, rho, r_0. F of all samples. */
void m2_values(const size_t n, const double *restrict z, const double *restrict v, const double *restrict step,
               const double *restrict sign, const double *restrict p, double *restrict F)
{
    double r[TILE + 1], a[TILE], b[TILE];
    r[0] = p[4];
    F[0] = p[0] * z[0] + p[1] * v[0] + p[2] * p[4];
    for (size_t base = 1; base < n; base += TILE) {
        const size_t count = n - base < TILE ? n - base : TILE;
        for (size_t l = 0; l < count; ++l) {
            a[l] = decay(p[3] * step[base + l]);
            b[l] = sign[base + l] * (1.0 - a[l]);
        }
        scan(count, a, b, r);
        for (size_t l = 0; l < count; ++l) {
            F[base + l] = p[0] * z[base + l] + p[1] * v[base + l] + p[2] * r[l + 1];
        }
        r[0] = r[count];
    }
}

/* Upper triangle of J'J, J'e and e'e of e = F - data by k, c, h, rho: 15 sums. */
void m2_normal(const size_t n, const double *restrict z, const double *restrict v, const double *restrict step,
               const double *restrict sign, const double *restrict p, const double *restrict data,
               double *restrict normal)
{
    double r[TILE + 1], q[TILE + 1], a[TILE], b[TILE], c[TILE], lanes[15][LANES] = { { 0.0 } };
    r[0] = p[4];
    q[0] = 0.0;
    for (size_t base = 1; base < n; base += TILE) {
        const size_t count = n - base < TILE ? n - base : TILE;
        for (size_t l = 0; l < count; ++l) {
            a[l] = decay(p[3] * step[base + l]);
            b[l] = sign[base + l] * (1.0 - a[l]);
        }
        scan(count, a, b, r);
        for (size_t l = 0; l < count; ++l) {
            c[l] = step[base + l] * (sign[base + l] - r[l + 1]);
        }
        scan(count, a, c, q);
        const size_t whole = count / LANES * LANES;
        for (size_t k = 0; k < count; k += LANES) {
            const size_t some = k < whole ? LANES : count - whole;
            for (size_t l = 0; l < some; ++l) {
                const double x = z[base + k + l], y = v[base + k + l], f = r[k + l + 1], g = p[2] * q[k + l + 1];
                const double e = p[0] * x + p[1] * y + p[2] * f - data[base + k + l];
                lanes[0][l] += x * x;
                lanes[1][l] += x * y;
                lanes[2][l] += x * f;
                lanes[3][l] += x * g;
                lanes[4][l] += y * y;
                lanes[5][l] += y * f;
                lanes[6][l] += y * g;
                lanes[7][l] += f * f;
                lanes[8][l] += f * g;
                lanes[9][l] += g * g;
                lanes[10][l] += x * e;
                lanes[11][l] += y * e;
                lanes[12][l] += f * e;
                lanes[13][l] += g * e;
                lanes[14][l] += e * e;
            }
        }
        r[0] = r[count];
        q[0] = q[count];
    }
    const double e = p[0] * z[0] + p[1] * v[0] + p[2] * p[4] - data[0], row[4] = { z[0], v[0], p[4], 0.0 };
    size_t k = 0;
    for (size_t i = 0; i < 4; ++i) {
        for (size_t j = i; j < 4; ++j, ++k) {
            lanes[k][0] += row[i] * row[j];
        }
    }
    for (size_t i = 0; i < 4; ++i) {
        lanes[10 + i][0] += row[i] * e;
    }
    lanes[14][0] += e * e;
    for (k = 0; k < 15; ++k) {
        normal[k] = 0.0;
        for (size_t l = 0; l < LANES; ++l) {
            normal[k] += lanes[k][l];
        }
    }
}
