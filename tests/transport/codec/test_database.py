"""The DBC is consistent in itself, with vegrip.messages, and readable by other tools."""

import dataclasses
import re
from typing import Any

import cantools
import pytest
from cantools.database.can import Message as DbcMessage
from cantools.database.can import Signal
from cantools.database.conversion import BaseConversion

from vegrip import messages
from vegrip.effects import BUILT_IN
from vegrip.errors import ConfigError
from vegrip.estimator.layout import CHANNELS, REGIMES
from vegrip.messages import UNKNOWN, Condition, Lifecycle, Reason
from vegrip.transport.codec.database import HEADER, build_layouts, database, layouts
from vegrip.transport.codec.schema import CLASSES, message_set, read_proto
from vegrip.transport.codec.signals import PARTS_OF_ESTIMATE, Place, plan

REAL = BaseConversion.factory(1, 0, is_float=True)
ON_CAN = tuple(cls for cls, schema in message_set().messages.items() if schema.on_can)
FD_LENGTHS = (8, 12, 16, 20, 24, 32, 48, 64)

every_message = pytest.mark.parametrize("message", database().messages, ids=lambda m: m.name)


def text() -> str:
    return read_proto("fingertip.dbc")


def loaded(dbc: str) -> Any:
    return cantools.database.load_string(dbc, database_format="dbc", strict=True)


def attribute(message: DbcMessage, name: str) -> Any:
    assert message.dbc is not None
    return message.dbc.attributes[name].value


def kind(message: DbcMessage) -> type[Any]:
    return CLASSES[attribute(message, "MessageName")]


@every_message
def test_a_part_counts_and_tells_its_version_within_the_bits_that_it_has(message: DbcMessage) -> None:
    (part,) = (one for layout in layouts().layouts for one in layout.parts if one.base == message.frame_id)
    assert (part.name, part.length, part.fd) == (message.name, message.length, message.is_fd)
    assert part.version_modulus == 2 ** message.get_signal_by_name("version").length
    assert part.modulus == (2**32 if message.is_fd else 15)


@every_message
def test_no_two_signals_overlap(message: DbcMessage) -> None:
    used = [bit for s in message.signals for bit in range(s.start, s.start + s.length)]
    assert len(used) == len(set(used))
    assert max(used) < 8 * message.length


@every_message
def test_the_length_is_one_a_controller_can_send(message: DbcMessage) -> None:
    assert message.length in (FD_LENGTHS if message.is_fd else (8,))
    assert not message.is_extended_frame


def test_no_identifier_is_used_twice_by_any_hand_and_finger() -> None:
    plan = layouts()
    parts = [part for layout in plan.layouts for part in layout.parts]
    every = [
        part.base + hand * plan.hand_stride + finger * plan.finger_stride
        for part in parts
        for hand in range(plan.hands)
        for finger in range(plan.fingers)
    ]
    assert (plan.hands, plan.fingers) == (8, 8)
    assert len(every) == len(set(every)) == len(parts) * 64
    assert 0 < min(every) <= max(every) < 0x800


def test_commands_win_the_arbitration_then_states() -> None:
    first = {cls: min(m.frame_id for m in database().messages if kind(m) is cls) for cls in ON_CAN}
    order = sorted(first, key=lambda cls: first[cls])
    assert order[:3] == [messages.ForceCommand, messages.FingertipState, messages.SlipMargin]
    for cls in ON_CAN:
        parts = [m for m in database().messages if kind(m) is cls and not m.is_fd]
        identifiers = [m.frame_id for m in sorted(parts, key=lambda m: int(attribute(m, "MessagePart")))]
        assert identifiers == sorted(identifiers), "a controller sends the lowest identifier first"


@every_message
def test_every_signal_is_a_field_of_its_message(message: DbcMessage) -> None:
    fields = {f.name: f.default for f in dataclasses.fields(kind(message))}
    for signal in message.signals:
        base = re.sub(r"_(std|valid|age)$", "", signal.name)
        estimate = fields.get(base) is UNKNOWN and signal.name.removeprefix(base) in PARTS_OF_ESTIMATE
        assert (
            signal.name in HEADER or signal.name in fields or estimate or signal.name.startswith("rejected_")
        )


def test_the_fd_layout_carries_every_field() -> None:
    for cls in ON_CAN:
        names = {s.name for m in database().messages if m.is_fd and kind(m) is cls for s in m.signals}
        for field in dataclasses.fields(cls)[3:]:
            wanted = [field.name]
            if field.default is UNKNOWN:
                wanted = [field.name + suffix for suffix in PARTS_OF_ESTIMATE]
            elif field.name == "rejected" and cls is messages.NodeStatus:
                wanted = ["rejected_checksum", "rejected_other"]
            assert set(wanted) <= names, (cls, field.name)


@every_message
def test_fd_quantities_are_float32_and_everything_has_its_header(message: DbcMessage) -> None:
    names = [s.name for s in message.signals]
    header = ["crc", "seq", "version", "time"] if message.is_fd else ["crc", "counter", "version"]
    assert set(header) <= set(names)
    for signal in message.signals:
        if signal.is_float:
            assert message.is_fd
            assert (signal.length, signal.scale, signal.offset) == (32, 1, 0)


@pytest.mark.parametrize(
    ("signal", "enumeration"), [("reason", Reason), ("condition", Condition), ("state", Lifecycle)]
)
def test_value_tables_are_the_enumerations(signal: str, enumeration: type[Any]) -> None:
    tables = [
        {raw: str(label) for raw, label in s.choices.items()}
        for m in database().messages
        for s in m.signals
        if s.name == signal and s.choices
    ]
    assert tables == [{member.value: member.name.lower() for member in enumeration}] * 2


def test_both_layouts_use_the_same_words() -> None:
    for signal in ("channel", "regime", "suspect"):
        tables = [
            {str(label): raw for raw, label in s.choices.items() if str(label) != "other"}
            for m in database().messages
            for s in m.signals
            if s.name == signal and s.choices
        ]
        assert len(tables) == 2
        assert tables[0] == tables[1]
        assert tables[0]["none"] == 0


def test_the_channels_of_health_are_the_quantities_of_a_state() -> None:
    signal = database().get_message_by_name("ModelHealthFd").get_signal_by_name("channel")
    words = {str(label) for label in (signal.choices or {}).values()} - {"none", "other"}
    assert words == {f.name for f in dataclasses.fields(messages.FingertipState)[3:]}


def test_what_the_estimator_names_has_a_code() -> None:
    health = database().get_message_by_name("ModelHealthFd")
    for signal, names in (("channel", CHANNELS), ("regime", REGIMES), ("suspect", BUILT_IN)):
        words = {str(label) for label in (health.get_signal_by_name(signal).choices or {}).values()}
        assert set(names) <= words


@every_message
def test_raw_values_set_aside_lie_outside_the_range(message: DbcMessage) -> None:
    for signal in message.signals:
        for raw, label in (signal.choices or {}).items():
            if str(label) in ("not measured", "never"):
                assert not signal.minimum <= raw * signal.scale <= signal.maximum  # type: ignore[operator]


@every_message
def test_every_unit_is_that_of_the_schema(message: DbcMessage) -> None:
    units = {f.name: f.unit for f in message_set().messages[kind(message)].fields}
    for signal in message.signals:
        if signal.name in units and signal.unit:
            same = {"Nm": "N m", "": "1"}.get(signal.unit, signal.unit)
            assert same == units[signal.name] or (signal.name, signal.unit) == ("expires", "s")


def test_versions_agree() -> None:
    assert layouts().version == message_set().version == messages.VERSION
    assert loaded(text()).version == str(messages.VERSION)


def test_writing_the_database_with_cantools_loses_nothing() -> None:
    first = loaded(text()).as_dbc_string()
    assert loaded(first).as_dbc_string() == first
    for ours, theirs in zip(database().messages, loaded(first).messages, strict=True):
        assert (ours.frame_id, ours.length, ours.is_fd, ours.comment) == (
            *(theirs.frame_id, theirs.length, theirs.is_fd, theirs.comment),
        )
        assert {s.name: signature(s) for s in ours.signals} == {s.name: signature(s) for s in theirs.signals}


def signature(s: Any) -> tuple[Any, ...]:
    choices = {raw: str(label) for raw, label in (s.choices or {}).items()}
    limits = (s.minimum, s.maximum)
    return (s.start, s.length, s.is_signed, s.is_float, s.scale, s.offset, limits, s.unit, s.comment, choices)


NUMBER = r"[0-9.+\-eE]+"
SAVVYCAN = {
    "BO_ ": r"^BO_ (\w+) (\w+) *: (\w+) (\w+)",
    "SG_ ": rf"^SG_ *(\w+) *: *(\d+)\|(\d+)@(\d+)([+|-]) \(({NUMBER}),({NUMBER})\)"
    rf' \[({NUMBER})\|({NUMBER})\] "(.*)" (.*)',
    "VAL_ ": r"^VAL_ (\w+) (\w+) (.*);",
    "CM_ SG_ ": r'^CM_ SG_ *(\w+) *(\w+) *"(.*)";',
    "CM_ BO_ ": r'^CM_ BO_ *(\w+) *"(.*)";',
    "BA_DEF_ BO_ ": r'^BA_DEF_ BO_ "*(\w+)"* "*(\w+)"*',
    "BA_DEF_DEF_ ": r'^BA_DEF_DEF_ "*(\w+)"* "*([#\w]*)"*',
    'BA_ "VFrameFormat': r'^BA_ "*(\w+)"* BO_ (\d+) "*([#\w]+)"*',
}
"""What SavvyCAN accepts of a line, blanks squeezed: it reads line by line and counts others as faults."""


def test_every_line_is_one_that_savvycan_reads() -> None:
    lines = [" ".join(line.split()) for line in text().splitlines()]
    for start, pattern in SAVVYCAN.items():
        matching = [line for line in lines if line.startswith(start)]
        assert matching
        assert [line for line in matching if not re.match(pattern, line)] == []
    assert text().isascii()


def test_every_float_is_declared_as_one() -> None:
    declared = set(re.findall(r"^SIG_VALTYPE_ (\d+) (\w+) : 1;", text(), re.MULTILINE))
    floats = {(str(m.frame_id), s.name) for m in database().messages for s in m.signals if s.is_float}
    assert declared == floats != set()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("SG_ adjustment : 32|16@1- (0.001,0)", "SG_ adjustment : 32|16@1- (0.001,1)"),
        ("SG_ adjustment : 32|16@1-", "SG_ adjustment : 39|16@0-"),
        ("SG_ adjustment : 32|16@1-", "SG_ adjustment : 32|12@1-"),
        ("SG_ adjustment : 32|16@1-", "SG_ adjustment : 36|6@1-"),
        ("SG_ adjustment : 32|16@1-", "SG_ adjustment : 36|5@1-"),
        ("SG_ adjustment : 32|16@1-", "SG_ adjustment M : 32|16@1-"),
        ("SG_ adjustment : 128|32@1- (1,0)", "SG_ adjustment : 128|32@1- (2,0)"),
        ("SG_ adjustment : 128|32@1- (1,0)", "SG_ adjustment : 128|32@1- (1,2)"),
        ("SG_ adjustment : 32|16@1-", "SG_ weight : 32|16@1-"),
        ('BA_ "MessageSetVersion" 1;', 'BA_ "MessageSetVersion" 2;'),
        ('BA_ "E2EProfile" BO_ 64 2;', 'BA_ "E2EProfile" BO_ 64 0;'),
        ('BA_ "MessagePart" BO_ 320 2;', 'BA_ "MessagePart" BO_ 320 4;'),
    ],
)
def test_a_database_that_cannot_be_followed_is_refused(before: str, after: str) -> None:
    """An edited file is either carried out as it says, or refused when it is loaded."""
    assert before in text()
    edited = re.sub(r"^(CM_|VAL_).*adjustment.*\n", "", text().replace(before, after), flags=re.MULTILINE)
    with pytest.raises(ConfigError, match=r"fingertip\.dbc"):
        build_layouts(loaded(edited))


def test_whole_cells_of_every_size_and_bits_within_a_byte_are_laid_out_around_reserved_bytes() -> None:
    wide = Signal("real", 80, 64, conversion=REAL), Signal("whole", 16, 64, is_signed=True)
    narrow = Signal("byte", 8, 8), Signal("low", 152, 3), Signal("high", 155, 5)
    packer, places = plan(DbcMessage(1, "M", 22, [*wide, *narrow]))
    assert packer.format == "<xBqdxBxx"
    bits = {"low": Place(3, 0, 0b111), "high": Place(3, 3, 0b11111)}
    assert places == {"byte": Place(0), "whole": Place(1), "real": Place(2), **bits}


def test_a_moved_signal_is_followed() -> None:
    """The codec has no layout of its own: swap two signals in the file and the frames follow."""
    force, adjustment = "SG_ normal_force : 16|16@1-", "SG_ adjustment : 32|16@1-"
    edited = text().replace(force, force.replace("16|", "32|"), 1)
    edited = edited.replace(adjustment, adjustment.replace("32|", "16|"), 1)
    layout = next(x for x in build_layouts(loaded(edited)).layouts if x.schema.cls is messages.ForceCommand)
    places = {slot.name: slot.place.cell for slot in layout.parts[0].slots}
    assert places["adjustment"] < places["normal_force"]
