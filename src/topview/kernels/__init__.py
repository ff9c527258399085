"""The fast loops, and the only importer of numba."""

from topview.kernels.caching import find_folder

find_folder()
