"""Whoever builds the same sources at the same SOURCE_DATE_EPOCH gets the same wheel, bit for bit."""

import hashlib
import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EPOCH = 1_750_000_000  # [s] since 1970
pytestmark = pytest.mark.wheel


def build(kind: str, source: Path, out: Path, epoch: int) -> Path:
    command = [sys.executable, "-m", "build", "-q", "--no-isolation", kind, "--outdir", str(out), str(source)]
    dated = os.environ | {"SOURCE_DATE_EPOCH": str(epoch)}
    done = subprocess.run(command, env=dated, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (made,) = out.iterdir()
    return made


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The sources twice, in folders of different depth, with files of different ages."""
    folder = tmp_path_factory.mktemp("sources")
    packed = build("--sdist", ROOT, folder / "packed", EPOCH)
    found = []
    for place, age in ((folder / "one", 1_600_000_000), (folder / "a" / "deeper" / "one", 1_700_000_123)):
        with tarfile.open(packed) as archive:
            archive.extractall(place, filter="data")
        for path in place.rglob("*"):
            os.utime(path, (age, age))
        found.append(next(place.iterdir()))
    return found[0], found[1]


@pytest.fixture(scope="module")
def wheel(sources: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the first of the sources gives at EPOCH."""
    return build("--wheel", sources[0], tmp_path_factory.mktemp("wheel") / "dist", EPOCH)


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_two_builds_of_one_source_are_one_wheel(
    sources: tuple[Path, Path], wheel: Path, tmp_path: Path
) -> None:
    other = build("--wheel", sources[1], tmp_path / "other", EPOCH)
    assert wheel.name == other.name
    assert digest(wheel) == digest(other)


def test_the_date_is_that_of_the_epoch_and_not_of_the_build(
    sources: tuple[Path, Path], wheel: Path, tmp_path: Path
) -> None:
    """Without this the test above could pass because nothing is dated, or because both builds are quick."""
    later = build("--wheel", sources[0], tmp_path / "later", EPOCH + 86_400)
    assert digest(wheel) != digest(later)


def test_the_wheel_carries_the_list_of_references(wheel: Path) -> None:
    """In the sources it is a link into docs, which a wheel does not have."""
    with zipfile.ZipFile(wheel) as packed:
        carried = packed.read("vegrip/web/report/references.bib")
    assert carried == (ROOT / "docs" / "references.bib").read_bytes()
