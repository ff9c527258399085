"""The fast loops, and the only importer of numba."""

import os

# OpenMP reads this when numba starts its threads. Threads that spin while they wait slow the
# kernels several-fold wherever the cores have other work too.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
