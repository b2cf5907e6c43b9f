"""Bags of ROS 1 and ROS 2 become recordings; whatever does not fit is said with its topic and message."""

import contextlib
import json
import sqlite3
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.cli import main
from vegrip.errors import RecordingError, UsageError
from vegrip.identification.recording import Kind, Recording, read_recording
from vegrip.identification.recording.column_map import ColumnMap, read_column_map
from vegrip.identification.recording.rosbag import BagField, hold, import_rosbag

typesys = pytest.importorskip("rosbags.typesys", reason="the extra `bags` is not installed")
rosbag1 = pytest.importorskip("rosbags.rosbag1", reason="the extra `bags` is not installed")
rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="the extra `bags` is not installed")

STORE = {
    1: typesys.get_typestore(typesys.Stores.ROS1_NOETIC),
    2: typesys.get_typestore(typesys.Stores.ROS2_HUMBLE),
}
EPOCH = 1_700_000_000_000_000_000  # beyond 2**53: a float would lose 256 ns
MS = 1_000_000
Capsys = pytest.CaptureFixture[str]
WRENCH, ARRAY, SCALAR, TEXT = (
    "geometry_msgs/msg/WrenchStamped",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/Float64",
    "std_msgs/msg/String",
)


@dataclass
class Sent:
    """One message for a bag: when it was received, on which topic, what; ``raw`` bytes stand for damage."""

    received: int  # [ns] after EPOCH
    topic: str
    kind: str
    content: dict[str, Any] = field(default_factory=dict)
    raw: bytes | None = None


def built(version: int, sent: Sent) -> Any:
    types, c = STORE[version].types, sent.content
    if sent.kind == WRENCH:
        vector = types["geometry_msgs/msg/Vector3"]
        stamp = c.get("stamp", sent.received)
        stamp = 0 if stamp is None else EPOCH + stamp
        time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
        head = {"seq": 0} if version == 1 else {}
        header = types["std_msgs/msg/Header"](**head, stamp=time, frame_id=c.get("frame", "tip"))
        wrench = types["geometry_msgs/msg/Wrench"](
            vector(c.get("fx", 0.0), 0.0, c["fz"]), vector(0.0, 0.0, c.get("mz", 0.0))
        )
        return types[WRENCH](header, wrench)
    if sent.kind == ARRAY:
        layout = types["std_msgs/msg/MultiArrayLayout"]([], 0)
        return types[ARRAY](layout, np.array(c["data"], dtype=np.float64))
    return types[sent.kind](c["data"])


def write_bag(path: Path, form: str, messages: Sequence[Sent]) -> Path:
    """Write ``messages`` with the writer of rosbags; return what `vegrip import` is given."""
    version = 1 if form == "ros1" else 2
    store = STORE[version]
    if version == 1:
        path = path.with_suffix(".bag")
        writer: Any = rosbag1.Writer(path)
    else:
        plugin = rosbag2.StoragePlugin.MCAP if "mcap" in form else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    with writer:
        connections: dict[tuple[str, str], Any] = {}
        for sent in messages:
            key = (sent.topic, sent.kind)
            if key not in connections:
                connections[key] = writer.add_connection(*key, typestore=store)
            serialize = store.serialize_ros1 if version == 1 else store.serialize_cdr
            data = serialize(built(version, sent), sent.kind) if sent.raw is None else sent.raw
            writer.write(connections[key], EPOCH + sent.received, data)
    if form.endswith("file"):
        return next(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))
    return path


FORMS = ("ros1", "ros2-sqlite3", "ros2-mcap", "ros2-mcap-file", "ros2-sqlite3-file")
MAP = """
[bag]
time = "/finger/wrench"
largest_age = 0.0105
[channels.normal_force]
column = "/finger/wrench:wrench.force.z"
scale = -1
[channels.tangential_force_x]
column = "/finger/wrench:wrench.force.x"
unit = "mN"
[channels.displacement]
column = "/finger/joints:data[1]"
unit = "mm"
[fingertip]
radius = 0.008
"""


def chart(tmp_path: Path, text: str = MAP) -> ColumnMap:
    (tmp_path / "map.toml").write_text(text)
    return read_column_map(tmp_path / "map.toml")


def wrench(at: int, fz: float = -1.0, **more: Any) -> Sent:
    return Sent(at * MS, "/finger/wrench", WRENCH, {"fz": fz, **more})


def joints(at: int, *data: float) -> Sent:
    return Sent(at * MS, "/finger/joints", ARRAY, {"data": data})


PRESS = [
    wrench(0, -0.5, fx=250.0, stamp=-2 * MS),  # stamped 2 ms before it was received
    joints(5, 9.0, 0.1),
    wrench(10, -1.0, stamp=8 * MS),
    wrench(20, -1.5, stamp=18 * MS),
    wrench(22, -1.6, stamp=15 * MS + 1),
    joints(30, 9.0, 0.3),
    wrench(32, -2.0, stamp=30 * MS),
]
"""Recorded with one message that comes out of order (15 ms after 18 ms)."""


@pytest.mark.parametrize("form", FORMS)
def test_every_kind_of_bag_gives_the_same_recording(form: str, tmp_path: Path) -> None:
    recording = import_rosbag(write_bag(tmp_path / "bag", form, PRESS), chart(tmp_path))
    kept = np.array([-2, 8, 18, 30]) * MS
    np.testing.assert_array_equal(recording.stamps, kept - kept[0])
    assert recording.start == EPOCH - 2 * MS
    np.testing.assert_array_equal(recording.columns["normal_force"], [0.5, 1.0, 1.5, 2.0])
    np.testing.assert_allclose(recording.columns["tangential_force_x"], [0.25, 0.0, 0.0, 0.0])
    # joints at 5 and 30 ms: none before -2, 3 ms old at 8, 13 ms old at 18 (too old), of that instant at 30
    np.testing.assert_allclose(recording.columns["displacement"], [np.nan, 1e-4, np.nan, 3e-4])
    assert recording.fingertip.radius == 0.008
    report = recording.report
    assert (report.rows_read, report.rows_kept) == (5, 4)
    told = report.summary()
    assert "time runs backwards: /finger/wrench (1 x, message 3)" in told
    assert "/finger/joints has no header: its time is that of reception" in told
    assert "/finger/joints: known in 2 of 4 rows, at most 0.003 s old" in told
    assert "value missing (NaN): displacement (2 x, messages 0, 2)" in told


def test_the_map_of_the_examples_reads_a_bag_of_three_topics(tmp_path: Path) -> None:
    sent = []
    for i in range(1, 401):
        sent.append(Sent(5 * i * MS, "/finger/joints", ARRAY, {"data": [0.01 * i]}))
        sent.append(Sent(5 * i * MS + 800_000, "/finger/wrench", WRENCH, {"fz": -0.02 * i}))
        if i % 200 == 100:
            sent.append(Sent(5 * i * MS, "/finger/temperature", SCALAR, {"data": 24.5}))
    example = Path(__file__).parents[3] / "examples" / "maps" / "rosbag_finger.toml"
    finger = import_rosbag(write_bag(tmp_path / "bag", "ros2-mcap", sent), read_column_map(example))
    assert len(finger.t) == 400
    assert finger.columns["normal_force"][-1] == 8.0
    assert finger.columns["displacement"][-1] == pytest.approx(4e-3)
    assert np.isnan(finger.columns["temperature"]).sum() == 99


def test_a_held_topic_whose_time_runs_backwards_is_put_in_order_and_reported(tmp_path: Path) -> None:
    text = MAP.replace('time = "/finger/wrench"', 'time = "/finger/joints"')
    bag = [*PRESS, joints(38, 9.0, 0.4)]
    recording = import_rosbag(write_bag(tmp_path / "bag", "ros2-mcap", bag), chart(tmp_path, text))
    np.testing.assert_array_equal(recording.stamps, np.array([0, 25, 33]) * MS)  # joints at 5, 30, 38 ms
    np.testing.assert_array_equal(recording.columns["normal_force"], [0.5, 2.0, 2.0])
    assert (recording.report.rows_read, recording.report.rows_lost) == (3, 0)
    assert "time runs backwards: /finger/wrench (1 x, message 3)" in recording.report.summary()


def test_the_zero_of_a_held_channel_is_its_first_value_that_is_known(tmp_path: Path) -> None:
    text = MAP.replace('unit = "mm"', 'unit = "mm"\nzero = "first"')
    recording = import_rosbag(write_bag(tmp_path / "bag", "ros1", PRESS), chart(tmp_path, text))
    np.testing.assert_allclose(recording.columns["displacement"], [np.nan, 0.0, np.nan, 2e-4], atol=1e-18)


def test_the_time_of_reception_can_be_asked_for(tmp_path: Path) -> None:
    text = MAP.replace("[bag]", '[bag]\nstamp = "receive"')
    recording = import_rosbag(write_bag(tmp_path / "bag", "ros1", PRESS), chart(tmp_path, text))
    np.testing.assert_array_equal(recording.stamps, np.array([0, 10, 20, 22, 32]) * MS)
    assert recording.start == EPOCH
    assert "no header" not in recording.report.summary()


def test_nanoseconds_since_1970_are_kept_to_the_last(tmp_path: Path) -> None:
    bag = [wrench(1, stamp=at) for at in (1, 2, 4, 1_000_000_007)]
    text = MAP.partition("[channels.displacement]")[0]
    recording = import_rosbag(write_bag(tmp_path / "bag", "ros2-mcap", bag), chart(tmp_path, text))
    assert (recording.stamps + recording.start - EPOCH).tolist() == [1, 2, 4, 1_000_000_007]


@given(st.data())
def test_a_held_value_is_the_last_one_and_never_older_than_allowed(data: st.DataObject) -> None:
    stamps = sorted(data.draw(st.sets(st.integers(0, 60), min_size=1, max_size=12)))
    at, largest = data.draw(st.lists(st.integers(-5, 80), max_size=20)), data.draw(st.integers(0, 30))
    values = 10.0 * np.arange(len(stamps))
    held, age = hold(np.array(stamps), values, np.array(at, dtype=np.int64), largest)
    for i, now in enumerate(at):
        before = [
            k for k, stamp in enumerate(stamps) if stamp <= now
        ]  # the definition, by search from the front
        if before and now - stamps[before[-1]] <= largest:
            assert (held[i], age[i]) == (values[before[-1]], now - stamps[before[-1]])
        else:
            assert np.isnan(held[i])
            assert age[i] == -1


@pytest.mark.parametrize("form", ["ros1", "ros2-sqlite3", "ros2-mcap"])
@pytest.mark.parametrize(
    ("at", "sent", "kind", "index"),
    [
        (2, Sent(10 * MS, "/finger/wrench", WRENCH, raw=b"\0\1\0\0\7"), Kind.DECODE, 1),
        (5, Sent(30 * MS, "/finger/joints", ARRAY, raw=b"\0\1"), Kind.DECODE, 1),
        (5, joints(30, 9.0), Kind.FIELDS, 1),
        (2, wrench(10, float("inf")), Kind.INFINITE, 1),
        (2, wrench(10, stamp=None), Kind.NO_TIME, 1),
        (3, wrench(20, stamp=8 * MS), Kind.DUPLICATE, 2),
    ],
)  # fmt: skip
def test_a_message_that_cannot_be_used_is_left_out_and_named(
    form: str, at: int, sent: Sent, kind: Kind, index: int, tmp_path: Path
) -> None:
    messages = [*PRESS[:at], sent, *PRESS[at + 1 :]]
    recording = import_rosbag(write_bag(tmp_path / "bag", form, messages), chart(tmp_path))
    assert recording.report.count(kind) == 1
    assert f"{kind.text}: {sent.topic} (1 x, message {index})" in recording.report.summary()
    lost = 1 if sent.topic == "/finger/joints" else 2  # besides the one that comes out of order
    if kind is Kind.DUPLICATE:
        lost = 1  # without the row at 18 ms the one at 15 ms is in order
    assert recording.report.rows_lost == lost


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("joints:data[1]", "joint:data[1]", r"no topic /finger/joint; there are /finger/joints \["),
        ("wrench.force.x", "wrench.force.w", r"Stamped\]: message 0: has no field 'w'; there are x, y, z"),
        ("wrench.force.x", "wrench.force", "message 0: .* is a message with x, y, z, not a number"),
        ("wrench.force.x", "header.frame_id", "is the text 'tip', not a number"),
        ("wrench.force.x", "wrench.force[0]", r"has no element \[0\]; it is a message with x, y, z"),
        ("data[1]", "data", r"is an array of 2: say which with \[index\]"),
        ("data[1]", "data[1].x", "has no field 'x'; it is"),
        ("data[1]", "data[9]", "/finger/joints has no value within 0.0105 s"),
        ("/finger/joints:data[1]", "z", "'z' names no field; write it like /finger/wrench:"),
        ('time = "/finger/wrench"', 'time = "/wrench"', "must be one of /finger/wrench, /finger/joints"),
        ('time = "/finger/wrench"', "", "need \\[bag\\] time = one of them, and largest_age"),
        ("largest_age = 0.0105", "", "need \\[bag\\] time = one of them, and largest_age"),
        ("largest_age = 0.0105", 'largest_age = "10"', "'largest_age' is '10'; it must be a float in s"),
        ("largest_age = 0.0105", 'stamp = "now"', "'stamp' is 'now'; it must be one of header, receive"),
        ("[fingertip]", '[time]\ncolumn = "t"\nunit = "ms"\n[fingertip]', "a bag has no \\[time\\]"),
        ("[fingertip]", '[episode]\ncolumn = "n"\n[fingertip]', "a bag has no \\[episode\\]"),
        ('unit = "mm"', 'unit = "mN"', "'mN' is not a unit of this quantity"),
    ],
)  # fmt: skip
def test_a_map_that_does_not_fit_the_bag_is_refused(
    old: str, new: str, sentence: str, tmp_path: Path
) -> None:
    assert old in MAP
    with pytest.raises(RecordingError, match=sentence):
        import_rosbag(write_bag(tmp_path / "bag", "ros2-mcap", PRESS), chart(tmp_path, MAP.replace(old, new)))


def test_two_frames_on_one_topic_are_never_mixed(tmp_path: Path, capsys: Capsys) -> None:
    sent = [wrench(MS * k, -1.0 - k, frame=f"tip{k % 2}") for k in range(40)]
    bag = write_bag(tmp_path / "a.bag", "ros1", sent)
    command = [
        "import",
        str(bag),
        "-o",
        str(tmp_path / "r"),
        "--map",
        "normal_force=/finger/wrench:wrench.force.z",
    ]
    assert main(command) == 3
    told = "has messages of the frames 'tip0', 'tip1'; say which are meant: --frame tip1\n"
    assert capsys.readouterr().err.endswith(told)
    assert main([*command, "--frame", "tip1"]) == 0
    text = "[channels.normal_force]\ncolumn = '/finger/wrench:wrench.force.z'\n[bag]\nframe = 'tip1'\n"
    found = import_rosbag(bag, chart(tmp_path, text))
    np.testing.assert_array_equal(found.columns["normal_force"], [-2.0 - k for k in range(0, 40, 2)])
    assert found.report.rows_lost == 0
    with pytest.raises(RecordingError, match="has no frame 'palm'; it has tip0, tip1"):
        import_rosbag(bag, chart(tmp_path, text.replace("tip1", "palm")))


def test_a_topic_of_two_types_is_refused(tmp_path: Path) -> None:
    bag = write_bag(
        tmp_path / "bag", "ros1", [*PRESS, Sent(40 * MS, "/finger/joints", SCALAR, {"data": 1.0})]
    )
    with pytest.raises(RecordingError, match=r"/finger/joints has messages of std_msgs.*Float64 and std"):
        import_rosbag(bag, chart(tmp_path))


def test_a_bag_without_definitions_needs_the_release(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", "ros2-sqlite3", PRESS)
    with contextlib.closing(sqlite3.connect(next(bag.glob("*.db3")))) as connection:
        connection.execute("DELETE FROM message_definitions")
        connection.commit()
    with pytest.raises(
        RecordingError, match=r"does not define its messages; .* definitions = \"ros2_humble\""
    ):
        import_rosbag(bag, chart(tmp_path))
    text = MAP.replace("[bag]", '[bag]\ndefinitions = "ros2_humble"')
    assert len(import_rosbag(bag, chart(tmp_path, text))) == 4
    with pytest.raises(RecordingError, match="no release 'noetic'; there are ros1_noetic, ros2_dashing"):
        import_rosbag(bag, chart(tmp_path, text.replace("ros2_humble", "noetic")))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("share", [0.0, 0.1, 0.3, 0.6, 0.9])
def test_a_cut_bag_is_refused_or_reported_and_never_crashes(form: str, share: float, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", form, PRESS)
    data = bag if bag.is_file() else next(f for f in bag.iterdir() if f.suffix in (".mcap", ".db3"))
    whole = data.read_bytes()
    data.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(RecordingError, match="bag"):
        import_rosbag(bag, chart(tmp_path))


@pytest.mark.parametrize("form", FORMS)
def test_a_bag_with_a_turned_byte_never_crashes(form: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", form, PRESS)
    files = [bag] if bag.is_file() else sorted(bag.iterdir())
    whole, random = {file: file.read_bytes() for file in files}, np.random.default_rng(len(form))
    refused = 0
    for _ in range(25):
        file = files[int(random.integers(len(files)))]
        data = bytearray(whole[file])
        data[int(random.integers(len(data)))] ^= int(random.integers(1, 256))
        file.write_bytes(data)
        try:
            assert import_rosbag(bag, chart(tmp_path)).report.rows_read > 0
        except RecordingError:  # anything else is a crash
            refused += 1
        file.write_bytes(whole[file])
    assert 0 < refused < 25


def test_messages_that_the_bag_counts_and_does_not_hold_are_reported(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", "ros2-sqlite3", PRESS)
    with contextlib.closing(sqlite3.connect(next(bag.glob("*.db3")))) as connection:
        connection.execute("DELETE FROM messages WHERE timestamp = ?", [EPOCH + 20 * MS])
        connection.commit()
    told = import_rosbag(bag, chart(tmp_path)).report.summary()
    assert "/finger/wrench: 4 of the 5 messages that the bag counts are there" in told


@pytest.mark.parametrize(
    "column", ["", "/a", "/a:", ":x", "/a:x..y", "/a:x[", "/a:x[-1]", "/a b:x", "/a:x y"]
)
def test_what_names_no_field_is_refused(column: str) -> None:
    with pytest.raises(RecordingError, match="names no field"):
        BagField.parse(column, "slip")


def test_the_command_reads_a_bag_without_a_map_file(tmp_path: Path, capsys: Capsys) -> None:
    bag = write_bag(tmp_path / "bag", "ros2-mcap-file", PRESS)
    mapped = ["--map", "normal_force=/finger/wrench:wrench.force.z", "--unit", "normal_force=N"]
    assert main(["import", str(bag), "-o", str(tmp_path / "out"), *mapped, "--radius", "8 mm", "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)["recordings"]
    assert (told["rows"], told["report"]["rows_lost"], told["radius"]) == (4, 1, 0.008)
    recording: Recording = read_recording(tmp_path / "out")
    np.testing.assert_array_equal(recording.columns["normal_force"], [-0.5, -1.0, -1.5, -2.0])
    assert recording.start == EPOCH - 2 * MS


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["bag", "--map", "normal_force=/finger/wrench:wrench.force.w"], 3, "has no field 'w'"),
        (["bag", "--map", "normal_force=/none:x"], 3, "there is no topic /none"),
        (["bag"], 3, "say which field is what"),
        (["absent.bag", "--map", "slip=/a:x"], 3, "there is no such file"),
        (["empty", "--map", "slip=/a:x"], 3, "is an empty folder"),
        (["text.bag", "--map", "slip=/a:x"], 3, "is not a bag that can be read"),
        (["bag", "--map", "slip"], 2, "is not NAME=VALUE"),
    ],
)
def test_a_bag_that_cannot_be_imported_gets_one_sentence(
    arguments: list[str],
    code: int,
    sentence: str,
    tmp_path: Path,
    capsys: Capsys,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    write_bag(tmp_path / "bag", "ros2-sqlite3", PRESS)
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.bag").write_text("t,F\n")
    assert main(["import", *arguments, "-o", "out"]) == code
    shown = capsys.readouterr().err
    assert sentence in shown
    assert len(shown.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_missing_library_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(UsageError, match=r"needs the library rosbags .*pip install 'vegrip\[bags\]'"):
        import_rosbag(tmp_path, chart(tmp_path))
