"""CAN logs of all kinds give the same frames: encodings, times, torn lines, channels, broken objects."""

import re
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import can
import numpy as np
import pytest
from can.io import blf

from vegrip.cli import main
from vegrip.errors import RecordingError
from vegrip.identification.recording.can_frames import READERS, read_log
from vegrip.identification.recording.log_names import LOGS
from vegrip.transport.codec import Frame

COUNT = 200
FRAMES = [Frame(0x101, bytes([k % 256, 1, 2, 3, 4, 5, 6, 7]), False, 10_000_000 * k) for k in range(COUNT)]


def test_each_name_of_a_log_has_its_reader():
    assert READERS.keys() == set(LOGS)


def candump(frames=FRAMES, channel="can0", begin=0.0):
    return "".join(
        f"({begin + f.stamp / 1e9:.6f}) {channel} {f.arbitration_id:03X}#{f.data.hex().upper()}\n"
        for f in frames
    )


def asc(head="base hex  timestamps absolute", day="Thu Sep 2 09:37:49 am 2021", times=None, comment=""):
    times = [f.stamp / 1e9 for f in FRAMES] if times is None else times
    body = "".join(
        f"{t:.6f} 1  {f.arbitration_id:x}             Rx   d 8 {f.data.hex(' ')}\n"
        for t, f in zip(times, FRAMES, strict=True)
    )
    return f"date {day}\n{head}\nno internal events logged\n{comment}Begin Triggerblock {day}\n{body}"


def written(path: Path, frames=FRAMES, channels=(0,), **options) -> Path:
    with can.Logger(path, **options) as logger:
        for frame in frames:
            for channel in channels:
                logger(
                    can.Message(
                        1e9 + frame.stamp / 1e9 + 0.003 * channel,
                        frame.arbitration_id,
                        is_extended_id=False,
                        data=frame.data,
                        channel=channel,
                    )
                )
    return path


def same(found, tolerance=2000) -> None:
    assert [f.data for f in found.frames] == [f.data for f in FRAMES]
    stamps = np.array([f.stamp for f in found.frames])
    np.testing.assert_allclose(stamps - stamps[0], [f.stamp for f in FRAMES], atol=tolerance)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("suffix", [".log", ".asc"])
def test_the_encoding_of_a_text_does_not_matter(encoding, suffix, tmp_path):
    text = candump() if suffix == ".log" else asc(comment="// Prüfstand 3\n", day="Di Mär 2 09:37:49 2021")
    (tmp_path / f"a{suffix}").write_text(text, encoding=encoding)
    same(read_log(tmp_path / f"a{suffix}"))


@pytest.mark.parametrize("suffix", [".blf", ".trc", ".asc"])
def test_what_python_can_writes_is_read(suffix, tmp_path):
    same(read_log(written(tmp_path / f"a{suffix}")), tolerance=2_000_000 if suffix == ".trc" else 2000)


@pytest.mark.parametrize("count", [3, COUNT])
def test_a_blf_without_compression_is_read(count, tmp_path):
    path = written(tmp_path / "a.blf", FRAMES[:count], compression_level=0)
    assert len(read_log(path).frames) == count


def test_relative_times_are_summed_with_those_of_other_events(tmp_path):
    steps = np.diff([f.stamp / 1e9 for f in FRAMES], prepend=0.0)
    text = asc("base hex  timestamps relative", times=steps)
    lines = text.split("\n")
    at = 60
    time, rest = lines[at].split(" ", 1)
    lines[at : at + 1] = ["0.004000 1  Statistic: D 1 R 0", f"{float(time) - 0.004:.6f} {rest}"]
    (tmp_path / "a.asc").write_text("\n".join(lines))
    same(read_log(tmp_path / "a.asc"))


def test_times_before_zero_are_times(tmp_path):
    (tmp_path / "a.asc").write_text(asc(times=[f.stamp / 1e9 - 0.7 for f in FRAMES]))
    same(read_log(tmp_path / "a.asc"))
    (tmp_path / "a.log").write_text(candump(begin=-0.7))
    same(read_log(tmp_path / "a.log"))


def test_differences_of_candump_are_summed(tmp_path):
    stamps = [0] + [10_000_000] * (COUNT - 1)
    (tmp_path / "a.log").write_text(
        candump([f._replace(stamp=s) for f, s in zip(FRAMES, stamps, strict=True)])
    )
    same(read_log(tmp_path / "a.log"))


@pytest.mark.parametrize("by", [0.5, 3600.0])
def test_a_clock_that_was_set_back_goes_on(by, tmp_path):
    back = [f._replace(stamp=f.stamp - round(1e9 * by)) for f in FRAMES[100:]]
    (tmp_path / "a.log").write_text(candump(FRAMES[:100], begin=1.7e9) + candump(back, begin=1.7e9))
    found = read_log(tmp_path / "a.log")
    same(found)
    assert "the clock was set back 1 x" in found.report.summary()


@pytest.mark.parametrize("suffix", [".log", ".asc", ".trc"])
def test_a_torn_line_is_counted_and_the_rest_read(suffix, tmp_path):
    path = tmp_path / f"a{suffix}"
    if suffix == ".trc":
        written(path)
    else:
        path.write_text(candump() if suffix == ".log" else asc())
    lines = path.read_text().split("\n")
    whole = len(lines)
    lines[whole // 2] = lines[whole // 2][:-7]
    lines[whole // 3] = "garbage"
    path.write_text("\n".join(lines))
    found = read_log(path)
    assert COUNT - 2 <= len(found.frames) < COUNT
    assert found.report.rows_lost >= 1


@pytest.mark.parametrize(
    ("kind", "size", "version"), [(0, 0, 1), (65, 0, 1), (65, 0, 3), (65, 5, 1), (86, 48, 9)]
)
def test_a_blf_with_an_object_that_cannot_be_ends_with_a_sentence(kind, size, version, tmp_path):
    content = written(tmp_path / "a.blf", compression_level=0).read_bytes()
    begin = struct.unpack_from("<L", content, 4)[0]
    at, data = begin, b""
    while at < len(content):
        whole = blf.OBJ_HEADER_BASE_STRUCT.unpack_from(content, at)[3]
        data += content[at + 16 + blf.LOG_CONTAINER_STRUCT.size : at + whole]
        at += whole + whole % 4
    place = 0
    for _ in range(100):
        place = data.index(b"LOBJ", place + 4)
    changed = bytearray(data)
    struct.pack_into("<4sHHLL", changed, place, b"LOBJ", 32, version, size, kind)
    body = blf.LOG_CONTAINER_STRUCT.pack(2, len(changed)) + zlib.compress(bytes(changed))
    head = blf.OBJ_HEADER_BASE_STRUCT.pack(b"LOBJ", 16, 1, 16 + len(body), 10)
    (tmp_path / "b.blf").write_bytes(content[:begin] + head + body)
    with pytest.raises(RecordingError, match="an object of type"):
        read_log(tmp_path / "b.blf")


def test_a_blf_that_ends_before_its_header_says_so_is_told(tmp_path):
    content = written(tmp_path / "a.blf", compression_level=0).read_bytes()
    (tmp_path / "b.blf").write_bytes(content[: len(content) * 3 // 4])
    found = read_log(tmp_path / "b.blf")
    assert 0.2 < found.report.share_lost < 0.3
    assert "of the" in found.report.warnings()[0]
    (tmp_path / "c.blf").write_bytes(content[:100])
    with pytest.raises(RecordingError, match="it ends within its own header"):
        read_log(tmp_path / "c.blf")


def test_mdf_without_its_reader_names_the_extra(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "asammdf.blocks.mdf_v4", None)
    (tmp_path / "a.mf4").write_bytes(b"MDF     4.10    TGT 15.0" + bytes(1000))
    assert main(["import", str(tmp_path / "a.mf4"), "-o", str(tmp_path / "r")]) == 2
    assert re.fullmatch(r"vegrip: .*pip install 'vegrip\[mdf\]'.*\n", capsys.readouterr().err)


@pytest.mark.filterwarnings("ignore")  # of asammdf
@pytest.mark.parametrize("part", [1.0, 0.9, 0.5, 0.1])
def test_mdf_is_read_and_a_torn_one_is_refused_or_counted(part, tmp_path):
    pytest.importorskip("asammdf", reason="the extra mdf")
    content = written(tmp_path / "a.mf4", channels=(0, 1)).read_bytes()
    (tmp_path / "b.mf4").write_bytes(content[: int(part * len(content))])
    if part == 1.0:
        with pytest.raises(RecordingError, match="comes on can0 and on can1"):
            read_log(tmp_path / "b.mf4")
        same(read_log(tmp_path / "b.mf4", channel="can1"), tolerance=5000)
        return
    with pytest.raises(RecordingError, match="is not a CAN log that can be read"):
        read_log(tmp_path / "b.mf4")


STARTED = """
import sys
from pathlib import Path
from vegrip import cli
sys.meta_path.insert(0, cli._LeanCan)
import vegrip.nodes.grasp_force
print("can" in sys.modules, "pandas" in sys.modules)
from vegrip.identification.recording.can_frames import read_log
print(len(read_log(Path(sys.argv[1])).frames))
"""


def test_a_program_starts_without_the_reader_of_mdf_and_has_it_where_it_reads_one(tmp_path):
    pytest.importorskip("asammdf", reason="the extra mdf")
    command = [sys.executable, "-c", STARTED, str(written(tmp_path / "a.mf4"))]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert told.split() == ["True", "False", str(len(FRAMES))]


@pytest.mark.parametrize("suffix", [".log", ".blf", ".asc"])
def test_two_hands_on_two_channels_are_never_mixed(suffix, tmp_path):
    path = tmp_path / f"a{suffix}"
    if suffix == ".log":
        pairs = zip(candump().splitlines(), candump(channel="can1", begin=0.003).splitlines(), strict=True)
        path.write_text("".join(f"{one}\n{other}\n" for one, other in pairs))
    else:
        written(path, channels=(0, 1))
    with pytest.raises(
        RecordingError, match=r"0x101 comes on can0 and on can1; say which is meant with --channel can0$"
    ):
        read_log(path)
    for channel in ("can0", "can1"):
        same(read_log(path, channel=channel), tolerance=5000)
    with pytest.raises(RecordingError, match="has no channel 'can7'; it has can0, can1"):
        read_log(path, channel="can7")
    assert len(read_log(path, wanted={0x200}).frames) == 2 * COUNT


def test_one_channel_is_taken_whatever_its_name(tmp_path):
    (tmp_path / "a.log").write_text(candump(channel="vcan3"))
    same(read_log(tmp_path / "a.log", channel="can0"))


def test_the_command_picks_a_channel(tmp_path, capsys):
    written(tmp_path / "a.blf", channels=(0, 1))
    command = ["import", str(tmp_path / "a.blf"), "-o", str(tmp_path / "r"), "--fingers", "thumb"]
    assert main(command) == 3
    assert "--channel can0" in capsys.readouterr().err
    assert main([*command, "--channel", "can0"]) == 3
    assert "none of its 200 frames" in capsys.readouterr().err
