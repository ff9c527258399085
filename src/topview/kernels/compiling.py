"""Compiling the tracker's kernels ahead of the first frame, in several processes at once.

numba compiles under one lock, so that threads would wait for each other; processes do not, and
what each of them compiles is kept on disk. `signatures.json` lists what a tracker calls: for each
kernel, the types of its arguments and the seconds that they take to compile. It is written by
`scripts/record_signatures.py`. What it does not list is compiled when it is first called, as by any
other user of numba, and so is everything where nobody calls `compile_ahead`.

Each process takes whole modules, so that no two of them write the cache of one kernel. A stamp
beside the cache tells the next start that there is nothing to do. Its name holds the sources: numba
itself asks only whether the file of a kernel has changed, and not those of what it calls, so that
everything is compiled again when any of them has.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding
from numba import config, types
from numba.core.dispatcher import Dispatcher

from topview.kernels.caching import folder

try:
    import fcntl
except ImportError:  # not on Windows; two processes may then compile the same
    fcntl = None

SOURCES = Path(__file__).parent
SIGNATURES = SOURCES / "signatures.json"
# Ours: each takes 0.2 GB, and the largest module a third of all the time.
MOST_PROCESSES = 4
PYTHON = f"py{sys.version_info[0]}{sys.version_info[1]}{sys.abiflags}"

# Module, kernel: {"seconds": ..., "signatures": [["float64", ...], ...]}
Listed = dict[str, dict[str, dict[str, Any]]]


def listed() -> Listed:
    """What a tracker calls."""
    return json.loads(SIGNATURES.read_text())


def is_compiled() -> bool:
    """Whether there is nothing to do; takes some milliseconds."""
    disabled: bool = config.DISABLE_JIT  # pyright: ignore - numba sets it at run time
    return disabled or _stamp().exists()


def compile_ahead(on_progress: Callable[[float], None] = lambda share: None) -> None:
    """Compile what a tracker calls, unless that was done before, and keep it on disk.

    Args:
        on_progress: told the share that is done, 0 to 1.
    """
    with _alone():
        stamp = _stamp()
        if stamp.exists():
            return
        _forget_older(stamp)
        _compile(on_progress)
        stamp.touch()


def dispatcher_of(module: str, name: str) -> Dispatcher:
    """What numba made of a kernel."""
    kernel = getattr(import_module(f"{__package__}.{module}"), name)
    return kernel if isinstance(kernel, Dispatcher) else kernel.__wrapped__


def _compile(on_progress: Callable[[float], None]) -> None:
    todo = listed()
    seconds = {
        module: float(sum(kernel["seconds"] for kernel in kernels.values()))
        for module, kernels in todo.items()
    }
    total, done = sum(seconds.values()), 0.0
    told, tells = os.pipe()
    workers = [_start(share, tells) for share in _deal(seconds, _processes())]
    os.close(tells)
    try:
        with open(told) as lines:  # ends when the last worker has
            for line in lines:
                module, name = line.split()
                done += todo[module][name]["seconds"]
                on_progress(done / total)
    finally:
        for worker in workers:
            worker.kill()
            worker.wait()


def _start(modules: list[str], tells: int) -> subprocess.Popen[bytes]:
    code = f"import sys; sys.path[:] = {sys.path!r}; import {__name__} as c; c.work({modules!r})"
    return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.DEVNULL, stdout=tells)


def work(modules: list[str]) -> None:
    """What each process does; prints the module and the name of each kernel that is done."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started it, and kills it
    todo = listed()
    for module in modules:
        for name, kernel in todo[module].items():
            for signature in kernel["signatures"]:
                dispatcher_of(module, name).compile(tuple(map(type_of, signature)))
            # In one piece: other processes write to the same pipe.
            os.write(sys.stdout.fileno(), f"{module} {name}\n".encode())


def type_of(text: str) -> types.Type:
    """A type of numba by the name that it gives it itself."""
    return eval(text, vars(types) | {"bool": types.boolean})


def _deal(seconds: dict[str, float], processes: int) -> list[list[str]]:
    """Modules to processes: the longest first, each to the one that has least to do."""
    shares: list[list[str]] = [[] for _ in range(processes)]
    for module in sorted(seconds, key=seconds.__getitem__, reverse=True):
        least = min(shares, key=lambda share: sum(seconds[one] for one in share))
        least.append(module)
    return [share for share in shares if share]


def _processes() -> int:
    cores: int = config.NUMBA_NUM_THREADS  # pyright: ignore - numba sets it at run time
    return min(cores, MOST_PROCESSES)


def _stamp() -> Path:
    sources = sha256()
    for path in sorted([*SOURCES.glob("*.py"), SIGNATURES]):
        sources.update(path.read_bytes())
    machine = sha256()
    for part in (
        numba.__version__,
        sys.version,
        binding.get_host_cpu_name(),
        binding.get_host_cpu_features().flatten(),
        config.CPU_NAME,  # pyright: ignore[reportAttributeAccessIssue]
        config.CPU_FEATURES,  # pyright: ignore[reportAttributeAccessIssue]
    ):
        machine.update(f"{part}\0".encode())
    return folder() / f"compiled.{PYTHON}.{sources.hexdigest()[:16]}.{machine.hexdigest()[:16]}"


def _forget_older(stamp: Path) -> None:
    """Drop what was compiled of other sources by this version of Python."""
    sources = stamp.suffixes[-2]
    if any(stamp.parent.glob(f"compiled.{PYTHON}{sources}.*")):
        return  # of the same sources, for another processor
    for pattern in (f"compiled.{PYTHON}.*", f"*.{PYTHON}.nbi", f"*.{PYTHON}.*.nbc"):
        for path in stamp.parent.glob(pattern):
            path.unlink(missing_ok=True)


@contextmanager
def _alone() -> Iterator[None]:
    """Wait for whoever else is compiling into the same folder."""
    with (folder() / "compiling.lock").open("w") as lock:
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
