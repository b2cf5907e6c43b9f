"""What is recorded can be read back; neither a crash nor a full disk costs more than the last second."""

import dataclasses
import errno
import math
import shutil
import threading
import tomllib
from pathlib import Path

import numpy as np
import pytest

from vegrip.errors import RecordingError
from vegrip.identification.recording import Kind, read_recording
from vegrip.identification.recording.session import merge_states, read_fingers, read_output
from vegrip.identification.recording.table_file import TableFile
from vegrip.identification.recording.writer import BackgroundWriter, RecordingWriter
from vegrip.messages import (
    Channel,
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    Lifecycle,
    Message,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)

START = 1_700_000_000_123_456_789


def state(i: int, finger: str = "thumb") -> FingertipState:
    return FingertipState(START + 2_000_001 * i, finger, i, normal_force=0.1 * i, displacement=1e-4 / 3 * i)


def test_states_come_back_bit_for_bit_with_their_stamps(tmp_path: Path) -> None:
    sent = [state(i, finger) for i in range(50) for finger in ("thumb", "index")]
    with RecordingWriter(tmp_path / "s", radius=0.008, sensors={"normal_force": 0.01}) as writer:
        for message in sent:
            writer.write(message)
    fingers = read_fingers(tmp_path / "s")
    assert list(fingers) == ["index", "thumb"]
    thumb = fingers["thumb"]
    assert list(thumb.columns) == ["displacement", "normal_force"]  # only what was ever measured
    assert (thumb.fingertip.radius, thumb.sensors, thumb.start) == (0.008, {"normal_force": 0.01}, START)
    assert not thumb.report.findings
    back = list(merge_states(fingers, START))
    key = lambda s: (s.stamp, s.finger, s.seq, s.normal_force, s.displacement)  # noqa: E731
    assert sorted(map(key, back)) == sorted(map(key, sent))
    assert [s.stamp for s in back] == sorted(s.stamp for s in back)
    session = tomllib.loads((tmp_path / "s" / "session.toml").read_text())
    assert (session["closed"], session["rows"], session["lost"]) == (True, 100, 0)


def test_outputs_come_back_by_column(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "s") as writer:
        writer.write(state(0))
        writer.write(
            ContactEstimate(
                START + 5,
                "thumb",
                3,
                in_contact=True,
                channels=Channel.FORCE | Channel.TORQUE,
                normal_force=Estimate(1.25, 0.5, valid=True, age=0.0),
            )
        )
        writer.write(SlipMargin(START, "thumb", 1, lower_bound=0.25, time_to_slip=math.inf))
        writer.write(ForceCommand(START, "thumb", 1, 2.0, 0.5, Reason.RAISE, START + 100))
        writer.write(ModelHealth(START, "thumb", 1, Condition.STALE, nis=1.5, channel="force, normal"))
        writer.write(NodeStatus(START, "/left/grasp", 1, Lifecycle.ACTIVE, rejected={"crc": 3, "stale": 1}))
    thumb = tmp_path / "s" / "thumb"
    contact = read_output(thumb / "contact.csv")
    assert contact["t"].tolist() == [5e-9]
    assert [contact[f"normal_force{k}"][0] for k in ("", "_std", "_valid", "_age")] == [1.25, 0.5, 1.0, 0.0]
    assert (contact["channels"][0], contact["in_contact"][0]) == (17, 1)
    assert np.isnan(contact["indentation"][0])
    assert np.isinf(contact["indentation_std"][0])
    assert np.isinf(read_output(thumb / "slip_margin.csv")["time_to_slip"][0])
    command = read_output(thumb / "force_command.csv")
    assert (command["reason"][0], command["expires"][0]) == ("raise", START + 100)
    health = read_output(thumb / "model_health.csv")
    assert (health["condition"][0], health["channel"][0]) == ("stale", "force  normal")
    status = read_output(tmp_path / "s" / "diagnostics.csv")
    assert (status["node"][0], status["state"][0], status["rejected"][0]) == (
        "/left/grasp",
        "active",
        "crc=3;stale=1",
    )


def test_a_crash_costs_only_what_was_not_flushed(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "s")
    for i in range(10):
        writer.write(state(i))
    writer.flush()
    writer.write(state(10))  # never flushed
    table = tmp_path / "s" / "thumb" / "recording.csv"
    table.write_bytes(table.read_bytes()[:-4])  # and the last block did not reach the disk whole
    recording = read_recording(tmp_path / "s" / "thumb")
    assert len(recording) == 9
    assert recording.report.count(Kind.CUT) == 1
    writer.close()


def test_a_finger_named_by_the_wire_stays_in_the_folder(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "s") as writer:
        writer.write(FingertipState(0, "../../thumb", 0, normal_force=1.0))
    assert list((tmp_path / "s").glob("*/recording.csv")) == [
        tmp_path / "s" / "______thumb" / "recording.csv"
    ]


def test_a_session_is_never_overwritten(tmp_path: Path) -> None:
    RecordingWriter(tmp_path / "s").close()
    with pytest.raises(RecordingError, match="holds a recording already"):
        RecordingWriter(tmp_path / "s")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        RecordingWriter(tmp_path / "file" / "s")


class Disk:
    """A file on a disk with room for some bytes only."""

    def __init__(self, room: int) -> None:
        self.content = b""
        self.room = room

    def write(self, data: bytes) -> int:
        if not self.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        written = data[: self.room]
        self.content += written
        self.room -= len(written)
        return len(written)

    def close(self) -> None:
        pass


def test_rows_that_a_full_disk_refuses_are_written_when_it_takes_them_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = Disk(room=16)
    monkeypatch.setattr(TableFile, "_open", lambda _: disk)
    table = TableFile(tmp_path / "x.csv", "t,a")
    for t in range(4):  # the disk is full within the second row
        table.add(f"{t},1000")
        assert table.flush() == 0
    disk.room = 1000
    table.add("4,1000")
    assert table.flush() == 0
    torn, rows = disk.content.split(b"\n")[2], disk.content.split(b"\n")
    assert torn == b"1,100", "the torn line is sealed and its row written again"
    assert rows == [b"t,a", b"0,1000", b"1,100", b"1,1000", b"2,1000", b"3,1000", b"4,1000", b""]


def test_a_disk_that_stays_full_costs_the_oldest_rows_and_they_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = Disk(room=0)
    monkeypatch.setattr(TableFile, "_open", lambda _: disk)
    monkeypatch.setattr("vegrip.identification.recording.table_file.BUFFERED_ROWS", 3)
    table = TableFile(tmp_path / "x.csv", "t")
    lost = 0
    for t in range(10):
        table.add(str(t))
        lost += table.flush()
    assert lost == 7
    disk.room = 1000
    table.flush()
    assert disk.content == b"t\n7\n8\n9\n"
    assert table.give_up() == 0


def test_a_recorder_on_a_full_disk_goes_on_counts_and_tells_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(TableFile, "_open", lambda _: Disk(room=0))
    writer = RecordingWriter(tmp_path / "s")
    for i in range(3):
        writer.write(state(i))
        writer.flush()
    writer.close()
    assert writer.lost["thumb/recording.csv"] == 3
    assert "3 rows are lost at the end (No space left on device)" in caplog.text
    assert "3 of 3 rows are lost (No space left on device)" in writer.problem
    assert tomllib.loads((tmp_path / "s" / "session.toml").read_text())["lost"] == 3


def test_the_queue_drops_the_oldest_and_counts(tmp_path: Path) -> None:
    recorder = BackgroundWriter(RecordingWriter(tmp_path / "s"), capacity=10, period=60.0)
    for i in range(25):
        recorder.offer(state(i))
    assert recorder.dropped == 15
    recorder.close()
    assert recorder.dropped == 15
    assert "15 messages came faster" in recorder.writer.problem
    np.testing.assert_allclose(
        read_recording(tmp_path / "s" / "thumb").columns["normal_force"], 0.1 * np.arange(15, 25)
    )


def test_a_disk_that_stands_still_does_not_hold_up_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writing, go_on = threading.Event(), threading.Event()

    def stuck(_: RecordingWriter, __: Message) -> None:
        writing.set()
        go_on.wait(10.0)

    monkeypatch.setattr(RecordingWriter, "write", stuck)
    recorder = BackgroundWriter(RecordingWriter(tmp_path / "s"), capacity=10, period=0.001)
    recorder.offer(state(0))
    assert writing.wait(10.0)
    for i in range(12):  # returns although the first message is still being written
        recorder.offer(state(i))
    assert recorder.dropped == 2  # of 12 in a queue of 10
    go_on.set()
    recorder.close()


def test_a_folder_that_is_deleted_while_recording_is_told_counted_and_recorded_anew(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    writer = RecordingWriter(tmp_path / "s", radius=0.008)
    for i in range(10):
        writer.write(state(i))
    writer.flush()
    shutil.rmtree(tmp_path / "s")
    for i in range(10, 14):
        writer.write(state(i))
    writer.flush()
    assert "deleted while being written, 10 rows are lost" in caplog.text
    writer.close()
    assert writer.problem.endswith("10 of 14 rows are lost (deleted)")
    session = tomllib.loads((tmp_path / "s" / "session.toml").read_text())
    assert (session["closed"], session["rows"], session["lost"]) == (True, 14, 10)
    kept = read_recording(tmp_path / "s" / "thumb")
    np.testing.assert_allclose(kept.columns["normal_force"], 0.1 * np.arange(10, 14))
    assert kept.fingertip.radius == 0.008


def test_a_folder_deleted_after_the_last_row_is_told_too(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "s")
    writer.write(state(0))
    writer.flush()
    shutil.rmtree(tmp_path / "s")
    writer.close()
    assert "1 of 1 rows are lost" in writer.problem
    assert tomllib.loads((tmp_path / "s" / "session.toml").read_text())["lost"] == 1


def test_a_table_cut_short_by_another_program_costs_the_rows_that_are_gone(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "s")
    for i in range(10):
        writer.write(state(i))
    writer.flush()
    table = tmp_path / "s" / "thumb" / "recording.csv"
    whole = table.read_bytes().splitlines(keepends=True)
    table.write_bytes(b"".join(whole[:4]) + whole[4][:3])  # the same file; header, three rows, a part of one
    writer.write(state(10))
    writer.close()
    assert writer.lost["thumb/recording.csv"] == 7
    recording = read_recording(tmp_path / "s" / "thumb")
    np.testing.assert_allclose(recording.columns["normal_force"], [0.0, 0.1, 0.2, 1.0])


def test_a_folder_that_is_moved_away_keeps_its_rows_and_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    writer = RecordingWriter(tmp_path / "s")
    for i in range(5):
        writer.write(state(i))
    writer.flush()
    (tmp_path / "s").rename(tmp_path / "elsewhere")
    writer.write(state(5))
    writer.close()
    assert "moved away" in caplog.text
    assert "5 of 6 rows are where the folder was moved to" in writer.problem
    assert len(read_recording(tmp_path / "elsewhere" / "thumb")) == 5
    assert len(read_recording(tmp_path / "s" / "thumb")) == 1


def test_a_table_of_another_program_is_not_written_into(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "s")
    writer.write(state(0))
    writer.flush()
    table = tmp_path / "s" / "thumb" / "recording.csv"
    table.unlink()
    table.write_text("not ours\n")
    writer.write(state(1))
    writer.close()
    assert table.read_text() == "not ours\n"
    assert writer.lost["thumb/recording.csv"] == 2


def test_a_full_disk_is_told_when_it_begins_and_when_it_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    disk = Disk(room=0)
    monkeypatch.setattr(TableFile, "_open", lambda _: disk)
    writer = RecordingWriter(tmp_path / "s")
    writer.write(state(0))
    writer.flush()
    assert "cannot be written (No space left on device); rows wait in memory" in caplog.text
    caplog.clear()
    disk.room = 10_000
    writer.close()
    assert "can be written again" in caplog.text
    assert writer.problem == ""


def test_made_up_fingers_do_not_use_up_the_descriptors(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vegrip.identification.recording.writer.MOST_TABLES", 2)
    with RecordingWriter(tmp_path / "s") as writer:
        for i, finger in enumerate(("thumb", "index", "a", "b", "thumb")):
            writer.write(state(i, finger))
    assert len(list((tmp_path / "s").glob("*/recording.csv"))) == 2
    assert "2 of 5 rows are lost" in writer.problem


def missing_in(folder: Path, finger: str) -> int | None:
    about = tomllib.loads((folder / finger / "recording.toml").read_text())
    return about["source"].get("missing_states")


def test_states_that_never_came_are_told_at_the_end_in_the_notes_and_to_who_reads_it(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with RecordingWriter(tmp_path / "s") as writer:
        for i in range(1000):
            writer.write(state(i, "index"))
            if not 100 <= i < 103 and not 400 <= i < 800:  # 0.8 s: longer than a pause of the sender
                writer.write(state(i))
        writer.flush()
        assert missing_in(tmp_path / "s", "thumb") == 403  # also should it be killed from here on
    assert "403 states were sent and are not in it" in caplog.text
    assert (missing_in(tmp_path / "s", "thumb"), missing_in(tmp_path / "s", "index")) == (403, None)
    assert tomllib.loads((tmp_path / "s" / "session.toml").read_text())["missing_states"] == 403
    again = read_recording(tmp_path / "s" / "thumb")
    assert "403 states were sent" in again.report.summary()


def test_a_sender_that_starts_again_and_states_that_were_overtaken_are_no_loss(tmp_path: Path) -> None:
    order = [*range(10), 11, 10, *range(12, 20)]
    with RecordingWriter(tmp_path / "s") as writer:
        for i in order:
            writer.write(state(i))
        for i in range(5):
            writer.write(dataclasses.replace(state(1000 + i), seq=20_000 + i))
    assert missing_in(tmp_path / "s", "thumb") is None
