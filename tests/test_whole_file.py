"""A file is written whole, or what was there stays."""

import os
import re
import resource
import signal
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import vegrip
from vegrip.errors import VegripError
from vegrip.identification.recording import Recording, read_recording, write_recording
from vegrip.identification.samples import SAMPLES
from vegrip.identification.simulate.protocol import standard, write_protocol
from vegrip.model import paper_model, write_model
from vegrip.whole_file import whole_file, write_whole

ROOM = 64  # [bytes] of a file on the disk that is full


@contextmanager
def full_disk() -> Iterator[None]:
    """Let no file grow beyond ``ROOM``: what a write to a full disk raises, at the same places."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)


def press(rows: int = 500) -> Recording:
    t = np.arange(rows) / 100.0
    return Recording("press", t, np.zeros(rows, int), {"normal_force": t})


def draw(path: Path) -> None:
    pytest.importorskip("matplotlib")
    from vegrip.plotting import new_figure, save_figure

    save_figure(new_figure(1, size=(2.0, 2.0))[0], path)


WRITERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "model": ("model.toml", lambda path: write_model(paper_model(8e-3), path)),
    "motion": ("motion.toml", lambda path: write_protocol(standard(paper_model(8e-3)), path)),
    "picture": ("picture.png", draw),
    "recording": ("press", lambda path: write_recording(press(), path)),
    "packed recording": ("press", lambda path: write_recording(press(20_000), path, compressed=True)),
    **{name: (name, one.write) for name, one in SAMPLES.items()},
}


@pytest.mark.parametrize("kind", WRITERS)
def test_a_full_disk_leaves_nothing_where_nothing_was(kind: str, tmp_path: Path) -> None:
    name, write = WRITERS[kind]
    (tmp_path / "once").mkdir()
    write(tmp_path / "once" / name)  # whatever is cached or compiled on the way
    with full_disk(), pytest.raises((OSError, VegripError)):
        write(tmp_path / name)
    assert [each.name for each in tmp_path.iterdir()] == ["once"]


@pytest.mark.parametrize("kind", WRITERS)
def test_a_full_disk_leaves_what_was_there(kind: str, tmp_path: Path) -> None:
    name, write = WRITERS[kind]
    write(tmp_path / name)
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    before = {path: path.read_bytes() for path in files}
    with full_disk(), pytest.raises((OSError, VegripError)):
        write(tmp_path / name)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_recording_that_is_packed_anew_has_one_table(tmp_path: Path) -> None:
    write_recording(press(9), tmp_path / "press")
    table = tmp_path / "press" / "recording.csv"
    write_recording(press(5), tmp_path / "press", compressed=True)
    assert not table.exists()
    assert len(read_recording(tmp_path / "press")) == 5


def test_permissions_and_links_stay(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "real").chmod(0o604)
    (tmp_path / "link").symlink_to("real")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"
    assert stat.S_IMODE((tmp_path / "real").stat().st_mode) == 0o604


def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_whole(tmp_path / "pipe", b"told")
    assert os.read(reader, 9) == b"told"
    os.close(reader)
    assert (tmp_path / "pipe").is_fifo()


def test_an_interruption_leaves_nothing_beside(tmp_path: Path) -> None:
    def interrupted() -> None:
        with whole_file(tmp_path / "x.toml") as part:
            part.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


# a log that grows; a description that must fit on a full disk
OTHERWISE = {
    "identification/recording/writer.py",
}


def test_files_are_written_through_one_helper() -> None:
    root = Path(vegrip.__file__).parent
    sources = {path.relative_to(root).as_posix(): path.read_text() for path in root.rglob("*.py")}
    found = {
        name
        for name, text in sources.items()
        if re.search(r"\.(?:write_text|write_bytes|savefig)\(|open\([^)]*\"wb?\"", text)
        and "whole_file" not in text
    }
    assert found <= OTHERWISE, found - OTHERWISE
