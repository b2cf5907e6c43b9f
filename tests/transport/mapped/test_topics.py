"""Laws of a foreign hand on a network: paths into JSON and msgpack, and commands on the same way."""

import json
import math

import msgpack
import pytest
import zmq
from hypothesis import given
from hypothesis import strategies as st

from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.mapped.bodies import PlainBodies
from vegrip.transport.mapped.body_paths import getter, parse_path, put
from vegrip.transport.mapped.codec import TopicCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.open import Hand, open_endpoint

MS = 1_000_000
MAP = """
format = "json"
rate = 100.0

[messages."hand/state"]
counter = "header.n"

[fingers.thumb.normal_force]
signal = "hand/state:tips[name=T].f[2]"
unit = "mN"
sign = -1
[fingers.thumb.tangential_force_x]
signal = "hand/state:tips[name=T].f[0]"
unit = "mN"
[fingers.thumb.tangential_force_y]
signal = "hand/state:tips[name=T].f[1]"
unit = "mN"
[fingers.thumb.displacement]
signal = "hand/joints:q.thumb"
unit = "deg"
gain = "40 mm/rad"
[fingers.thumb.command]
signal = "hand/set:tips[name=T].force"
unit = "mN"
set = { "mode" = 2 }
high = 9000

[fingers.index.normal_force]
signal = "hand/state:tips[name=I].f[2]"
unit = "mN"
sign = -1
[fingers.index.command]
signal = "hand/set:tips[name=I].force"
unit = "mN"
"""


def codec_of(folder, text=MAP):
    path = folder / "hand.toml"
    path.write_text(text)
    return TopicCodec(open_plan(path))


@pytest.fixture
def codec(tmp_path):
    return codec_of(tmp_path)


def body(n, thumb=(100, -50, -1500), index=(0, 0, -200)):
    return {"header": {"n": n}, "tips": [{"name": "I", "f": list(index)}, {"name": "T", "f": list(thumb)}]}


def said(n, **values):
    return json.dumps(body(n, **values)).encode()


def test_one_message_makes_a_state_of_each_finger_in_si(codec):
    assert codec.decode_all("hand/joints", b'{"q": {"thumb": 1.5}}', 1) == []
    thumb, index = codec.decode_all("hand/state", said(7), 2)
    assert thumb.normal_force == pytest.approx(1.5)
    assert (thumb.tangential_force_x, thumb.tangential_force_y) == (pytest.approx(0.1), pytest.approx(-0.05))
    assert thumb.displacement == pytest.approx(0.04 * math.radians(1.5))
    assert index.normal_force == pytest.approx(0.2)
    assert math.isnan(index.displacement)
    assert (thumb.seq, index.seq) == (7, 7)


def test_msgpack_of_the_same_shape_gives_the_same(codec, tmp_path):
    other = codec_of(tmp_path, MAP.replace('"json"', '"msgpack"'))
    a, b = (
        codec.decode_all("hand/state", said(7), 2),
        other.decode_all("hand/state", msgpack.packb(body(7)), 2),
    )
    assert repr(a) == repr(b)


def test_what_is_wrong_gives_nothing_and_a_count(codec):
    for payload in (b"", b"{", b"[" * 40_000, b"7", b"\xff", b'{"header": {"n": "x"}}'):
        assert codec.decode_all("hand/state", payload, 1) == []
    assert codec.decode_all("hand/state", b"[" + b"1," * 40_000 + b"1]", 1) == []
    assert codec.decode_all("other", said(1), 1) == []
    codec.decode_all("hand/state", said(2), 2)
    assert codec.decode_all("hand/state", said(2), 3) == []
    assert codec.rejected == {"schema": 5, "size": 1, "counter": 2, "unknown_topic": 1}
    assert codec.broken["thumb"] == 6
    assert codec.crowded == 0


def test_a_message_of_65536_bytes_is_read_and_a_longer_one_is_not(codec):
    full = said(1).rjust(65_536)
    assert codec.decode_all("hand/state", full, 1)
    assert codec.decode_all("hand/state", b" " + full, 2) == []
    assert codec.rejected == {"size": 1}


@pytest.mark.parametrize("made", [lambda n: [0.0] * n, lambda n: dict.fromkeys(map(str, range(n)))])
def test_a_list_or_map_of_msgpack_has_at_most_1024_entries(made):
    bodies = PlainBodies(is_json=False)
    assert bodies.load("t", msgpack.packb(made(1024))) == made(1024)
    with pytest.raises(ValueError, match="1025"):
        bodies.load("t", msgpack.packb(made(1025)))


def test_a_counter_begins_anew_after_32_bits_and_without_one_states_are_counted(codec, tmp_path):
    assert [codec.decode_all("hand/state", said(n), 1)[0].seq for n in (2**32 - 1, 0)] == [2**32 - 1, 2**32]
    bare = codec_of(tmp_path, MAP.replace('counter = "header.n"\n', ""))
    assert [bare.decode_all("hand/state", said(7), n)[0].seq for n in (1, 2)] == [0, 1]


def test_a_text_where_a_number_belongs_is_missing_and_counted(codec):
    (thumb, _) = codec.decode_all("hand/state", said(1, thumb=("a", None, -1000)), 1)
    assert math.isnan(thumb.tangential_force_x)
    assert math.isnan(thumb.tangential_force_y)
    assert thumb.normal_force == pytest.approx(1.0)
    assert codec.rejected == {"value": 1}
    codec.decode_all("hand/state", said(2, thumb=(int(1e300), 1, 1)), 2)
    assert codec.rejected == {"value": 2}


KEPT = {}


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda x: (
            st.lists(x) | st.dictionaries(st.sampled_from(["header", "n", "tips", "name", "f", "T"]), x)
        ),
        max_leaves=12,
    )
)
def test_no_message_raises(tmp_path_factory, value):
    if not KEPT:
        KEPT["codec"] = codec_of(tmp_path_factory.mktemp("topics"))
    KEPT["codec"].decode_all("hand/state", json.dumps(value).encode(), 1)


@pytest.mark.parametrize("signal", ["hand/state", "hand/state:", ":tips[name=I].f[2]", " : "])
def test_a_signal_without_topic_or_path_is_refused(tmp_path, signal):
    with pytest.raises(ConfigError, match="must be TOPIC:PATH"):
        codec_of(tmp_path, MAP.replace("hand/state:tips[name=I].f[2]", signal))


def command(finger, force, stamp=0):
    return ForceCommand(stamp, finger, 0, force, 0.0, Reason.HOLD, stamp + 100 * MS)


def test_a_command_waits_for_the_others_in_its_message_and_is_repeated(codec):
    assert codec.encode(command("thumb", 2.0)) is None
    topic, payload = codec.encode(command("index", 1.0))
    assert topic == "hand/set"
    assert json.loads(payload) == {
        "tips": [{"name": "T", "force": 2000.0}, {"name": "I", "force": 1000.0}],
        "mode": 2,
    }
    again = [json.loads(text) for n in range(1, 20) for _, text in codec.due(n * 20 * MS)]
    assert len(again) == 19
    assert all(one["tips"][0]["force"] == 2000.0 for one in again)
    assert codec.encode(command("thumb", math.nan)) is None
    assert codec.encode(command("thumb", math.inf)) is None
    codec.encode(command("thumb", 50.0, 500 * MS))
    _, payload = codec.encode(command("index", 1.0, 500 * MS))
    assert json.loads(payload)["tips"][0]["force"] == 9000
    assert codec.clipped["thumb"] == 3
    codec.encode(command("thumb", 0.0, 501 * MS))
    _, payload = codec.encode(command("index", 1.0, 501 * MS))
    assert json.loads(payload)["tips"][0]["force"] == 0.0


@pytest.mark.parametrize("text", ["a.b", "a[0]", "a[0].b[n=T].c", "[3].x"])
def test_what_is_put_at_a_path_is_found_there(text):
    steps = parse_path(text, "map")
    assert getter(steps)(put(None, steps, 4.5)) == 4.5


@pytest.mark.parametrize(
    ("puts", "body"),
    [
        ({"a[1]": 1.0, "a[3]": 2.0, "a[0]": 3.0}, {"a": [3.0, 1.0, None, 2.0]}),
        (
            {"t[n=T].x": 1.0, "t[n=I].x": 2.0, "t[n=T].y": 3.0},
            {"t": [{"n": "T", "x": 1.0, "y": 3.0}, {"n": "I", "x": 2.0}]},
        ),
        ({"t[0]": 1.0, "t[n=T].x": 2.0}, {"t": [1.0, {"n": "T", "x": 2.0}]}),
    ],
)
def test_what_is_put_at_paths_stands_there_and_nothing_else(puts, body):
    made = None
    for path, value in puts.items():
        made = put(made, parse_path(path, "map"), value)
    assert made == body


@pytest.mark.parametrize(
    ("path", "body", "found"),
    [
        ("f[2]", {"f": [1, 2]}, None),
        ("f[0]", {"f": {"0": 1}}, None),
        ("f[n=T]", {"f": 7}, None),
        ("f[n=T].x", {"f": [7, {"n": "I", "x": 1}]}, None),
        ("f[n=7].x", {"f": [7, {"n": 7, "x": 1}]}, 1),
    ],
)
def test_what_is_not_at_a_path_is_missing(path, body, found):
    assert getter(parse_path(path, "map"))(body) == found


@pytest.mark.parametrize("text", ["", ".", ".a", "a.", "a..b", "a[", "a[x]", "a]"])
def test_a_path_that_is_none_is_refused(text):
    with pytest.raises(ConfigError, match="path"):
        parse_path(text, "map")


@pytest.mark.usefixtures("runtime")
def test_over_sockets_states_come_in_and_commands_go_out(tmp_path, runtime):
    path = tmp_path / "hand.toml"
    path.write_text(MAP)
    context = zmq.Context()
    hand = context.socket(zmq.PUB)
    port = hand.bind_to_random_port("tcp://127.0.0.1")
    table = {
        "kind": "zmq",
        "publish": "ipc:to-hand",
        "subscribe": [f"tcp://127.0.0.1:{port}"],
        "map": str(path),
    }
    node = open_endpoint(table, Hand(("thumb", "index")))
    listener = context.socket(zmq.SUB)
    listener.setsockopt(zmq.RCVTIMEO, 100)
    listener.connect(f"ipc://{runtime}/r/zmq/to-hand")
    listener.subscribe(b"")
    try:
        for n in range(200):
            hand.send_multipart([b"hand/state", said(n)])
            states = node.receive(0.05)
            if states:
                break
        assert {state.finger for state in states} == {"thumb", "index"}
        for n in range(100):
            for finger in ("thumb", "index"):
                node.send(command(finger, 1.0 + n))
            try:
                topic, payload = listener.recv_multipart()
                break
            except zmq.Again:
                continue
        assert topic == b"hand/set"
        assert json.loads(payload)["mode"] == 2
    finally:
        node.close()
        context.destroy(linger=0)


@pytest.mark.parametrize(
    ("written", "read", "counted"),
    [(10**200, 1e200, 0), (-(10**200), -1e200, 0), (10**299, 1e299, 0), (10**400, math.nan, 1),
     (-(10**400), math.nan, 1), (True, 1.0, 0)],
    ids=["1e200", "-1e200", "1e299", "1e400", "-1e400", "true"],
)  # fmt: skip
def test_a_whole_number_is_read_as_far_as_a_double_goes_and_then_counted(tmp_path, written, read, counted):
    text = 'format = "json"\n[fingers.a.normal_force]\nsignal = "s:f"\nunit = "N"\n'
    codec = codec_of(tmp_path, text)
    (state,) = codec.decode_all("s", json.dumps({"f": written}).encode(), 1)
    assert state.normal_force == pytest.approx(read, nan_ok=True)
    assert +codec.rejected == ({"value": counted} if counted else {})


@pytest.mark.parametrize("counter", [True, False, 1.0, "1", None, [1]])
def test_a_counter_is_a_whole_number_and_nothing_that_looks_like_one(codec, counter):
    assert codec.decode_all("hand/state", said(counter), 1) == []
    assert codec.rejected == {"counter": 1}
    assert len(codec.decode_all("hand/state", said(1), 2)) == 2


def test_two_fingers_cannot_be_commanded_by_one_value_of_a_body(tmp_path):
    with pytest.raises(ConfigError, match="already takes the command of another finger"):
        codec_of(tmp_path, MAP.replace("hand/set:tips[name=I].force", "hand/set:tips[name=T].force"))
    codec_of(tmp_path, MAP.replace("hand/set:tips[name=I].force", "hand/set:tips[name=I].other"))
