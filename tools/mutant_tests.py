"""The part of a mutation round that runs within pytest: record what each test enters, and run chosen tests.

``VEGRIP_MUTANT_TASK`` is a JSON file. With ``record`` each test is traced, and a file is left that tells the
functions of vegrip that it enters, those of a generated text that plain Python runs, the generated texts that
it loads, and how long it takes. With ``tests`` only these run, in their order, within their limits. As a
program it runs pytest in forks of itself, for each line with arguments that it reads.
"""

import contextlib
import importlib
import json
import os
import signal
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Generator, Iterator
from hashlib import sha256
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

TASK = json.loads(Path(os.environ["VEGRIP_MUTANT_TASK"]).read_text()) if __name__ != "__main__" else {}
RECORDS = "record" in TASK
ROOT = f"{Path.cwd()}/"
IMPORTED = ("cantools", "canopen", "msgpack", "numba", "scipy.optimize", "scipy.stats", "zmq")
LOADERS = {("library_of", "native.py"), ("load", "cache.py"), ("load_plain", "cache.py")}
Wrapper = Generator[None, Any, Any]
TOO_LONG = 5.0  # [s] of the processor, traced: such a test says nothing within the time of a mutant
TOO_LATE = 45  # [s]
MADE_ONCE_S = 20.0  # [s] of the processor, traced, for what is made once for several tests
CALLS = 3_000_000  # of functions in a test that are looked at: what it enters later it has entered before


def of_processor() -> float:
    """Return the time [s] that this process and those that it has started took of the processor."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


class TooLongError(BaseException):
    """Ends a test, through ``except Exception``."""


def too_long(*_: object) -> None:
    """Leave the test that runs; a module that hangs within C ends the process with the next alarm."""
    signal.alarm(60)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    raise TooLongError


class Record:
    """What the tests of this process enter."""

    def __init__(self) -> None:
        self.depth = self.calls = 0
        self.seen: dict[int, Any] = {}
        self.loaders: set[int] = set()
        self.texts: dict[str, str] = {}
        self.loaded: set[str] = set()
        self.made_once = 0.0  # [s] of the processor, within the present test for others too
        self.of_fixture: dict[tuple[str, Any], set[str]] = defaultdict(set)
        self.tests: dict[str, list[tuple[str, float, float, list[str]]]] = defaultdict(list)

    def trace(self, frame: FrameType, _event: str, _arg: object) -> None:
        """Note the function; its lines are not looked at."""
        self.calls += 1
        if self.calls > CALLS:
            sys.settrace(None)
        code = frame.f_code
        if id(code) not in self.seen:
            self.seen[id(code)] = code
            if (code.co_name, code.co_filename.rpartition("/")[2]) in LOADERS:
                self.loaders.add(id(code))
        if id(code) in self.loaders and "text" in frame.f_locals:
            self.load(frame.f_locals["text"])

    def load(self, text: str) -> None:
        """Note a generated text."""
        key = sha256(text.encode()).hexdigest()[:12]
        self.texts.setdefault(key, text)
        self.loaded.add(key)

    @contextlib.contextmanager
    def on(self) -> Iterator[set[str]]:
        """Trace what runs within, and give the set that it fills at its end."""
        outer, self.seen, self.loaded = (self.seen, self.loaded), {}, set()
        entered: set[str] = set()
        self.depth += 1
        self.calls = 0
        threading.settrace(self.trace)
        sys.settrace(self.trace)
        try:
            yield entered
        finally:
            self.depth -= 1
            if not self.depth:
                sys.settrace(None)
                threading.settrace(None)
            for code in self.seen.values():
                if code.co_filename.startswith(f"{ROOT}vegrip/"):
                    entered.add(f"{code.co_filename.removeprefix(ROOT)}:{code.co_qualname}")
                elif "/vegrip_plain_" in code.co_filename:
                    entered.add(f"generated:{code.co_name}")
            entered |= {f"text:{key}" for key in self.loaded}
            self.seen, self.loaded = {**outer[0], **self.seen}, outer[1] | self.loaded


record = Record()


@contextlib.contextmanager
def made_once(scope: str) -> Iterator[None]:
    """Do not let what is made for several tests make the first of them too long."""
    if scope == "function":
        yield
        return
    begun = of_processor()
    left, late = signal.setitimer(signal.ITIMER_PROF, MADE_ONCE_S)[0], signal.alarm(4 * TOO_LATE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, left)
        signal.alarm(late)
        record.made_once += of_processor() - begun


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any) -> Wrapper:
    """What a fixture of a module enters counts for each of its tests, not only for the first."""
    if not RECORDS:
        return (yield)
    with made_once(fixturedef.scope), record.on() as entered:
        result = yield
    record.of_fixture[fixturedef.argname, getattr(fixturedef, "baseid", "")] |= entered
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: Any) -> Wrapper:
    """Run a test within its time, traced or not."""
    if not RECORDS:
        most, seconds = TASK["limits"][item.nodeid]
        Path(TASK["running"]).write_text(item.nodeid)
        signal.setitimer(signal.ITIMER_PROF, most)
        signal.alarm(int(seconds))
        result = yield
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.alarm(int(TASK["limit"]))
        return result
    file = item.nodeid.partition("::")[0]
    if sum(spent for _, _, spent, _ in record.tests[file]) > TASK["enough"]:
        return (yield from leave_out(item))
    signal.signal(signal.SIGALRM, too_long)
    signal.signal(signal.SIGPROF, too_long)
    signal.setitimer(signal.ITIMER_PROF, TOO_LONG)
    signal.alarm(TOO_LATE)
    begun, of_begun, item.failed, record.made_once = time.monotonic(), of_processor(), False, 0.0
    with record.on() as entered:
        result = yield
    signal.alarm(0)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    seconds, spent = time.monotonic() - begun, of_processor() - of_begun
    for defs in item._fixtureinfo.name2fixturedefs.values():
        for one in defs:
            entered |= record.of_fixture.get((one.argname, one.baseid), set())
    counts = not item.failed and spent - record.made_once < TOO_LONG
    entered = {*entered, file} if counts else set()  # it counts, though it may hold constants alone
    record.tests[file].append((item.nodeid, round(seconds, 3), round(spent, 3), sorted(entered)))
    return result


def leave_out(item: pytest.Item) -> Wrapper:
    """Skip a test."""
    item.add_marker(pytest.mark.skip("its file has taken enough time"))
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: Any) -> Wrapper:
    """Note what fails, or is left out."""
    report = yield
    if not report.passed:
        item.failed = True
    return report


def pytest_runtest_setup() -> None:
    """Leave out what does not fit into the time of a mutant."""
    if not RECORDS and of_processor() > TASK["seconds"]:
        pytest.skip("no time is left for this mutant")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Take the tests of the task, in its order; for a record the slow ones last, as time may be over then."""
    if RECORDS:
        items.sort(key=lambda one: one.get_closest_marker("slow") is not None)
    elif TASK["tests"]:
        place = {name: i for i, name in enumerate(TASK["tests"])}
        items[:] = sorted((one for one in items if one.nodeid in place), key=lambda one: place[one.nodeid])


def pytest_configure() -> None:
    """Do not wait for a module that never ends, nor for numba."""
    signal.alarm(int(TASK["limit"]))
    if TASK.get("plain"):
        from vegrip.model import cache  # noqa: PLC0415

        cache.load = cache.load_plain


def pytest_sessionfinish() -> None:
    """Write a record for each file of tests that is through."""
    for file, tests in record.tests.items():
        names = sorted({name for *_, entered in tests for name in entered})
        place = {name: i for i, name in enumerate(names)}
        rows = [(*one, [place[name] for name in entered]) for *one, entered in tests]
        texts = {name[5:]: record.texts[name[5:]] for name in names if name.startswith("text:")}
        Path(TASK["record"][file]).write_text(json.dumps({"names": names, "tests": rows, "texts": texts}))


def serve(where: str, said: str) -> None:
    """Run pytest within ``where`` for each line of arguments; answer with its code and processor time [s]."""
    for name in IMPORTED:
        importlib.import_module(name)
    for line in sys.stdin:
        child = os.fork()
        if not child:
            os.setsid()
            os.chdir(where)
            sys.path.insert(0, where)
            out = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            for number in (1, 2):
                os.dup2(out, number)
            code = int(pytest.main(json.loads(line)))
            sys.stdout.flush()
            os._exit(code)
        _, status, used = os.wait4(child, 0)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)  # what a test has left behind
        print(json.dumps([os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime]), flush=True)


if __name__ == "__main__":
    serve(*sys.argv[1:])
