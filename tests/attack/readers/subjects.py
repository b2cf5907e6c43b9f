"""What is attacked: every file that vegrip reads, each with a whole example and the reader of it.

A subject is made once in a folder of its own; an attack breaks one of its ``targets`` in a copy and reads
that copy with the output folder ``out`` beside it. A reader may refuse with a VegripError.
"""

import contextlib
import gzip
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can
import cantools
import numpy as np

from vegrip.canopen.network import read_eds
from vegrip.cli import main
from vegrip.errors import VegripError
from vegrip.estimator.learning import fingerprint
from vegrip.grip.learned_store import OnDisk
from vegrip.identification.recording import Fingertip, Recording, read_recording, write_recording
from vegrip.identification.recording.mcap import write_mcap
from vegrip.identification.recording.session import read_output
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.identification.simulate.protocol import read_protocol
from vegrip.messages import (
    ContactEstimate,
    FingertipState,
    ForceCommand,
    Lifecycle,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)
from vegrip.model import paper_model, read_model, write_model
from vegrip.runtime.launch_file import read_launch_file
from vegrip.runtime.node import NodeContext, find_program
from vegrip.transport.codec import CanCodec
from vegrip.transport.codec.database import build_layouts
from vegrip.transport.codec.schema import read_proto
from vegrip.transport.key_files import make_keys, read_keys

FINGERS = ("thumb", "index")
ROOT = Path(__file__).parents[3]


class RefusedError(Exception):
    """A command has refused its input with a sentence and an exit code."""


@dataclass(frozen=True)
class Subject:
    """One kind of file.

    Attributes:
        make: writes the example into an empty folder.
        targets: pattern of the files in it that are broken, one at a time.
        read: reads the folder and writes to the second folder only.
        zipped: the target is compressed; its content is broken as well as its bytes.

    """

    make: Callable[[Path], object]
    targets: str
    read: Callable[[Path, Path], object]
    zipped: bool = False


def command(*arguments: object) -> None:
    """Run ``vegrip`` in this process, as a user would."""
    code = main([str(argument) for argument in arguments])
    if code in (2, 3):
        raise RefusedError
    assert code == 0, f"exit code {code}"


def press(rows: int = 60) -> Recording:
    t = np.arange(rows) / 100.0
    columns = {"displacement": 1e-5 * t, "normal_force": np.sin(t) ** 2, "slip": (t > 0.3) * 1.0}
    source = {"file": "press.csv", "trial": 3}
    return Recording(
        "press", t, (t > 0.2).astype(int), columns, Fingertip(0.008, "index"), {"normal_force": 0.01}, source
    )


def session(folder: Path) -> None:
    with RecordingWriter(folder / "session", radius=0.008) as writer:
        for i in range(40):
            for finger in FINGERS:
                stamp = 10**9 + i * 5_000_000
                writer.write(FingertipState(stamp, finger, i, normal_force=0.1 * i, displacement=1e-5 * i))
                writer.write(ContactEstimate(stamp, finger, i, in_contact=True))
                writer.write(SlipMargin(stamp, finger, i, lower_bound=0.25))
                writer.write(ForceCommand(stamp, finger, i, 2.0, 0.5, Reason.RAISE, stamp + 100))
                writer.write(ModelHealth(stamp, finger, i, nis=1.5, channel="normal_force"))
            writer.write(NodeStatus(stamp, "/grasp", i, Lifecycle.ACTIVE, rejected={"checksum": i}))


def read_session(folder: Path, out: Path) -> None:
    for table in sorted((folder / "session").glob("**/*.csv")):
        with_refusal(lambda table=table: read_output(table))
    command("import", folder / "session", "-o", out / "session.mcap")


def with_refusal(call: Callable[[], object]) -> None:
    try:
        call()
    except VegripError:
        return


def log(path: Path) -> None:
    codecs = {fd: CanCodec(FINGERS, fd=fd) for fd in (False, True)}
    with can.Logger(path) as logger:
        for i in range(25):
            state = FingertipState(i, FINGERS[i % 2], i // 2, normal_force=0.25 * i, displacement=1e-3)
            for frame in codecs[i > 12].encode(state):
                sent = {"arbitration_id": frame.arbitration_id, "is_extended_id": False, "data": frame.data}
                logger(can.Message(timestamp=1e3 + 0.01 * i, is_fd=frame.fd, is_rx=True, channel=0, **sent))


MAP = """
[table]
delimiter = ";"
skip = 1
[time]
column = "time"
unit = "ms"
[episode]
column = "trial"
gap = 4.0
[channels.normal_force]
column = "F"
unit = "mN"
zero = "baseline"
[channels.displacement]
column = "z"
unit = "mm"
scale = -1
compliance = 1e-4
zero = "contact"
[baseline]
duration = 0.05
[contact]
threshold = 0.02
[fingertip]
radius = 0.008
name = "index"
"""
BAG_MAP = """
[bag]
time = "/wrench"
largest_age = 0.5
[channels.normal_force]
column = "/wrench:wrench.force.z"
[channels.displacement]
column = "/joints:data[1]"
unit = "mm"
"""


def table(folder: Path) -> None:
    rows = [f"{10 * i};{i // 20};{i * i};{-0.01 * i}" for i in range(60)]
    (folder / "press.csv").write_text("\n".join(["from the rig", "time;trial;F;z", *rows]) + "\n")
    (folder / "map.toml").write_text(MAP)


def bag(folder: Path, form: str) -> None:
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    one = form == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if one else Stores.ROS2_HUMBLE)
    packages = ("std_msgs", "geometry_msgs", "builtin_interfaces")
    types = {
        n.rpartition("/")[2]: t
        for package in packages
        for n, t in store.types.items()
        if n.startswith(package)
    }
    plugin = rosbag2.StoragePlugin.MCAP if form == "mcap" else rosbag2.StoragePlugin.SQLITE3
    writer: Any = rosbag1.Writer(folder / "x.bag") if one else None
    if not one:
        writer = rosbag2.Writer(folder / "x", version=9, storage_plugin=plugin)
    pack = store.serialize_ros1 if one else store.serialize_cdr
    with writer:
        wrench = writer.add_connection("/wrench", "geometry_msgs/msg/WrenchStamped", typestore=store)
        joints = writer.add_connection("/joints", "std_msgs/msg/Float64MultiArray", typestore=store)
        for i in range(1, 20):
            stamp = 1_700_000_000 * 10**9 + i * 5_000_000
            head = {"seq": i} if one else {}
            header = types["Header"](stamp=types["Time"](*divmod(stamp, 10**9)), frame_id="tip", **head)
            vector = types["Vector3"]
            force = types["Wrench"](vector(0.0, 0.0, 0.1 * i), vector(0.0, 0.0, 0.0))
            travel = types["Float64MultiArray"](types["MultiArrayLayout"]([], 0), np.array([1.0, 0.01 * i]))
            writer.write(joints, stamp, pack(travel, joints.msgtype))
            writer.write(wrench, stamp, pack(types["WrenchStamped"](header, force), wrench.msgtype))
    (folder / "map.toml").write_text(BAG_MAP)


def launch_file(folder: Path) -> None:
    shutil.copy(ROOT / "launch" / "demo.toml", folder / "x.toml")


def read_launch(folder: Path, out: Path) -> None:
    for node in read_launch_file(folder / "x.toml"):
        context = NodeContext(node.name or node.program, node.namespace, node.fingers)
        find_program(node.program)(node.parameters, context)
    command("launch", folder / "x.toml", "--check")


def learned(folder: Path) -> None:
    model = paper_model(8e-3)
    kept = {name: {"value": model.values[name].value, "std": 0.1, "excited": 9.0} for name in ("mu", "K")}
    content = {"version": 1, "fingerprint": fingerprint(model), "parameters": kept}
    (folder / "x.json").write_text(json.dumps(content, indent=1))


def read_learned(folder: Path, out: Path) -> None:
    memory, model = OnDisk(out), paper_model(8e-3)
    shutil.copy(folder / "x.json", memory._file("index", model))
    memory._known("index", model)


def recording(folder: Path, *, compressed: bool = False) -> None:
    write_recording(press(), folder / "press", compressed=compressed)


def unpacked_mcap(folder: Path) -> None:
    """Write a line of JSON for every record of an MCAP file, to be broken before the checksums are made."""
    from mcap.reader import make_reader

    recording(folder)
    write_mcap(folder / "press", folder / "x.mcap")
    with (folder / "x.mcap").open("rb") as file:
        reader = make_reader(file)
        lines: list[Any] = [["attachment", one.name, one.data.decode()] for one in reader.iter_attachments()]
        for schema, channel, message in reader.iter_messages():
            if len(lines) == 1:
                about = [schema.name, schema.data.decode(), channel.topic, channel.metadata]
                lines.append(["channel", *about])
            lines.append(["message", message.sequence, message.log_time, message.data.decode()])
    (folder / "x.jsonl").write_text("\n".join(map(json.dumps, lines)) + "\n")
    (folder / "x.mcap").unlink()
    shutil.rmtree(folder / "press")


def read_repacked_mcap(folder: Path, out: Path) -> None:
    """Make the file of what the lines say, with good checksums, as far as the library takes them; read it."""
    from mcap.writer import Writer

    channel = 0
    with (out / "x.mcap").open("wb") as file:
        writer = Writer(file, enable_data_crcs=True)
        writer.start(library="vegrip")
        for line in (folder / "x.jsonl").read_text(errors="replace").splitlines():
            with contextlib.suppress(Exception):  # not to be put into a file at all
                kind, *values = json.loads(line)
                if kind == "attachment":
                    writer.add_attachment(0, 0, values[0], "application/toml", values[1].encode())
                elif kind == "channel":
                    schema = writer.register_schema(values[0], "jsonschema", values[1].encode())
                    channel = writer.register_channel(values[2], "json", schema, values[3])
                else:
                    stamp = values[1]
                    writer.add_message(channel, stamp, values[2].encode(), stamp, values[0])
        try:
            writer.finish()
        except Exception as error:
            raise RefusedError from error  # of the library that writes
    command("import", out / "x.mcap", "-o", out / "x")


def read_press(folder: Path, out: Path) -> None:
    write_recording(read_recording(folder / "press", announce=False), out / "again")


PROTOCOL = """
name = "press"
pause = 2.0
[[episode]]
note = "slow"
segments = [{ depth = 1e-3, speed = 1e-3 }, { duration = 2.0 }, { force = 1.0, duration = 1.0, pull_x = 1.0 }]
[[episode]]
segments = [{ depth = 2e-3, duration = 0.5 }, { duration = 1.0, amplitude = 1e-4, frequency = 2.0, spin = 1 }]
"""


def protocol(folder: Path) -> None:
    (folder / "x.toml").write_text(PROTOCOL)


def database(folder: Path) -> None:
    (folder / "x.dbc").write_text(read_proto("fingertip.dbc"))


def read_database(folder: Path, out: Path) -> None:
    try:
        found: Any = cantools.database.load_string((folder / "x.dbc").read_text(errors="replace"), "dbc")
    except Exception as error:
        raise RefusedError from error  # of the library; nothing of ours has seen the file yet
    build_layouts(found)


def canary(read: Callable[[Path, Path], object]) -> Subject:
    """Return a reader that is broken once its file is: it must be found."""

    def judged(folder: Path, out: Path) -> None:
        if (folder / "x").read_bytes() != bytes(range(256)):
            read(folder, out)

    return Subject(lambda folder: (folder / "x").write_bytes(bytes(range(256))), "x", judged)


def burn(folder: Path, out: Path) -> None:
    while True:
        pass


CANARIES = {
    "raises": canary(lambda folder, out: {}["key"]),
    "burns": canary(burn),
    "hogs": canary(lambda folder, out: bytearray(2**32)),
    "fills": canary(lambda folder, out: (out / "y").write_bytes(bytes(2**28 + 1))),
    "escapes": canary(lambda folder, out: (folder / "y").write_text("")),
    "climbs": canary(lambda folder, out: (out / ".." / ".." / "vegrip-canary").mkdir()),
    "spawns": canary(lambda folder, out: os.system("true")),  # noqa: S605, S607 (it must not get so far)
    "crashes": canary(lambda folder, out: os.abort()),
}
"""Readers that do what none may do; the attack must find every one."""

SUBJECTS: dict[str, Subject] = {
    "recording": Subject(recording, "press/*", read_press),
    "recording.gz": Subject(
        lambda folder: recording(folder, compressed=True), "press/*.gz", read_press, zipped=True
    ),
    "session": Subject(session, "session/**/*.*", read_session),
    "table": Subject(
        table,
        "*.*",
        lambda folder, out: command(
            "import", folder / "press.csv", "-o", out / "x", "--map-file", folder / "map.toml"
        ),
    ),
    "mcap": Subject(
        lambda folder: (
            recording(folder),
            write_mcap(folder / "press", folder / "x.mcap"),
            shutil.rmtree(folder / "press"),
        ),
        "x.mcap",
        lambda folder, out: command("import", folder / "x.mcap", "-o", out / "x"),
    ),
    "mcap inside": Subject(unpacked_mcap, "x.jsonl", read_repacked_mcap),
    "asc": Subject(
        lambda folder: log(folder / "x.asc"),
        "x.asc",
        lambda folder, out: command("import", folder / "x.asc", "-o", out / "x", "--fingers", "thumb,index"),
    ),
    "blf": Subject(
        lambda folder: log(folder / "x.blf"),
        "x.blf",
        lambda folder, out: command("import", folder / "x.blf", "-o", out / "x", "--fingers", "thumb,index"),
    ),
    **{
        f"bag {form}": Subject(
            lambda folder, form=form: bag(folder, form),
            "x*" if form == "ros1" else "x/*",
            lambda folder, out: command(
                *("import", next(folder.glob("x*")), "-o", out / "x", "--map-file", folder / "map.toml")
            ),
        )
        for form in ("ros1", "mcap", "sqlite")
    },
    "bag map": Subject(
        lambda folder: bag(folder, "ros1"),
        "map.toml",
        lambda folder, out: command(
            "import", folder / "x.bag", "-o", out / "x", "--map-file", folder / "map.toml"
        ),
    ),
    "model": Subject(
        lambda folder: write_model(paper_model(8e-3), folder / "x.toml"),
        "x.toml",
        lambda folder, out: write_model(read_model(folder / "x.toml"), out / "x.toml"),
    ),
    "launch file": Subject(launch_file, "x.toml", read_launch),
    "learned": Subject(learned, "x.json", read_learned),
    "protocol": Subject(protocol, "x.toml", lambda folder, out: read_protocol(folder / "x.toml")),
    "keys": Subject(
        lambda folder: make_keys(folder, "x"),
        "x.key*",
        lambda folder, out: read_keys(folder / "x.key_secret"),
    ),
    "eds": Subject(
        lambda folder: shutil.copy(ROOT / "proto" / "fingertip.eds", folder / "x.eds"),
        "x.eds",
        lambda folder, out: read_eds(str(folder / "x.eds"), 32, "fingertip.eds"),
    ),
    "dbc": Subject(database, "x.dbc", read_database),
}


def broken(target: Path, subject: Subject, change: Callable[[bytes], bytes], *, inside: bool) -> None:
    """Break the file ``target``; ``inside`` its compression, where it has one."""
    data = target.read_bytes()
    if subject.zipped and inside:
        target.write_bytes(gzip.compress(change(gzip.decompress(data)), mtime=0))
    else:
        target.write_bytes(change(data))
