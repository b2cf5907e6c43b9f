"""Pages in a browser: Chromium of the distribution, and programs of vegrip beside it."""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
MUST = "VEGRIP_WEB_TESTS"  # set by `make test-web`: a missing browser is then a failure
HINT = "no Chromium here: apt-get install chromium, then `make test-web`"
PATIENCE = 120.0  # [s] on a busy machine


def browser_path() -> str:
    if not os.environ.get(MUST):
        pytest.skip("the pages are tested by `make test-web`, in the distribution's Chromium")
    found = next((path for name in BROWSERS if (path := shutil.which(name))), "")
    if not found:
        pytest.fail(HINT)
    return found


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    path = browser_path()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def until() -> Callable[[object, str], None]:
    """Wait for a JavaScript expression to be true; the page's policy forbids playwright's own way."""

    def wait(page, expression: str) -> None:
        end = time.monotonic() + PATIENCE
        while not page.evaluate(expression):
            assert time.monotonic() < end, f"never came true: {expression}"
            time.sleep(0.05)

    return wait


class Visit:
    """A page that remembers what went wrong in it and whom it asked."""

    def __init__(self, browser, **options) -> None:
        options.setdefault("viewport", {"width": 1440, "height": 1100})
        options.setdefault("reduced_motion", "reduce")
        self.context = browser.new_context(**options)
        self.context.set_default_timeout(PATIENCE * 1000)
        self.page = self.context.new_page()
        self.errors: list[str] = []
        self.hosts: set[str] = set()
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._note)
        self.page.on("request", lambda request: self.hosts.add(request.url.split("/")[2].split(":")[0]))

    def _note(self, message) -> None:
        if message.type == "error" and not message.text.startswith("Failed to load resource"):
            self.errors.append(
                message.text
            )  # a refusal or a server that has gone is what some tests are about


@pytest.fixture
def visit(browser) -> Iterator[Callable[..., Visit]]:
    made: list[Visit] = []

    def make(**options) -> Visit:
        made.append(Visit(browser, **options))
        return made[-1]

    yield make
    for one in made:
        one.context.close()
    for one in made:
        assert one.errors == []
        assert one.hosts <= {"127.0.0.1"}  # nothing is asked of another machine


class Program:
    """A command of vegrip in a process of its own, with what it prints in a file."""

    def __init__(self, folder: Path, runtime: str, *arguments: str) -> None:
        self.output = folder / f"{arguments[0]}-{time.monotonic_ns()}.txt"
        with self.output.open("w") as out:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "vegrip", *arguments],
                cwd=folder,
                env=os.environ | {"VEGRIP_RUNTIME_DIR": runtime},
                stdout=out,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def text(self) -> str:
        return self.output.read_text()

    def waits_for(self, pattern: str) -> str:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if found := re.search(pattern, self.text):
                return found[0]
            assert self.process.poll() is None, self.text
            time.sleep(0.05)
        raise AssertionError(f"{pattern} did not come: {self.text}")

    def end(self, how: signal.Signals = signal.SIGINT) -> int:
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            return self.process.wait(30)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            raise


class World:
    """A machine of its own: programs that find one another, and no others."""

    def __init__(self, folder: Path, runtime: str) -> None:
        self.folder, self.runtime = folder, runtime
        self._started: list[Program] = []

    def start(self, *arguments: str) -> Program:
        self._started.append(Program(self.folder, self.runtime, *arguments))
        return self._started[-1]

    def close(self) -> None:
        for program in reversed(self._started):
            program.end()


@contextmanager
def new_world(folder: Path) -> Iterator[World]:
    with tempfile.TemporaryDirectory(prefix="vg-") as short, closing(World(folder, f"{short}/r")) as world:
        yield world


@pytest.fixture
def world(tmp_path) -> Iterator[World]:
    """A machine for this test alone."""
    with new_world(tmp_path) as made:
        yield made


@pytest.fixture(scope="module")
def shared(tmp_path_factory) -> Iterator[World]:
    """A machine for all tests of a file: starting a hand takes longer than looking at it."""
    with new_world(tmp_path_factory.mktemp("shared")) as made:
        yield made


@pytest.fixture
def start(world) -> Callable[..., Program]:
    return world.start
