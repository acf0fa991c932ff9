/* What this machine can do at best: measured by modelgen build, for its roofline. */
#include <stddef.h>

enum { WIDE = 96, LONG = 1024 };

static void swap(double **const x, double **const y)
{
    double *const t = *x;
    *x = *y;
    *y = t;
}

/* n rounds of WIDE independent x p + q: enough to hide each one's latency. */
void machine_arithmetic(const size_t n, double *const a, double *const b)
{
    double x[WIDE];
    const double p = a[0];
    const double q = a[1];
    for (size_t l = 0; l < WIDE; ++l) {
        x[l] = b[l];
    }
    for (size_t k = 0; k < n; ++k) {
        for (size_t l = 0; l < WIDE; ++l) {
            x[l] = x[l] * p + q;
        }
    }
    for (size_t l = 0; l < WIDE; ++l) {
        b[l] = x[l];
    }
}

/* n rounds of LONG divisions, forth and back. */
void machine_division(const size_t n, double *a, double *b)
{
    for (size_t k = 0; k < n; ++k) {
        for (size_t l = 0; l < LONG; ++l) {
            b[l] = 1.0 / a[l];
        }
        swap(&a, &b);
    }
}

/* n rounds of 2 LONG numbers loaded and LONG stored, in the first cache. */
void machine_memory(const size_t n, double *a, double *b)
{
    for (size_t k = 0; k < n; ++k) {
        for (size_t l = 0; l < LONG; ++l) {
            b[l] = 0.5 * (a[l] + b[l]);
        }
        swap(&a, &b);
    }
}
