"""A recording or session comes back from MCAP as it was, and an MCAP file that is not whole is refused."""

import io
import json
import math
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.identification.recording.drawn import check_same, recordings
from vegrip.cli import main
from vegrip.errors import RecordingError, UsageError
from vegrip.identification.recording import Recording, read_recording, write_recording
from vegrip.identification.recording.mcap import from_json, properties, read_mcap, to_json, write_mcap
from vegrip.identification.recording.writer import FILE_OF_MESSAGE, RecordingWriter, csv_header
from vegrip.messages import (
    Channel,
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

mcap_reader = pytest.importorskip("mcap.reader", reason="the extra `bags` is not installed")
mcap_writer = pytest.importorskip("mcap.writer", reason="the extra `bags` is not installed")

START = 10**12
Capsys = pytest.CaptureFixture[str]
value = st.floats(allow_infinity=False)  # NaN is a missing value


@given(recordings())
@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])
def test_a_recording_comes_back_from_mcap_bit_for_bit(recording: Recording) -> None:
    with TemporaryDirectory() as place:
        there, between, back = (Path(place) / name for name in ("there", "between.mcap", "back"))
        write_recording(recording, there)
        write_mcap(there, between)
        (read,) = read_mcap(between, back).values()
    check_same(read, recording)


def everything(i: int) -> list[Message]:
    """One of each kind, with what text formats stumble over: infinity, quotes, empty names, many digits."""
    stamp = START + i * 2_000_001
    level = Estimate(1.0 / (i + 3.0), math.inf, bool(i % 2), 0.1 * i)
    return [
        FingertipState(stamp, "thumb", i, normal_force=0.1 * i, slip=math.nan if i else 1.0),
        FingertipState(stamp + 7, "index", i, displacement=1e-9 * i),
        ContactEstimate(stamp + 50, "thumb", i, True, Channel.FORCE | Channel.TORQUE, indentation=level),
        SlipMargin(stamp + 60, "thumb", i, margin=level, time_to_slip=math.inf, earliest_slip=math.inf),
        ForceCommand(stamp + 70, "index", i, 2.0 / 3.0, -0.25, Reason.RAISE, stamp + 10**8),
        ModelHealth(stamp + 80, "thumb", i, nis=0.7, channel="normal_force" if i else "", regime="µ \\ inf"),
        NodeStatus(stamp - 90, "/left/grasp", i, Lifecycle.ACTIVE, rejected={"crc": i, "stale": 1}),
    ]


@pytest.fixture
def session(tmp_path: Path) -> Path:
    with RecordingWriter(tmp_path / "grasp", radius=0.008, sensors={"normal_force": 0.01}) as writer:
        for i in range(5):
            for message in everything(i):
                writer.write(message)
    return tmp_path / "grasp"


def test_a_session_comes_back_with_every_byte_of_what_was_said(session: Path, tmp_path: Path) -> None:
    write_mcap(session, tmp_path / "grasp.mcap")
    found = read_mcap(tmp_path / "grasp.mcap", tmp_path / "back")
    names = {path.relative_to(session).as_posix() for path in session.rglob("*.*")}
    assert names == {p.relative_to(tmp_path / "back").as_posix() for p in (tmp_path / "back").rglob("*.*")}
    assert len(names) == 10  # session, diagnostics, two recordings of two files, four tables of what was said
    for name in sorted(names):
        if not name.endswith("recording.csv"):  # there, columns that were never measured are not repeated
            assert (tmp_path / "back" / name).read_bytes() == (session / name).read_bytes(), name
    assert sorted(place.name for place in found) == ["index", "thumb"]
    for place, recording in found.items():
        before = read_recording(session / place.name)
        assert recording.t.tobytes() == before.t.tobytes()
        assert {n: v.tobytes() for n, v in recording.columns.items()} == {
            n: v.tobytes() for n, v in before.columns.items()
        }


def test_the_file_is_mcap_with_json_of_its_schema_on_our_topics(session: Path, tmp_path: Path) -> None:
    write_mcap(session, tmp_path / "grasp.mcap")
    seen = {}
    with (tmp_path / "grasp.mcap").open("rb") as file:
        for schema, channel, message in mcap_reader.make_reader(file, validate_crcs=True).iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            declared, body = json.loads(schema.data), json.loads(message.data)
            assert set(declared["required"]) <= set(body) <= set(declared["properties"])
            for name, item in body.items():
                assert isinstance(item, str) == (declared["properties"][name]["type"] == "string")
            seen[channel.topic] = (schema.name, message.log_time, body)
    assert sorted(seen) == [
        "/diagnostics",
        "/hand/index/force_command",
        "/hand/index/state",
        "/hand/thumb/contact",
        "/hand/thumb/model_health",
        "/hand/thumb/slip_margin",
        "/hand/thumb/state",
    ]
    name, stamp, body = seen["/hand/thumb/state"]
    assert (name, stamp) == ("vegrip.FingertipState", START + 4 * 2_000_001)
    assert body["normal_force"] == pytest.approx(0.4)
    assert "slip" not in body  # not measured is left out, never zero
    assert math.isinf(seen["/hand/thumb/slip_margin"][2]["time_to_slip"])


def test_the_columns_of_every_table_have_a_type() -> None:
    for kind in FILE_OF_MESSAGE:
        assert sorted(properties(kind)) == sorted(csv_header(kind).split(","))


def test_times_before_zero_keep_their_order(tmp_path: Path) -> None:
    early = Recording("x", np.array([-0.5, 0.25]), np.zeros(2, int), {"slip": np.array([0.0, 1.0])})
    write_recording(early, tmp_path / "x")
    write_mcap(tmp_path / "x", tmp_path / "x.mcap")
    with (tmp_path / "x.mcap").open("rb") as file:
        times = [m.log_time for _, _, m in mcap_reader.make_reader(file).iter_messages()]
    assert times == [0, 750_000_000]
    (read,) = read_mcap(tmp_path / "x.mcap", tmp_path / "back").values()
    assert read.t.tolist() == [-0.5, 0.25]


@given(st.dictionaries(st.sampled_from(["a", "b", "c"]), value | st.sampled_from([math.inf, -math.inf])))
def test_numbers_go_through_json_by_their_text(row: dict[str, float]) -> None:
    cells = {name: "" if math.isnan(number) else repr(number) for name, number in row.items()}
    known = {name: {"type": "number"} for name in "abc"}
    data = to_json(cells, known)
    assert {name: number for name, number in row.items() if not math.isnan(number)} == json.loads(data)
    assert from_json(data, list(cells)) == ",".join(cells.values())


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b'{"t":', "is not JSON"),
        (b"[1]", "is not a JSON object"),
        (b'{"t":1,"F":2}', "unknown field 'F'"),
        (b'{"t":[1]}', "t is \\['1'\\]"),
        (b'{"t":NaN}', "t is nan"),
        (b'{"t":true}', "t is True"),
        (b'{"t":"1,2"}', "t is '1,2'"),
        (b'{"t":"1\\n2"}', "plain text"),
        (b"\xff\xff", "is not JSON"),
    ],
)
def test_what_is_no_row_is_refused(data: bytes, sentence: str) -> None:
    with pytest.raises(RecordingError, match=sentence):
        from_json(data, ["t"])


def forged(
    path: Path, file: str = "recording.csv", rows: int = 2, sequences: tuple[int, ...] = (0, 1)
) -> Path:
    """An MCAP file as vegrip writes it, with something wrong."""
    stream = io.BytesIO()
    writer = mcap_writer.Writer(stream)
    writer.start()
    writer.add_attachment(0, 0, "recording.toml", "application/toml", b"[fingertip]\n[sensors]\n")
    about = {"file": file, "columns": "t,slip", "rows": str(rows)}
    channel = writer.register_channel("/hand/thumb/state", "json", 0, about if file else {})
    for i in sequences:
        writer.add_message(channel, i, f'{{"t":{i},"slip":0.0}}'.encode(), i, i)
    writer.finish()
    path.write_bytes(stream.getvalue())
    return path


def test_the_forged_file_is_read_when_nothing_is_wrong_with_it(tmp_path: Path) -> None:
    (read,) = read_mcap(forged(tmp_path / "a.mcap"), tmp_path / "out").values()
    assert read.t.tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"file": "../recording.csv"}, "unexpected file '../recording.csv'"),
        ({"file": "/etc/recording.csv"}, "unexpected file"),
        ({"file": "a/b/recording.csv"}, "unexpected file"),
        ({"file": "x.sh"}, "unexpected file"),
        ({"file": ""}, "was not written by vegrip"),
        ({"rows": 3}, "holds 2 of 3 messages"),
        ({"sequences": (0, 2)}, "/hand/thumb/state: message 1 is missing; in its place stands 2"),
        ({"sequences": (1, 0)}, "message 0 is missing"),
    ],
)
def test_a_file_that_is_not_all_there_is_refused_and_nothing_written(
    wrong: dict[str, object], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=sentence):
        read_mcap(forged(tmp_path / "a.mcap", **wrong), tmp_path / "out")  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


@settings(deadline=None, max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.floats(0.0, 1.0), flip=st.integers(0, 255))
def test_damage_is_refused_or_leaves_the_numbers_as_they_were(
    where: float, flip: int, session: Path, tmp_path: Path
) -> None:
    """A byte turned anywhere (0: the file is cut there) never gives other numbers, and never a traceback."""
    write_mcap(session / "thumb", tmp_path / "whole.mcap")
    data = bytearray((tmp_path / "whole.mcap").read_bytes())
    at = min(int(where * len(data)), len(data) - 1)
    data[at] ^= flip
    (tmp_path / "bad.mcap").write_bytes(data if flip else data[:at])
    with TemporaryDirectory() as place:
        try:
            read = list(read_mcap(tmp_path / "bad.mcap", Path(place) / "out").values())
        except RecordingError:
            return
    before = read_recording(session / "thumb")
    assert [r.t.tobytes() for r in read] == [before.t.tobytes()]
    assert {n: v.tobytes() for n, v in read[0].columns.items()} == {
        n: v.tobytes() for n, v in before.columns.items()
    }
    assert (read[0].fingertip, read[0].sensors) == (before.fingertip, before.sensors)


def test_no_byte_of_the_descriptions_may_turn(session: Path, tmp_path: Path) -> None:
    """The library does not check the sums of attachments; the radius in them must not change unseen."""
    write_mcap(session, tmp_path / "whole.mcap")
    data = (tmp_path / "whole.mcap").read_bytes()
    assert b"radius = 0.008" in data
    (tmp_path / "bad.mcap").write_bytes(data.replace(b"radius = 0.008", b"radius = 0.009"))
    with pytest.raises(RecordingError, match="is not a whole MCAP file"):
        read_mcap(tmp_path / "bad.mcap", tmp_path / "out")


def test_the_command_goes_both_ways(session: Path, tmp_path: Path, capsys: Capsys) -> None:
    file, back = str(tmp_path / "grasp.mcap"), str(tmp_path / "back")
    assert main(["import", str(session), "-o", file]) == 0
    assert "5 of 5 rows kept" in capsys.readouterr().out
    assert main(["import", file, "-o", back, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["recordings"]
    assert [(each["finger"], each["rows"], each["radius"]) for each in told] == [
        ("index", 5, 0.008),
        ("thumb", 5, 0.008),
    ]
    assert main(["import", file, "-o", back]) == 3
    assert "holds a recording already" in capsys.readouterr().err
    assert main(["import", file, "-o", str(tmp_path / "new"), "--radius", "8 mm"]) == 2
    assert "--radius does not apply to a recording in MCAP" in capsys.readouterr().err


def test_states_that_the_recorder_lost_are_told_on_the_way_there_and_back(
    tmp_path: Path, capsys: Capsys
) -> None:
    with RecordingWriter(tmp_path / "s", radius=0.008) as writer:
        for i in (*range(10), *range(13, 100)):
            for message in everything(i):
                writer.write(message)
    file = tmp_path / "s.mcap"
    assert main(["import", str(tmp_path / "s"), "-o", str(file)]) == 0
    assert "3 states were sent and are not in it" in capsys.readouterr().out
    assert main(["import", str(file), "-o", str(tmp_path / "back")]) == 0
    assert "3 states were sent and are not in it" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["absent.mcap", "-o", "out"], "there is no such file"),
        (["empty.mcap", "-o", "out"], "is not a whole MCAP file (EndOfFile)"),
        (["nothing", "-o", "out.mcap"], "there is no such folder"),
    ],
)
def test_what_cannot_be_converted_gets_one_sentence(
    arguments: list[str], sentence: str, tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("empty.mcap").write_bytes(b"")
    assert main(["import", *arguments]) == 3
    shown = capsys.readouterr().err
    assert sentence in shown
    assert len(shown.strip().splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty.mcap"]


def test_a_missing_library_is_asked_for(
    session: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    with pytest.raises(UsageError, match=r"needs the library mcap .*pip install 'vegrip\[bags\]'"):
        write_mcap(session, tmp_path / "grasp.mcap")


def test_a_damaged_table_of_the_session_is_refused_with_its_row(session: Path, tmp_path: Path) -> None:
    table = session / "thumb" / "slip_margin.csv"
    table.write_text(table.read_text().replace(",0.25,", ",bad,"))
    with pytest.raises(RecordingError, match=r"slip_margin.csv: row 2: margin is 'bad'"):
        write_mcap(session, tmp_path / "grasp.mcap")
    assert list(tmp_path.iterdir()) == [session]
