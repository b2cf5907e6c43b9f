"""Small files that unpack to a great deal are refused before they eat the memory."""

import gzip
import json
import subprocess
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from can.io import blf

from vegrip.errors import RecordingError
from vegrip.identification.recording import mcap as mcap_file
from vegrip.identification.recording import read_recording, table
from vegrip.identification.recording.can_log import read_can_log

ABOUT = "[fingertip]\nradius = 0.008\n"


def recording(folder: Path, text: bytes) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "recording.toml").write_text(ABOUT)
    (folder / "recording.csv.gz").write_bytes(gzip.compress(text))
    return folder


def bombs() -> Iterator[tuple[str, bytes, str]]:
    head = b"t,normal_force\n"
    yield "one line", head + b"1" * 3_000_000, "more than 1000000 characters"
    yield "a header of one line", b"t," * 1_000_000, "more than 1000000 characters"
    yield "many rows", head + b"".join(b"%d,1\n" % i for i in range(6000)), "more than 10000 numbers"
    yield "empty lines", head + b"\n" * 20_000, "more than 10000 lines"
    yield "rows much wider than the header", head + (b"," * 9000 + b"\n") * 100, "more than 10000 numbers"


@pytest.mark.parametrize(("text", "words"), [b[1:] for b in bombs()], ids=[b[0] for b in bombs()])
def test_a_table_beyond_the_bounds_is_refused(
    text: bytes, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table, "MOST_CELLS", 10_000)
    monkeypatch.setattr(table, "MOST_CELLS_ALL", 40_000)
    with pytest.raises(RecordingError, match=words):
        read_recording(recording(tmp_path / "x", text))


@pytest.mark.parametrize(
    "row",
    [b"7,1\n", b"8,1\n7,1\n7,1\n", b"x,1\n", b"1\n"],
    ids=["still", "to and fro", "no number", "no field"],
)
def test_a_table_of_rows_of_no_use_is_refused_early(
    row: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table, "MOST_LOST", 1000)
    monkeypatch.setattr(table, "BLOCK_ROWS", 500)
    good = b"t,normal_force\n" + b"".join(b"%d,1\n" % i for i in range(3000))
    with pytest.raises(RecordingError, match=r":[345]\d\d\d: more than 1000 rows so far are of no use: 't'"):
        read_recording(recording(tmp_path / "x", good + row * 9000))
    assert read_recording(recording(tmp_path / "x", good + row * 200)).report.rows_lost > 0


def test_a_megabyte_that_is_gigabytes_costs_little_memory(tmp_path: Path) -> None:
    folder = recording(tmp_path / "x", b"t,normal_force\n")
    rows = gzip.compress((b"," * 999_000 + b"\n") * 10)
    (folder / "recording.csv.gz").write_bytes(gzip.compress(b"t,normal_force\n") + 5 * rows)
    command = (
        "import sys; from vegrip.identification.recording import read_recording, table; "
        "import vegrip.errors; table.MOST_CELLS_ALL //= 8\n"
        "try: read_recording(sys.argv[1])\n"
        "except vegrip.errors.RecordingError as error: print(error)\n"
        "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", command, str(folder)], capture_output=True, text=True, check=True, timeout=120
    )
    said, most = done.stdout.splitlines()
    assert "holds more than 64000000 numbers" in said
    assert int(most) < 600_000, "kB; all rows at once are gigabytes"


ROWS = tuple(json.dumps({"t": i / 100, "normal_force": 1.0}).encode() for i in range(100))


def mcap(path: Path, rows: tuple[bytes, ...], compression: str = "zstd", metadata: bytes = b"") -> Path:
    writer_of = pytest.importorskip("mcap.writer", reason="the extra `bags` is not installed")
    with path.open("wb") as file:
        writer = writer_of.Writer(
            file, chunk_size=2**30, compression=getattr(writer_of.CompressionType, compression.upper())
        )
        writer.start(library="vegrip")
        writer.add_attachment(0, 0, "recording.toml", "application/toml", ABOUT.encode())
        schema = writer.register_schema("x", "jsonschema", b"{}" + metadata)
        about = {"file": "recording.csv", "columns": "t,normal_force", "rows": str(len(rows))}
        channel = writer.register_channel("/hand/thumb/state", "json", schema, about)
        for i, row in enumerate(rows):
            writer.add_message(channel, i, row, i, i)
        writer.finish()
    return path


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_a_chunk_that_unpacks_to_more_than_the_bound_is_refused_and_nothing_is_left(
    compression: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = mcap(tmp_path / "x.mcap", ROWS[:5], compression, bytes(2**21))
    monkeypatch.setattr(mcap_file, "MAX_RECORD_BYTES", 2**20)
    with pytest.raises(RecordingError, match=r"unpacks to more than|is not a whole MCAP file"):
        mcap_file.read_mcap(path, tmp_path / "out")
    assert [each.name for each in tmp_path.iterdir()] == ["x.mcap"]


def test_tables_that_are_too_large_for_the_memory_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = mcap(tmp_path / "x.mcap", ROWS)
    assert len(next(iter(mcap_file.read_mcap(path, tmp_path / "out").values()))) == 100
    monkeypatch.setattr(mcap_file, "MOST_TEXT", 5000)
    with pytest.raises(RecordingError, match="more than 5000 bytes of tables"):
        mcap_file.read_mcap(path, tmp_path / "other")


@pytest.mark.parametrize("t", ["9" * 5000, "1e999", '"x"'])
def test_an_mcap_file_that_is_refused_late_leaves_nothing(t: str, tmp_path: Path) -> None:
    whole = mcap(tmp_path / "x.mcap", (b'{"t": %s, "normal_force": 1.0}' % t.encode(),))
    with pytest.raises(RecordingError):
        mcap_file.read_mcap(whole, tmp_path / "out")
    assert [each.name for each in tmp_path.iterdir()] == ["x.mcap"]


def test_a_can_log_whose_container_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.blf"
    with can.Logger(path) as logger:
        logger(can.Message(timestamp=1000.0, arbitration_id=1, data=bytes(8), is_extended_id=False))
    with pytest.raises(RecordingError, match="is a fingertip's state"):
        read_can_log(path, ("thumb",))
    data = path.read_bytes()
    start = data.index(b"LOBJ")
    packing = zlib.compressobj(9)
    packed = b"".join([*(packing.compress(bytes(10**6)) for _ in range(70)), packing.flush()])
    head = blf.OBJ_HEADER_BASE_STRUCT.pack(b"LOBJ", 16, 1, 32 + len(packed), blf.LOG_CONTAINER)
    about = blf.LOG_CONTAINER_STRUCT.pack(blf.ZLIB_DEFLATE, 70 * 10**6)
    path.write_bytes(data[:start] + head + about + packed + bytes(len(packed) % 4) + data[start:])
    with pytest.raises(RecordingError, match="unpacks to more than 67108864 bytes"):
        read_can_log(path, ("thumb",))
