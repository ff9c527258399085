"""Inner loops of rivals and simulator: beside `topview.kernels`, the only importer of numba."""
