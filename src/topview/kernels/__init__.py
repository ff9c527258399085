"""The fast loops, and the only importer of numba."""
