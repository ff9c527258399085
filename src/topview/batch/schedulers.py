"""Who does the jobs of a batch: processes of this machine, or a Dask cluster.

Each is given jobs and yields what became of them as they end. A process that is killed costs the
recording on which it worked a try; one that has cost `MOST_TRIES` processes is given up.
"""

from __future__ import annotations

import logging
import shutil
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any, Final

from topview.batch.job import Job, do, unfinished_folder
from topview.batch.record import Outcome
from topview.io.writers.extras import needed
from topview.records import InputError, shown

MOST_TRIES: Final = 3  # ours
PROCESSES: Final = "processes"
DASK: Final = "dask"

Scheduler = Callable[[Sequence[Job]], Iterator[Outcome]]


def scheduler_named(name: str, workers: int) -> Scheduler:
    """Who does the jobs.

    Args:
        name: "processes", "dask" for a cluster of this machine, or "dask:ADDRESS" for one that
            runs already.
        workers: how many processes of this machine.

    Raises:
        InputError: there is no such scheduler, or its library is missing.
    """
    word, _, address = name.partition(":")
    if name == PROCESSES:
        return lambda jobs: in_processes(jobs, workers)
    if word == DASK:
        needed("distributed", "--scheduler dask", "dask")
        return lambda jobs: in_dask(jobs, workers, address)
    raise InputError(
        f"scheduler is {shown(name)}; it must be {PROCESSES}, {DASK} or {DASK}:ADDRESS"
    )


@dataclass
class _Running:
    job: Job
    tries: int
    process: Any  # of a context; its types have no common name
    told: Connection

    def remove_unfinished(self) -> None:
        """What the process has left, which was killed."""
        shutil.rmtree(unfinished_folder(self.job, self.process.pid), ignore_errors=True)


def in_processes(jobs: Sequence[Job], workers: int) -> Iterator[Outcome]:
    """A new process of this machine for each recording, so many at once."""
    waiting = deque((job, 1) for job in jobs)
    running: dict[Any, _Running] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                one = _started(*waiting.popleft())
                running[one.process.sentinel] = one
            for sentinel in wait(list(running)):
                one = running.pop(sentinel)
                outcome = _told_by(one)
                if outcome is not None:
                    yield outcome
                    continue
                one.remove_unfinished()
                if one.tries < MOST_TRIES:
                    waiting.append((one.job, one.tries + 1))
                else:
                    yield _given_up(one.job)
    finally:  # an error, a signal, or nobody asks for more
        for one in running.values():
            one.process.kill()
            one.process.join()
            one.remove_unfinished()


def _started(job: Job, tries: int) -> _Running:
    context = get_context("spawn")  # a fork would share the threads' locks
    told, tells = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(job, tells), daemon=True)
    process.start()
    tells.close()
    return _Running(job, tries, process, told)


def _work(job: Job, tells: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started it, and kills it
    tells.send(do(job))


def _told_by(one: _Running) -> Outcome | None:
    """What a process that has ended told before; None if it was killed."""
    try:
        return one.told.recv()
    except EOFError:
        return None
    finally:
        one.process.join()
        one.told.close()


def _given_up(job: Job) -> Outcome:
    error = f"{MOST_TRIES} processes that worked on it were killed; memory may be short"
    return job.outcome(state="failed", error=error)


def in_dask(jobs: Sequence[Job], workers: int, address: str = "") -> Iterator[Outcome]:
    """A Dask cluster, which starts jobs of a worker that has died again; one of this machine with
    so many workers if there is no address.

    Raises:
        InputError: no cluster answers at the address.
    """
    from distributed import Client, KilledWorker, LocalCluster, as_completed

    local: dict[str, Any] = {"n_workers": workers, "threads_per_worker": 1}
    local |= {"dashboard_address": None, "silence_logs": logging.ERROR}
    try:
        cluster = address or LocalCluster(**local)
        client = Client(cluster)
    except (OSError, ValueError) as error:
        raise InputError(f"scheduler {address}: no Dask cluster answers there: {error}") from None
    try:
        futures = [client.submit(do, job, pure=False) for job in jobs]
        job_of = dict(zip((future.key for future in futures), jobs, strict=True))
        for future in as_completed(futures):
            try:
                yield future.result()
            except KilledWorker:
                yield _given_up(job_of[future.key])
            except Exception as error:  # a worker that cannot import topview, for one
                told = f"the worker says: {type(error).__name__}: {error}"
                yield job_of[future.key].outcome(state="failed", error=told)
            future.release()
    finally:
        client.close()
        if not isinstance(cluster, str):
            cluster.close()
