"""Speed, measured beside others: `python -m benchmarks`."""

import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")  # before any of the libraries is loaded
