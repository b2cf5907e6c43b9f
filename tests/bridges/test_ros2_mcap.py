"""MCAP of ROS 2 types is read by readers that did not write it, whole or cut off."""

import contextlib
import json
import math
import signal
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from vegrip import Fingertip, Recording, messages, read_recording, write_recording
from vegrip.bridges.ros2_types import TYPES
from vegrip.cli import main

rosbags = pytest.importorskip("rosbags.highlevel")
mcap_ros2 = pytest.importorskip("mcap_ros2.decoder")
SLIP_ROWS = slice(40, 60)


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    t = np.arange(100) / 100.0
    slip = np.zeros(100)
    slip[SLIP_ROWS] = 1.0
    columns = {"normal_force": 1.0 + t, "tangential_force_x": 0.1 * t, "torque_z": -1e-3 * t, "slip": slip}
    tip = Fingertip(8e-3, name="thumb")
    made = Recording("pull", t, np.zeros(100, np.int64), columns, tip, source={"date": "2026-03-01"})
    write_recording(made, tmp_path / "pull")
    return tmp_path / "pull"


@pytest.fixture
def file(recorded: Path, tmp_path: Path) -> Path:
    assert main(["export", "mcap", str(recorded), "-o", str(tmp_path / "pull.mcap")]) == 0
    return tmp_path / "pull.mcap"


def read(path: Path) -> dict[str, list]:
    from rosbags.highlevel import AnyReader

    found: dict[str, list] = {}
    with AnyReader([path]) as reader:
        for connection, _, data in reader.messages():
            found.setdefault(connection.topic, []).append(reader.deserialize(data, connection.msgtype))
    return found


def test_rosbags_reads_wrenches_slips_and_our_types(file: Path) -> None:
    found = read(file)
    assert [m.wrench.force.z for m in found["/hand/thumb/wrench"]] == [1.0 + n / 100.0 for n in range(100)]
    assert {m.header.frame_id for m in found["/hand/thumb/wrench"]} == {"thumb"}
    assert [m.message for m in found["/vegrip/events"]] == ["slip", "over: slip"]
    assert sum(m.slip for m in found["/hand/thumb/state"]) == 20.0
    times = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in found["/hand/thumb/wrench"]]
    begin = found["/vegrip/events"][0].timestamp
    assert begin.sec + 1e-9 * begin.nanosec == pytest.approx(times[SLIP_ROWS.start])


def test_the_decoder_of_mcap_reads_the_same_and_the_metadata(file: Path) -> None:
    from mcap.reader import make_reader

    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[mcap_ros2.DecoderFactory()])
        (about,) = list(reader.iter_metadata())
        decoded = [m for _, _, _, m in reader.iter_decoded_messages(topics=["/hand/thumb/wrench"])]
    assert [m.wrench.force.z for m in decoded] == [1.0 + n / 100.0 for n in range(100)]
    said = about.metadata
    assert (said["hand"], said["pad.thumb"], said["date"]) == ("pull", "radius 0.008 m", "2026-03-01")


@pytest.mark.parametrize(
    ("found", "level", "said"),
    [
        (
            {"verdict": "named", "named": ["adhesion", "rolling"]},
            3,
            "named: the model lacks adhesion, rolling",
        ),
        (
            {"verdict": "ambiguous", "indistinguishable": [["inertia", "sensor_lag"]]},
            3,
            "one of inertia, sensor_lag",
        ),
        ({"verdict": "unexplained"}, 3, "what no effect of the catalogue explains"),
        ({"verdict": "adequate"}, 2, "adequate: the model lacks nothing that shows"),
    ],
)
def test_the_verdict_of_a_diagnosis_is_an_event_and_metadata(recorded, tmp_path, found, level, said) -> None:
    from mcap.reader import make_reader

    whole = {"recording": "pull", "named": [], "indistinguishable": []} | found
    (tmp_path / "found").mkdir()
    (tmp_path / "found/diagnosis.json").write_text(json.dumps(whole))
    path = tmp_path / "told.mcap"
    words = ["export", "mcap", str(recorded), "-o", str(path), "--verdict", str(tmp_path / "found")]
    assert main(words) == 0
    event = read(path)["/vegrip/events"][-1]
    assert (event.level, event.name) == (level, "pull")
    assert said in event.message
    with path.open("rb") as stream:
        (about,) = list(make_reader(stream).iter_metadata())
    assert about.metadata["verdict.pull"] == event.message


@pytest.mark.parametrize(
    "text", ["{", "[]", '{"verdict": "sure", "named": [], "indistinguishable": []}', "{}"]
)
def test_what_is_no_verdict_is_refused_before_anything_is_written(
    recorded, tmp_path, capsys, text: str
) -> None:
    (tmp_path / "x.json").write_text(text)
    path = tmp_path / "told.mcap"
    words = ["export", "mcap", str(recorded), "-o", str(path), "--verdict", str(tmp_path / "x.json")]
    assert main(words) == 3
    assert "is no diagnosis.json of `vegrip diagnose`" in capsys.readouterr().err
    assert not path.exists()


def test_rows_of_a_damaged_recording_are_counted_in_the_file(recorded, tmp_path, capsys) -> None:
    lines = (recorded / "recording.csv").read_text().splitlines()
    lines[10] = lines[20] = "nothing"
    (recorded / "recording.csv").write_text("\n".join(lines) + "\n")
    assert main(["export", "mcap", str(recorded), "-o", str(tmp_path / "x.mcap"), "--json"]) == 0
    out = capsys.readouterr()
    assert json.loads(out.out)["rows"]["used"] == 98
    assert "2 of 100 rows are left out" in out.err


def test_it_comes_back_as_a_recording_by_a_map_of_one_topic(
    file: Path, recorded: Path, tmp_path: Path
) -> None:
    chart = "normal_force=/hand/thumb/wrench:wrench.force.z"
    words = ["import", str(file), "-o", str(tmp_path / "back"), "--map", chart, "--unit", "normal_force=N"]
    assert main(words) == 0
    back = read_recording(tmp_path / "back")
    assert np.array_equal(back.columns["normal_force"], read_recording(recorded).columns["normal_force"])


def test_a_bag_of_two_frames_on_one_topic_is_asked_about(tmp_path: Path, capsys) -> None:
    from vegrip.bridges import ros2_types as ros2
    from vegrip.bridges.ros2_mcap import Ros2Mcap

    with (tmp_path / "two.mcap").open("wb") as stream, Ros2Mcap(stream, {}) as mcap:
        for n in range(40):
            data = ros2.wrench_of({"normal_force": "1"}, n * 10**7, ("thumb", "palm")[n % 2])
            mcap._put("/wrench", ros2.WRENCH, data, n * 10**7)
    chart = "normal_force=/wrench:wrench.force.z"
    words = ["import", str(tmp_path / "two.mcap"), "-o", str(tmp_path / "out"), "--map", chart]
    assert main([*words, "--unit", "normal_force=N"]) == 3
    assert "frame" in capsys.readouterr().err


WRITER = """
import os, signal, sys
from pathlib import Path
from vegrip.bridges.ros2_mcap import Ros2Mcap
from vegrip.messages import FingertipState
with open(sys.argv[1], "xb") as file:
    mcap = Ros2Mcap(file, {"hand": "killed"})
    for n in range(2000):
        row = {"t": str(n / 200), "normal_force": "1.0"}
        mcap.add("/hand/thumb/state", FingertipState, row, n * 5_000_000)
        mcap._flush_due = 0.0
        mcap.flush()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_file_whose_writer_was_killed_is_read_to_the_last_second(tmp_path: Path) -> None:
    from mcap.exceptions import EndOfFile, McapError
    from mcap.records import Message
    from mcap.stream_reader import StreamReader

    path = tmp_path / "killed.mcap"
    ended = subprocess.run([sys.executable, "-c", WRITER, str(path)], check=False, timeout=120)
    assert ended.returncode == -signal.SIGKILL
    stamps = []
    with path.open("rb") as stream, contextlib.suppress(EndOfFile, McapError):
        for record in StreamReader(stream).records:
            if isinstance(record, Message):
                stamps.append(record.log_time)  # noqa: PERF401 (what came before the end counts)
    assert 1999 / 200 - max(stamps) * 1e-9 < 1.0
    assert len(set(stamps)) > 1800


def test_a_layout_for_plotjuggler_names_fields_that_are_written(tmp_path: Path, runtime) -> None:
    assert main(["bridge", "foxglove", "--layout", str(tmp_path / "hand.xml")]) == 0
    curves = [one.get("name", "") for one in ET.parse(tmp_path / "hand.xml").iter("curve")]  # noqa: S314 (ours)
    kinds = {"slip_margin": "SlipMargin", "state": "FingertipState", "contact": "ContactEstimate"}
    kinds |= {"force_command": "ForceCommand", "model_health": "ModelHealth"}
    assert "/hand/thumb/slip_margin/lower_bound" in curves
    for curve in curves:
        _, _, _, topic, column = curve.split("/")
        assert column in TYPES[getattr(messages, kinds[topic])]


def test_what_is_no_recording_is_refused(tmp_path: Path, capsys) -> None:
    assert main(["export", "mcap", str(tmp_path / "none"), "-o", str(tmp_path / "x.mcap")]) == 3
    assert not (tmp_path / "x.mcap").exists()
    assert math.inf > len(capsys.readouterr().err.splitlines()) == 1


def test_running_hands_are_written_as_they_speak_with_hand_and_pad(tmp_path: Path) -> None:
    """The hand is heard from the second look on; a file that is cut off has its metadata all the same."""
    from mcap.exceptions import EndOfFile, McapError
    from mcap.records import Metadata
    from mcap.stream_reader import StreamReader

    from vegrip.bridges.ros2_mcap import about, record_ros2_mcap

    class Source:
        looks = 0

        def look(self):
            self.looks += 1
            return {"/hand/thumb/state": messages.FingertipState} if self.looks > 1 else {}

        def read(self, topics):
            assert set(topics) == {"/hand/thumb/state"}
            return [("/hand/thumb/state", messages.FingertipState(10, "thumb", 1, normal_force=2.0))]

    source = Source()

    def hands() -> dict[str, str]:
        pads = {"thumb": "radius 0.009 m"} if source.looks > 1 else {}
        return about("/left" if pads else "", pads, "2026-03-01T00:00:00+00:00")

    writing = record_ros2_mcap(tmp_path / "live.mcap", source, math.inf, hands)
    counts = [next(writing) for _ in range(5)]
    there = (tmp_path / "live.mcap").read_bytes()
    writing.close()
    assert counts == [2, 4, 6, 8, 10]  # a state and its wrench
    assert [m.wrench.force.z for m in read(tmp_path / "live.mcap")["/hand/thumb/wrench"]] == [2.0] * 5
    (tmp_path / "cut.mcap").write_bytes(there)
    said = []
    with (tmp_path / "cut.mcap").open("rb") as stream, contextlib.suppress(EndOfFile, McapError):
        for record in StreamReader(stream).records:
            if isinstance(record, Metadata):
                said.append(record.metadata)  # noqa: PERF401 (what came before the end counts)
    assert (said[-1]["hand"], said[-1]["pad.thumb"]) == ("/left", "radius 0.009 m")
    assert said[-1]["date"].startswith("2026")


def test_the_hands_that_run_are_known_by_their_parameters(monkeypatch) -> None:
    from vegrip.bridges import node_topics, ros2_mcap
    from vegrip.runtime.registry import Entry

    rows = {"/right/grasp_force": {"tip.radius": 9e-3, "tip.model": "pad.toml"}, "/record": {"radius": 0.0}}
    entries = [Entry(name, "x", fingers=["thumb", "index"]) for name in rows]
    monkeypatch.setattr(node_topics, "running_nodes", lambda: entries)
    asked = lambda entry, *_: [{"name": n, "value": v} for n, v in rows[entry.name].items()]  # noqa: E731
    monkeypatch.setattr(node_topics, "ask", asked)
    said = ros2_mcap.running_hands()
    assert said["hand"] == "/right/grasp_force"
    assert said["pad.index"] == "radius 0.009 m, model pad.toml"


def test_diagnostics_are_of_the_type_that_ros_expects_there(tmp_path: Path) -> None:
    from tests.bridges.messages_of_a_hand import SENT
    from vegrip.bridges.ros2_mcap import Ros2Mcap
    from vegrip.bridges.ros2_types import row_of

    path = tmp_path / "all.mcap"
    with path.open("wb") as stream, Ros2Mcap(stream, {}) as mcap:
        for message in SENT:
            name = type(message).__name__
            topic = "/diagnostics" if name == "NodeStatus" else f"/hand/thumb/{name}"
            mcap.add(topic, type(message), row_of(message, 0), 10**9)
    found = read(path)["/diagnostics"]
    said = {array.status[0].name: array.status[0].message for array in found}
    assert said == {"vegrip/thumb": "stale", "/grip": "active"}
