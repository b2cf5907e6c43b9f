"""Examine recordings on all cores, or on a Dask cluster; one that fails is a row, and never the end."""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from vegrip.errors import DeviceError, UsageError
from vegrip.identification.fleet.row import FAILED, Found, Row, examine_recording

CONNECT = 10.0  # [s] to reach a scheduler
TASKS_PER_CORE = 2  # in flight on a cluster: one at work, one on its way
DIED = "the process that examined it died, twice (memory?)"
Attempt = Callable[[Sequence[Found], list[Found]], Iterator[tuple[Found, Row]]]
"""Yields rows of recordings, and appends those that a process may have died of."""

SINGLE = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""One thread per process: the processes are as many as the cores."""


def run(
    found: Sequence[Found], model: str = "", *, processes: int = 0, scheduler: str = ""
) -> Iterator[tuple[Found, Row]]:
    """Yield each recording with its row as it becomes ready.

    Args:
        found: what to examine.
        model: file to start from; a cluster must see it, and the recordings, under the same path.
        processes: on this machine; 0 = as many as it has cores.
        scheduler: address of a Dask scheduler, ``tcp://host:8786``; empty = this machine.

    Raises:
        UsageError: a cluster is asked for, but its library is not there.
        DeviceError: the scheduler does not answer.

    """
    if scheduler:
        return _on_cluster(found, model, scheduler)
    return _here(found, model, processes or len(os.sched_getaffinity(0)))


def _here(found: Sequence[Found], model: str, processes: int) -> Iterator[tuple[Found, Row]]:
    with _Alone():
        yield from _tried_twice(found, lambda some, died: _pooled(some, model, processes, died))


def _on_cluster(found: Sequence[Found], model: str, scheduler: str) -> Iterator[tuple[Found, Row]]:
    try:
        from distributed import Client  # noqa: PLC0415
    except ImportError as error:
        raise UsageError("a cluster needs Dask; pip install 'vegrip[fleet]'") from error
    try:
        client = Client(scheduler, timeout=CONNECT)
    except (OSError, ValueError, TimeoutError) as error:
        raise DeviceError(f"the scheduler {scheduler} does not answer ({error})") from None
    with client:
        yield from _tried_twice(found, lambda some, died: _submitted(client, some, model, died))


def _tried_twice(found: Sequence[Found], attempt: Attempt) -> Iterator[tuple[Found, Row]]:
    """Yield all rows; recordings that were at work when a process died are tried once more, alone."""
    doubtful: list[Found] = []
    left = list(found)
    while left:
        done: list[Found] = []
        died: list[Found] = []
        for one, row in attempt(left, died):
            done.append(one)
            yield one, row
        doubtful += died
        left = [one for one in left if one not in done and one not in died]
    for one in doubtful:
        died = []
        yield from attempt([one], died)
        if died:
            yield one, Row(one.path, FAILED, note=DIED, is_machine_failure=True)


def _pooled(
    found: Sequence[Found], model: str, processes: int, died: list[Found]
) -> Iterator[tuple[Found, Row]]:
    """Yield rows until all are there or a process dies; then ``died`` has those it may have died of."""
    context = multiprocessing.get_context("spawn")  # no copies of threads and locks of this process
    with ProcessPoolExecutor(min(processes, len(found)), mp_context=context) as pool:
        waiting = list(reversed(found))
        running: dict[Future[Row], Found] = {}
        while waiting or running:
            while waiting and len(running) < processes:
                one = waiting.pop()
                running[pool.submit(examine_recording, one.path, model)] = one
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                one = running.pop(future)
                try:
                    row = future.result()
                except BrokenProcessPool:
                    died += [one, *running.values()]
                    return
                yield one, row


def _submitted(
    client: Any, found: Sequence[Found], model: str, died: list[Found]
) -> Iterator[tuple[Found, Row]]:
    """Yield the rows of a cluster; ``died`` gets those whose workers died.

    Dask holds the death of a worker against every task that it had, and gives a task up after four, so a
    sound recording may be given up with the one that kills. Few in flight are few of them.
    """
    from distributed import KilledWorker, as_completed  # noqa: PLC0415

    waiting = list(reversed(found))
    running: dict[Any, Found] = {}
    ready = as_completed()
    while waiting or running:
        while waiting and len(running) < TASKS_PER_CORE * max(sum(client.ncores().values()), 1):
            one = waiting.pop()
            future = client.submit(examine_recording, str(Path(one.path).resolve()), model, pure=False)
            running[future] = one
            ready.add(future)
        future = next(ready)
        one = running.pop(future)
        if future.status == "finished":
            yield one, future.result()
        elif future.status != "error":
            raise DeviceError(
                "the scheduler is lost; what was examined is kept, and a new run goes on from there"
            )
        elif isinstance(error := future.exception(), KilledWorker):
            died.append(one)
        else:
            yield one, Row(one.path, FAILED, note=f"on the cluster: {error}", is_machine_failure=True)


class _Alone:
    def __enter__(self) -> None:
        self._before = {name: os.environ.get(name) for name in SINGLE}
        os.environ.update(dict.fromkeys(SINGLE, "1"))

    def __exit__(self, *_: object) -> None:
        for name, value in self._before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
