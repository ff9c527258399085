"""The rivals' inner loops: beside `topview.kernels`, the only importer of numba."""
