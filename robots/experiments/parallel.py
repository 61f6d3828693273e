"""The same task for many items, in several processes at once.

Results come in the order of the items and depend on the items alone, so that the number of processes changes
nothing but the time. This module imports no numpy: its threads are counted when it is first imported.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

from robots.experiments.experiment import ExperimentError

Item = TypeVar("Item")
Result = TypeVar("Result")

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def in_parallel(
    task: Callable[[Item], Result],
    items: Sequence[Item],
    jobs: int,
    progress: Callable[[int, int], None],
) -> list[Result]:
    """Return ``task(item)`` of every item, in ``jobs`` processes of one thread each.

    Args:
        task: a function of a module, so that another process finds it; it draws from no global state.
        items: what it is given, small enough to be sent.
        jobs: 1 works in this process.
        progress: told how many are done, and of how many.

    Raises:
        ExperimentError: a process was killed, as happens when memory runs out.
        Exception: whatever the task raises.
    """
    results: list[Result] = []
    progress(0, len(items))
    if jobs <= 1 or len(items) <= 1:
        for item in items:
            results.append(task(item))
            progress(len(results), len(items))
        return results
    for name in _THREADS:
        os.environ.setdefault(name, "1")  # inherited by the processes that are started now
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(items)), mp_context=context, initializer=_deaf_to_interrupts)
    try:
        for result in pool.map(task, items):
            results.append(result)
            progress(len(results), len(items))
    except BrokenProcessPool as error:
        raise ExperimentError("a process was killed; try again with fewer --jobs") from error
    except KeyboardInterrupt:
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()  # what it is at may take half a minute
        raise
    finally:
        pool.shutdown(cancel_futures=True)
    return results


def _deaf_to_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asked for the work
