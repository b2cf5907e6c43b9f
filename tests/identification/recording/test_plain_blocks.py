"""A block of plain numbers is read at once, and exactly as cell by cell; memory is that of a block."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from vegrip.errors import RecordingError
from vegrip.identification.recording import Recording, table, write_recording
from vegrip.identification.recording.report import LoadReport
from vegrip.identification.recording.table import Layout, read_table

TABLES = {
    "plain": b"t,a,b\n0,1,2\n1,2e-300,-0.0\n2,0.1,1e22\n",
    "spaces and nan": b"t,a,b\n 0 ,1, nan\n1,NaN,3\n",
    "windows": b"t,a,b\r\n0,1,2\r\n1,2,3\r\n",
    "blank lines": b"t,a,b\n0,1,2\n\n   \n1,2,3\n\n",
    "empty cell": b"t,a,b\n0,,2\n1,2,\n",
    "a word": b"t,a,b\n0,x,2\n1,2,3\n",
    "a thousand written 1_000": b"t,a,b\n0,1_000,2\n1,2,3\n",
    "infinite": b"t,a,b\n0,inf,2\n1,1e400,3\n2,3,4\n",
    "short and long rows": b"t,a,b\n0,1\n1,2,3,4\n2,3,4\n",
    "quoted": b't,a,b\n0,"1",2\n1,"2",3\n',
    "no last line end": b"t,a,b\n0,1,2\n1,2,3",
    "a comment sign": b"t,a,b\n0,1,2\n#1,2,3\n",
    "another column of words": b"t,a,b,note\n0,1,2,good\n1,2,3,bad one\n",
}


@pytest.mark.parametrize("sealed", [False, True])
@pytest.mark.parametrize("name", TABLES)
def test_both_ways_read_the_same(
    name: str, sealed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(TABLES[name])
    words = ["note"] if b"note" in TABLES[name] else []
    reports, tables = [], []
    for quick in (True, False):
        if not quick:
            monkeypatch.setattr(table, "_plain_block", lambda *_: None)
        reports.append(LoadReport())
        tables.append(read_table(path, ["t", "a", "b"], words, Layout(sealed=sealed), reports[-1]))
    assert reports[0] == reports[1]
    assert tables[0].words == tables[1].words
    np.testing.assert_array_equal(tables[0].lines, tables[1].lines)
    for column in ("t", "a", "b"):
        assert tables[0].numbers[column].tobytes() == tables[1].numbers[column].tobytes()


def test_a_plain_table_takes_the_quick_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "t.csv").write_bytes(TABLES["plain"])
    monkeypatch.setattr(table, "_converted", None)
    assert len(read_table(tmp_path / "t.csv", ["t", "b"], [], Layout(), LoadReport()).lines) == 3


def test_a_byte_that_is_no_text_is_named_by_its_own_line(tmp_path: Path) -> None:
    (tmp_path / "latin.csv").write_bytes(b"t,a\n0,1\n" * 1 + b"1,2\n" * 40 + b"2,\xb5\n" + b"3,4\n")
    with pytest.raises(RecordingError, match=r"latin\.csv:43: is not a text file"):
        read_table(tmp_path / "latin.csv", ["t", "a"], [], Layout(), LoadReport())


@pytest.mark.long
def test_writing_needs_the_memory_of_a_block_only(tmp_path: Path) -> None:
    n = 200_000
    t = np.arange(n) * 1e-3
    recording = Recording("r", t, np.zeros(n, dtype=np.int64), {"normal_force": np.sin(t)})
    tracemalloc.start()
    write_recording(recording, tmp_path / "r")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 0.8 * (tmp_path / "r" / "recording.csv").stat().st_size
