"""Laws of a hand that speaks protobuf: fields by name, wrong names told at the start."""

import math

import pytest
from google.protobuf import text_format
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.descriptor_pb2 import FieldDescriptorProto as Field
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from hypothesis import given
from hypothesis import strategies as st

from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.mapped import plan as opening
from vegrip.transport.mapped.body_paths import parse_path
from vegrip.transport.mapped.codec import TopicCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.protobuf import WHOLE, ProtobufBodies

MS = 1_000_000
MAP = """
format = "protobuf"
database = "hand.desc"
rate = 100.0

[messages."hand/state"]
type = "acme.HandState"
counter = "header.n"
[messages."hand/set"]
type = "acme.HandCommand"
counter = "n"

[fingers.thumb.normal_force]
signal = "hand/state:tips[name=T].fz"
unit = "mN"
sign = -1
[fingers.thumb.tangential_force_x]
signal = "hand/state:tips[name=T].f[0]"
unit = "mN"
[fingers.thumb.displacement]
signal = "hand/state:depth.thumb"
unit = "mm"
[fingers.thumb.command]
signal = "hand/set:goals[finger=1].force"
unit = "mN"
set = { "enable" = 1 }
"""

SCALAR = {
    "double": Field.TYPE_DOUBLE,
    "float": Field.TYPE_FLOAT,
    "int32": Field.TYPE_INT32,
    "uint32": Field.TYPE_UINT32,
    "bool": Field.TYPE_BOOL,
    "string": Field.TYPE_STRING,
}
MESSAGES = {
    "Header": {"n": "uint32"},
    "Tip": {"name": "string", "fz": "float", "f": "*double"},
    "HandState": {"header": "Header", "tips": "*Tip", "depth": "map"},
    "Goal": {"finger": "int32", "force": "uint32"},
    "HandCommand": {"n": "uint32", "goals": "*Goal", "enable": "bool"},
}


def descriptors():
    """Return what ``protoc --include_imports --descriptor_set_out`` writes of acme's hand.proto."""
    made = FileDescriptorSet()
    file = made.file.add(name="hand.proto", package="acme", syntax="proto3")
    for name, fields in MESSAGES.items():
        message = file.message_type.add(name=name)
        for number, (field, kind) in enumerate(fields.items(), 1):
            plain = kind.removeprefix("*")
            one = message.field.add(name=field, number=number)
            one.label = Field.LABEL_REPEATED if kind[0] == "*" or kind == "map" else Field.LABEL_OPTIONAL
            if plain in SCALAR:
                one.type = SCALAR[plain]
                continue
            one.type = Field.TYPE_MESSAGE
            one.type_name = f".acme.{plain}"
            if kind == "map":
                entry = message.nested_type.add(name="DepthEntry")
                entry.options.map_entry = True
                entry.field.add(name="key", number=1, type=Field.TYPE_STRING, label=Field.LABEL_OPTIONAL)
                entry.field.add(name="value", number=2, type=Field.TYPE_DOUBLE, label=Field.LABEL_OPTIONAL)
                one.type_name = f".acme.{name}.DepthEntry"
    return made.SerializeToString()


def class_of(name):
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(descriptors()).file:
        pool.AddSerializedFile(file.SerializeToString())
    return GetMessageClass(pool.FindMessageTypeByName(f"acme.{name}"))


def codec_of(folder, text=MAP, described=None):
    (folder / "hand.toml").write_text(text)
    (folder / "hand.desc").write_bytes(descriptors() if described is None else described)
    return TopicCodec(open_plan(folder / "hand.toml"))


def said(n, **tips):
    state = class_of("HandState")()
    state.header.n = n
    for name, (fz, *f) in tips.items():
        state.tips.add(name=name, fz=fz, f=f)
    state.depth["thumb"] = 1.25
    return state.SerializeToString()


@pytest.fixture
def codec(tmp_path):
    return codec_of(tmp_path)


def test_fields_of_lists_maps_and_parts_are_read_in_si(codec):
    (thumb,) = codec.decode_all("hand/state", said(5, I=(-200.0, 1.0), T=(-1500.0, 100.0)), 1)
    assert thumb.normal_force == pytest.approx(1.5)
    assert thumb.tangential_force_x == pytest.approx(0.1)
    assert thumb.displacement == pytest.approx(1.25e-3)
    assert thumb.seq == 5


def test_a_part_that_is_not_there_is_missing_and_no_zero(codec):
    codec.decode_all("hand/state", said(1, T=(-1500.0, 100.0)), 1)
    (thumb,) = codec.decode_all("hand/state", said(2, I=(-200.0, 1.0)), 2)
    assert math.isnan(thumb.normal_force)
    assert math.isnan(thumb.tangential_force_x)
    assert codec.rejected == {}
    (thumb,) = codec.decode_all("hand/state", said(3, T=(-1500.0,)), 3)
    assert thumb.normal_force == pytest.approx(1.5)
    assert math.isnan(thumb.tangential_force_x)


def test_bytes_that_are_no_message_are_counted(codec):
    assert codec.decode_all("hand/state", b"\xff\xff\xff", 1) == []
    assert codec.rejected == {"schema": 1}


KEPT = {}


@given(st.binary(max_size=64))
def test_no_bytes_raise(tmp_path_factory, payload):
    if not KEPT:
        KEPT["codec"] = codec_of(tmp_path_factory.mktemp("protobuf"))
    KEPT["codec"].decode_all("hand/state", payload, 1)


def test_a_command_is_a_message_of_their_type_and_stops_at_the_end_of_its_field(codec):
    topic, payload = codec.encode(ForceCommand(0, "thumb", 0, 2.0, 0.0, Reason.HOLD, 100 * MS))
    sent = class_of("HandCommand").FromString(payload)
    assert topic == "hand/set"
    assert [(goal.finger, goal.force) for goal in sent.goals] == [(1, 2000)]
    assert sent.enable
    codec.encode(ForceCommand(1, "thumb", 1, 1e9, 0.0, Reason.HOLD, 100 * MS))
    ((_, payload),) = codec.due(40 * MS)
    again = class_of("HandCommand").FromString(payload)
    assert (again.goals[0].force, again.n) == (2**32 - 1, 2)


@pytest.mark.parametrize(
    ("puts", "text"),
    [
        ({"header.n": 2.6}, "header { n: 3 }"),
        ({"header.n": -1.0}, "header { }"),
        ({"depth.thumb": 1.5, "depth.index": 2.5}, """depth { key: "thumb" value: 1.5 }
            depth { key: "index" value: 2.5 }"""),
        ({"tips[1].fz": 2.0}, "tips { } tips { fz: 2 }"),
        ({"tips[name=T].fz": 2.0, "tips[name=I].fz": 3.0, "tips[name=T].f[0]": 4.0},
         """tips { name: "T" fz: 2 f: 4 } tips { name: "I" fz: 3 }"""),
        ({"tips[0].f[2]": 5.0}, "tips { f: 0 f: 0 f: 5 }"),
        ({"tips[0].f[2]": 5.0, "tips[0].f[0]": 6.0, "tips[0].f[3]": 7.0}, "tips { f: 6 f: 0 f: 5 f: 7 }"),
    ],
)  # fmt: skip
def test_what_is_put_into_a_message_stands_at_its_place_and_nothing_else(puts, text):
    """As protobuf reads the text; a list that is filled up to a place has zeros before it."""
    bodies = ProtobufBodies(descriptors(), {"hand/state": "acme.HandState"}, "hand.toml")
    body = None
    for path, value in puts.items():
        body = bodies.put("hand/state", body, parse_path(path, ""), value)
    state = class_of("HandState")()
    text_format.Parse(text, state)
    assert state.FromString(bodies.dump(body)) == state
    for path, value in puts.items():
        found = bodies.getter("hand/state", parse_path(path, ""), "")(body)
        assert found == (max(round(value), 0) if path == "header.n" else value)


BAD = {
    "a field that is not there": ('T].fz"', 'T].fx"', "acme.Tip has no field 'fx'"),
    "a field that is no number": ('T].fz"', 'T].name"', "acme.Tip.name is no number"),
    "a list without a number": ("T].f[0]", "T].f", r"'f' has several; write f\[0\]"),
    "a map without a key": ("depth.thumb", "depth", "'depth' has several; write depth.KEY"),
    "a number with parts": ('T].fz"', 'T].fz.x"', "has no parts like 'x'"),
    "a number with a key": ("T].f[0]", "T].f[x=1]", "a number has no field 'x'"),
    "a key that is not there": ("tips[name=T].fz", "tips[id=T].fz", "acme.Tip has no field 'id'"),
    "a topic without a type": ('type = "acme.HandState"', "", r'which message comes on .*type = "acme\.'),
    "a type that is not there": ("acme.HandState", "acme.HandStat", "did you mean acme.HandState"),
    "a command that cannot be": ("].force", "].fource", "acme.Goal has no field 'fource'"),
    "no descriptors": ('database = "hand.desc"', "", "protoc --include_imports"),
    "a file that is not there": ('database = "hand.desc"', 'database = "other.desc"', "other.desc: cannot"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_does_not_agree_with_the_descriptors_is_said_at_the_start(tmp_path, name):
    before, after, sentence = BAD[name]
    assert before in MAP
    with pytest.raises(ConfigError, match=sentence):
        codec_of(tmp_path, MAP.replace(before, after))


@pytest.mark.parametrize("described", [b"", b"\xff\xff", b"not a descriptor set"])
def test_what_is_no_descriptor_set_is_refused_with_the_command_that_makes_one(tmp_path, described):
    with pytest.raises(ConfigError, match=r"--descriptor_set_out=hand\.desc"):
        codec_of(tmp_path, described=described)


@pytest.mark.parametrize("absent", ["google", "google.protobuf"])
def test_without_the_library_the_remedy_is_said(tmp_path, monkeypatch, absent):
    monkeypatch.setattr(opening, "find_spec", lambda name: None if name == absent else name)
    with pytest.raises(ConfigError, match=r"pip install 'vegrip\[protobuf\]'"):
        codec_of(tmp_path)


def test_whole_numbers_end_where_the_library_ends_them():
    file = FileDescriptorSet().file.add(name="whole.proto", package="acme", syntax="proto3")
    message = file.message_type.add(name="Whole")
    kinds = ("int32", "uint32", "int64", "uint64", "bool")
    for number, kind in enumerate(kinds, 1):
        one = message.field.add(name=kind, number=number, label=Field.LABEL_OPTIONAL)
        one.type = getattr(Field, f"TYPE_{kind.upper()}")
    pool = DescriptorPool()
    pool.AddSerializedFile(file.SerializeToString())
    whole = GetMessageClass(pool.FindMessageTypeByName("acme.Whole"))()
    for kind in kinds:
        for sign, end in zip((-1, 1), WHOLE[whole.DESCRIPTOR.fields_by_name[kind].cpp_type], strict=True):
            setattr(whole, kind, bool(end) if kind == "bool" else end)
            assert getattr(whole, kind) == end
            if kind == "bool":
                assert end == (sign > 0)
                continue
            with pytest.raises(ValueError, match=r"out of range|Value"):
                setattr(whole, kind, end + sign)
    assert WHOLE[FieldDescriptor.CPPTYPE_ENUM] == WHOLE[FieldDescriptor.CPPTYPE_INT32]
