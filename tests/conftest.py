"""What all tests share."""

import fcntl
import gc
import os
import pickle
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest
from hypothesis import HealthCheck, settings

from vegrip.c99 import host

# The same examples in every run, and no complaint about a slow machine; VEGRIP_EXAMPLES=1000 draws others.
EXAMPLES = os.environ.get("VEGRIP_EXAMPLES", "")
settings.register_profile(
    "vegrip",
    max_examples=int(EXAMPLES or 50),
    derandomize=not EXAMPLES,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("vegrip")

# Estimators of many models: the C compiler takes 2 s for one, numba 20 s, and the numbers are the same
# (tests/c99). `make test-numba` runs what depends on them most with numba, which is what runs by default.
if host.compiler():
    os.environ.setdefault("VEGRIP_KERNEL", "c")

# Nodes of tests stand beside each other and beside the other programs of the machine.
os.environ.setdefault("VEGRIP_REALTIME", "0")


# What is imported and collected stays to the end: the garbage collector need not look through it again and
# again, which takes a tenth of the time of all tests.


def pytest_collection() -> None:
    """Leave garbage alone while there is hardly any."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Look from now on only at what tests make."""
    gc.freeze()
    gc.enable()


Made = TypeVar("Made")
Once = Callable[[str, Callable[[Path], Made]], Made]


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Once[Made]:
    """Make what many tests read, once for all workers of a run, in a folder that they share."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root

    def made(name: str, make: Callable[[Path], Made]) -> Made:
        folder = root / name
        kept = folder / "returned"
        with (root / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not kept.exists():
                folder.mkdir(exist_ok=True)
                kept.write_bytes(pickle.dumps(make(folder)))
        found: Made = pickle.loads(kept.read_bytes())  # noqa: S301 (of this run)
        return found

    return made


DATA = Path(os.environ.get("VEGRIP_DATA", Path(__file__).parents[2] / "shared" / "data"))


@pytest.fixture(scope="session")
def measured() -> Callable[[str], Path]:
    """Give the folder of a set of measured recordings, or skip: they are not part of the project."""

    def folder(name: str) -> Path:
        path = DATA / name
        if not path.is_dir():
            pytest.skip(f"measured recordings {path} are absent (set VEGRIP_DATA)")
        return path

    return folder


@pytest.fixture
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A runtime folder of this test alone, with a path short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="vg-") as folder:
        monkeypatch.setenv("VEGRIP_RUNTIME_DIR", f"{folder}/r")
        yield folder
