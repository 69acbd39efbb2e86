"""Judging on many machines, by the workers of a dask cluster, each with a process of its own.

A worker takes a claim at a time and hands it to a `Worker`: what a claim may do to its process, and how long it may
take, is the same everywhere. A worker that is lost loses the claim that it was at, which the scheduler gives to another
one; a claim that has cost several workers fails; a cluster that has lost all its workers waits for others, and says so.
Where core, claims, engines or Python are others than here, nothing is judged: the records would be of something else.
"""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import os
import platform
import queue
import threading
from collections import deque
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import wait
from typing import Any

from validation.journal import identity, others
from validation.worker import DIED, Ended, Task, Worker, memory_each

PATIENCE = 10.0  # seconds for the scheduler to answer
GLANCE = 0.5  # [s] between two looks at a claim that runs
ROUND = 2.0  # [s] between two looks at who is there
# How many threads libraries start, which dask sets to 1 on its workers, may change the last bits of what they sum.
THREADS = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"

# On a dask worker: the process that judges for each of its threads, and for which run; and the runs that are over.
_judges: dict[int, tuple[str, Worker]] = {}
_over: set[str] = set()


class CannotJudgeThereError(Exception):
    """There is no scheduler, or it has no workers, or they have something else than we, or cannot judge."""


class Cluster:
    """A scheduler that answers, and whose workers have the same core, claims and engines."""

    def __init__(self, address: str, level: str, seed: int, subject: str | None, say: Callable[[str], None]) -> None:
        """Ask the scheduler at an address such as tcp://host:8786; raises CannotJudgeThereError.

        `level`, `seed` and `subject` are those of the run; `say` hears what a person should know while it goes on.
        """
        try:
            from distributed import Client
        except ImportError:
            raise CannotJudgeThereError(
                "distributed is not installed, which --scheduler needs: pip install 'softbody[cluster]', or distributed"
            ) from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what matters here is raised
        try:
            if asyncio.run(asyncio.wait_for(_kind_of(address), PATIENCE)) != "Scheduler":
                raise ValueError("what is there is no scheduler")
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except Exception as error:  # dask raises many kinds for what is no address, or no scheduler
            raise CannotJudgeThereError(
                f"no scheduler answers at {address} within {PATIENCE:g} s: start one with `dask scheduler` ({error})"
            ) from error
        self._address, self._run, self._ours = address, (level, seed, subject), all_that_decides(level, seed, subject)
        self._say, self._is_deserted = say, False
        try:
            self._refuse_others()
        except BaseException:
            self.close()
            raise

    def _refuse_others(self) -> None:
        """Raise CannotJudgeThereError unless there are workers, and all have what we have."""
        found = self._client.run(all_that_decides, *self._run, on_error="return")
        if not found:
            raise CannotJudgeThereError(f"the scheduler at {self._address} has no workers: {self._how_to_start_one}")
        for worker, theirs in found.items():
            if isinstance(theirs, BaseException):
                raise CannotJudgeThereError(
                    f"worker {worker} cannot import this validation ({theirs}): start it in this folder's like"
                )
            other = differences(theirs, self._ours)
            if other:
                raise CannotJudgeThereError(
                    f"worker {worker} has {', '.join(other)}: its records would not be those of this run; "
                    "start it where the same softbody is installed"
                )

    @property
    def _how_to_start_one(self) -> str:
        return f"start some with `dask worker {self._address} --nthreads 1` where this softbody is"

    def run(self, tasks: list[Task], started: Callable[[str], None]) -> Generator[Ended, None, None]:
        """Yield what becomes of each task as it ends; so many are under way as the workers have threads.

        Raises CannotJudgeThereError if the scheduler is lost, or a worker has become another.
        """
        waiting, done = deque(tasks), queue.SimpleQueue[Any]()
        futures: dict[Any, tuple[Any, Task]] = {}
        try:
            while waiting or futures:
                threads = self._threads()
                while waiting and len(futures) < max(1, threads):
                    task = waiting.popleft()
                    future = self._client.submit(_judge_there, task, self._client.id, self._run, self._ours, pure=False)
                    futures[future.key] = future, task
                    started(task.name)
                    future.add_done_callback(done.put)
                with suppress(queue.Empty):
                    future = done.get(timeout=ROUND)
                    yield self._ended(future, futures.pop(future.key)[1])
        finally:
            with suppress(Exception):  # a scheduler that is lost has nobody to tell
                self._client.cancel([future for future, _ in futures.values()], force=True)
                self._client.run(_end_run, self._client.id)

    def _threads(self) -> int:
        """Return how many threads the workers have together, and say it if there are none any more, or are again."""
        try:
            threads: int = sum(self._client.nthreads().values())
        except Exception as error:  # of many kinds
            raise self._lost() from error
        if not threads and not self._is_deserted:
            self._say(f"No worker is left, and nothing goes on until there is one: {self._how_to_start_one}.")
        elif threads and self._is_deserted:
            self._say("There are workers again.")
        self._is_deserted = not threads
        return threads

    def _ended(self, future: Any, task: Task) -> Ended:
        """Return what became of a task whose future is done; raises CannotJudgeThereError."""
        from distributed import KilledWorker

        if future.status == "error":
            error = future.exception()
            if isinstance(error, KilledWorker):
                return Ended(task, 0.0, how=DIED, why=f"every worker that was at it was lost: {error}")
            if isinstance(error, CannotJudgeThereError):
                raise error
            raise CannotJudgeThereError(f"a worker cannot judge {task.name} ({type(error).__name__}: {error})")
        try:
            ended: Ended = future.result()
        except Exception as error:
            raise self._lost() from error
        return ended

    def _lost(self) -> CannotJudgeThereError:
        return CannotJudgeThereError(f"the scheduler at {self._address} was lost")

    def close(self) -> None:
        """Leave the cluster as it is."""
        self._client.close(timeout=PATIENCE)


async def _kind_of(address: str) -> str:
    """Return what is at an address: a Client would wait for ever for an answer of something else."""
    from distributed import rpc

    async with rpc(address) as there:
        return str((await there.identity())["type"])


def all_that_decides(level: str, seed: int, subject: str | None) -> dict[str, Any]:
    """Return all that decides the records of a run, with Python itself and how many threads libraries may start."""
    threads = {name: os.environ.get(name) for name in THREADS}
    return identity(level, seed, subject) | {"python": platform.python_version(), "threads": threads}


def differences(theirs: dict[str, Any], ours: dict[str, Any]) -> list[str]:
    """Return in words what somebody has who would come to other records."""
    words = {"core": "another core", "claims": "other claims or references", "python": f"Python {theirs['python']}"}
    found = [word for key, word in words.items() if theirs[key] != ours[key]]
    engines = others(theirs["engines"], ours["engines"])
    return found + [f"other versions of {', '.join(engines)}"] * bool(engines)


def _judge_there(task: Task, name: str, run: tuple[str, int, str | None], ours: dict[str, Any]) -> Ended:
    """Do a task of the run of some name in a process of its own on a dask worker."""
    worker = _judge_of(threading.get_ident(), name, ours["threads"])
    worker.begin(replace(task, work=_judged_by_the_same, arguments=(task.work, task.arguments, run, ours)))
    while name not in _over:
        wait(worker.news, GLANCE)
        ended = worker.look()
        if ended is None:
            continue
        if ended.how is not None:
            return replace(ended, task=task)
        other, answer = ended.answer
        if other:
            raise CannotJudgeThereError(f"a worker on {platform.node()} has {', '.join(other)}")
        return replace(ended, task=task, answer=answer)
    worker.stop()
    raise CannotJudgeThereError("the run is over")


def _judged_by_the_same(
    work: Callable[..., Any], arguments: tuple[Any, ...], run: tuple[str, int, str | None], ours: dict[str, Any]
) -> tuple[list[str], Any]:
    """Do some work, but with what we have: the files of a worker may have changed since it was asked. Else say it."""
    other = differences(all_that_decides(*run), ours)
    return other, None if other else work(*arguments)


def _judge_of(thread: int, name: str, threads: dict[str, str | None]) -> Worker:
    """Return the process that judges for a thread; a new one for a new run, whose sources may have changed.

    It has as many threads as `threads`, environment variables of the run's, let it have.
    """
    from distributed import get_worker

    if thread not in _judges or _judges[thread][0] != name:
        # dask's workers are daemons of its nannies, which Python lets have no children; ours end with their parent.
        multiprocessing.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
        for variable, value in threads.items():
            if value is None:
                os.environ.pop(variable, None)
            else:
                os.environ[variable] = value
        here = get_worker()
        _judges[thread] = name, Worker(memory_each(here.state.nthreads, here.memory_manager.memory_limit))
    return _judges[thread][1]


def _end_run(name: str) -> None:
    """End the processes of a run, those that judge and those that wait."""
    _over.add(name)
    for thread, (run, worker) in list(_judges.items()):
        if run == name and worker.is_idle:
            worker.stop()
            del _judges[thread]
