"""Where compiled kernels are kept.

numba keeps them in the first of these that can be written to: `NUMBA_CACHE_DIR`, the `__pycache__`
beside the source, the user's own cache folder (`~/.cache/numba`, or under `XDG_CACHE_HOME`). Where
none can be, it refuses to make any kernel. Then a folder is made that lasts as long as the process.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

from numba import config, njit

_TEMPORARY = "topview-kernels-"


def find_folder() -> None:
    """See to it that there is a folder. Has to be called before the first kernel is made."""
    if config.DISABLE_JIT:  # pyright: ignore[reportAttributeAccessIssue] - set at run time
        return
    try:
        folder()
    except RuntimeError:  # "no locator available"
        made = tempfile.mkdtemp(prefix=_TEMPORARY)
        atexit.register(shutil.rmtree, made, ignore_errors=True)
        config.CACHE_DIR = made  # pyright: ignore[reportAttributeAccessIssue] - set at run time
        os.environ["NUMBA_CACHE_DIR"] = made  # for the processes that compile


def folder() -> Path:
    """Where the kernels of this package are kept."""
    return Path(str(njit(cache=True)(_probe).stats.cache_path))


def lasts() -> bool:
    """Whether what is compiled is still there at the next start."""
    return not folder().parent.name.startswith(_TEMPORARY)


def _probe() -> None:
    """Never compiled: numba is only asked where it would be kept."""
