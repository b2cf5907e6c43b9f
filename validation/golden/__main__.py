"""Run the cases and compare with the golden answers: ``python -m validation.golden``.

Exit code 0: all is as it was; 4: something differs, and what is printed. Who means a difference runs
``--update`` and looks at what ``git diff`` shows of the plain numbers.
"""

import logging

import validation.golden.scripted  # isort: skip # noqa: F401 (first: vegrip keeps functions of time)

import argparse
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

from validation.golden import offline, store
from validation.golden.cases import Case, cases
from validation.golden.play import lines_of, numbers_of, play
from validation.golden.settings import SETTINGS
from validation.golden.store import Answered

DIFFERS = 4
SAVED_EVERY = 40  # answers, so that a long run that is ended is not lost
WAYS = ("", "objects", "c", "numba", "python")


@dataclass(frozen=True)
class Job:
    """One entry of the file, and how it is made."""

    name: str
    answer: Callable[[], Answered]
    is_quick: bool = False


def answered(case: Case, way: str) -> Answered:
    """Return what a node answers in a case."""
    setting = SETTINGS[case.setting]
    answers = play(case.wire, setting, case.tape(), case.seed, way)
    return Answered(case.name, lines_of(answers), numbers_of(answers), setting.has_contacts)


@dataclass(frozen=True)
class OfNode:
    """Lets a node answer a case."""

    case: Case
    way: str

    def __call__(self) -> Answered:
        """Return its answers."""
        return answered(self.case, self.way)


def jobs(way: str = "") -> Iterator[Job]:
    """Yield all entries of the file."""
    for case in cases():
        yield Job(case.name, OfNode(case, way), case.is_quick)
    if way:
        return
    for export in offline.exports():
        yield Job(export.name, export, is_quick=export.model == "paper")
    for recording in offline.recordings():
        yield Job(offline.RECORDING + recording.name, recording)


def _run(job: Job) -> Answered | str:
    try:
        return job.answer()
    except Exception as error:  # noqa: BLE001 (one case that fails must not hide the others)
        return f"{type(error).__name__}: {error}"


def results(chosen: Sequence[Job], workers: int) -> Iterator[tuple[Job, Answered | str]]:
    """Run jobs beside each other; yield them in their order."""
    if workers <= 1:
        yield from ((job, _run(job)) for job in chosen)
        return
    with ProcessPoolExecutor(workers, multiprocessing.get_context("fork")) as pool:
        yield from zip(chosen, pool.map(_run, chosen, chunksize=4), strict=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and compare; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m validation.golden", description=__doc__)
    parser.add_argument("--update", action="store_true", help="write the answers into golden.json")
    parser.add_argument(
        "--only", default="", metavar="PATTERN", help="cases with all these words in the name"
    )
    parser.add_argument("--quick", action="store_true", help="what CI runs: few and short cases")
    parser.add_argument("--missing", action="store_true", help="only cases that golden.json does not have")
    parser.add_argument("--list", action="store_true", help="say what cases there are")
    parser.add_argument(
        "--tolerance", type=float, metavar="X", help="compare plain numbers alone, to a share X"
    )
    parser.add_argument(
        "-j", type=int, default=os.cpu_count() or 1, metavar="N", help="processes beside each other"
    )
    parser.add_argument(
        "--way", default="", choices=WAYS, help="what answers: objects, or what runs the step"
    )
    given = parser.parse_args(arguments)
    chosen = [
        job
        for job in jobs(given.way)
        if (job.is_quick or not given.quick) and all(word in job.name for word in given.only.split())
    ]
    chosen.sort(key=lambda job: not job.is_quick)
    expected, new = store.read(), dict[str, Any]()
    if given.missing:
        chosen = [job for job in chosen if job.name not in expected]
    if given.list:
        sys.stdout.writelines(f"{job.name}{' (quick)' if job.is_quick else ''}\n" for job in chosen)
        return 0
    began, failed = time.monotonic(), 0
    for job, found in results(chosen, given.j):
        if isinstance(found, str):
            failed += 1
            _say(f"{job.name}: {found}")
            continue
        if given.update:
            new[job.name] = found.entry
            store.keep(found)
            if len(new) % SAVED_EVERY == 0:
                store.write(store.read() | new)
        elif complaints := store.differences(found, expected.get(job.name), given.tolerance):
            failed += 1
            _say(f"{job.name}:\n" + "\n".join(f"  {complaint}" for complaint in complaints))
    if given.update:
        known = {job.name for job in jobs()}
        kept = {
            name: entry for name, entry in (store.read() | new).items() if name in known or _is_absent(name)
        }
        store.write(kept)
    _say(f"{failed} of {len(chosen)} cases differ ({time.monotonic() - began:.0f} s)")
    return DIFFERS if failed else 0


def _is_absent(name: str) -> bool:
    """Return whether an entry is of a recording, which may not be here."""
    return name.startswith(offline.RECORDING)


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    logging.getLogger("vegrip").setLevel(logging.ERROR)  # lost input is what is played here
    sys.exit(main())
