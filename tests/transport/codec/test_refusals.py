"""Every fault has its name, and a receiver that has refused a frame goes on."""

import dataclasses
import math
import struct
from collections.abc import Callable

import msgpack
import pytest

from vegrip.messages import (
    Estimate,
    FingertipState,
    ForceCommand,
    GraspPhase,
    GraspStatus,
    Lifecycle,
    Message,
    NodeStatus,
    Reason,
    SlipMargin,
)  # fmt: skip
from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
from vegrip.transport.codec.database import database, layouts
from vegrip.transport.codec.protection import P04, P04_HEADER
from vegrip.transport.codec.schema import Topics, data_id_of
from vegrip.transport.codec.sequence import MOST_STRANGERS, Streams
from vegrip.transport.codec.signals import Real

FINGERS = ("thumb", "index")
PROFILES = {part.base: part.profile for layout in layouts().layouts for part in layout.parts}


def forge(frame: Frame, **changes: bytes) -> Frame:
    """Overwrite bytes (``at5=b"..."``) and protect the frame anew, as a faulty sender would."""
    data = bytearray(frame.data)
    for at, new in changes.items():
        start = int(at.removeprefix("at"))
        data[start : start + len(new)] = new
    PROFILES[frame.arbitration_id & ~0x3F].protect(data, frame.arbitration_id)
    return frame._replace(data=bytes(data))


@pytest.fixture(params=[False, True], ids=["classic", "fd"])
def fd(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture
def command(fd: bool, examples: list[Message]) -> Frame:
    return CanCodec(FINGERS, fd=fd).encode(examples[3])[0]


def refused(frame: Frame, fd: bool) -> dict[str, int]:
    receiver = CanCodec(FINGERS, fd=fd)
    assert receiver.decode(frame) is None
    return dict(receiver.rejected)


def test_an_identifier_without_a_message_is_named(fd: bool, command: Frame) -> None:
    for identifier in (0x000, 0x03F, 0x7FF, 0x1FFFFFFF, -1):
        assert refused(command._replace(arbitration_id=identifier), fd) == {"unknown_id": 1}


def test_a_finger_that_is_not_configured_is_named(fd: bool, command: Frame) -> None:
    assert refused(command._replace(arbitration_id=command.arbitration_id + 1), fd) == {"finger": 1}


def test_the_other_layout_is_named(fd: bool, command: Frame) -> None:
    assert refused(command, not fd) == {"layout": 1}
    assert refused(command._replace(fd=not command.fd), fd) == {"layout": 1}


def test_a_frame_for_another_hand_is_no_fault(fd: bool, examples: list[Message]) -> None:
    receiver = CanCodec(FINGERS, fd=fd, hand=0)
    assert receiver.decode(CanCodec(FINGERS, fd=fd, hand=1).encode(examples[3])[0]) is None
    assert (receiver.rejected, receiver.foreign) == ({}, 1)


@pytest.mark.parametrize("change", [lambda d: d[:-1], lambda d: d + b"\0", lambda d: d[:0]])
def test_another_length_is_named(change: Callable[[bytes], bytes], fd: bool, command: Frame) -> None:
    assert refused(command._replace(data=change(command.data)), fd) == {"length": 1}


def test_a_bad_checksum_is_named(fd: bool, command: Frame) -> None:
    assert refused(command._replace(data=bytes(len(command.data))), fd) == {"checksum": 1}


def test_another_version_is_named_even_though_its_checksum_holds(fd: bool, command: Frame) -> None:
    other = forge(command, at6=b"\2") if fd else forge(command, at1=bytes([(command.data[1] & 0x0F) | 0x20]))
    assert refused(other, fd) == {"version": 1}


def test_a_reason_without_a_meaning_is_named(fd: bool, command: Frame) -> None:
    assert refused(forge(command, at20=b"\xee") if fd else forge(command, at6=b"\xee"), fd) == {"value": 1}


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
def test_a_command_that_is_no_number_is_named(number: float, examples: list[Message]) -> None:
    frame = CanCodec(FINGERS, fd=True).encode(examples[3])[0]
    assert refused(forge(frame, at12=struct.pack("<f", number)), fd=True) == {"value": 1}


def test_an_infinite_margin_is_named(examples: list[Message]) -> None:
    frame = CanCodec(FINGERS, fd=True).encode(examples[2])[0]
    signal = database().get_message_by_name("SlipMarginFd").get_signal_by_name("margin")
    infinite = forge(frame, **{f"at{signal.start // 8}": struct.pack("<f", math.inf)})
    assert refused(infinite, fd=True) == {"value": 1}


@pytest.mark.parametrize("channels", [64, 1 << 20])
def test_a_contact_by_channels_that_have_no_name_is_not_sent_and_counted(
    channels: int, fd: bool, examples: list[Message]
) -> None:
    sender = CanCodec(FINGERS, fd=fd)
    assert sender.encode(dataclasses.replace(examples[1], channels=channels)) == []  # type: ignore[type-var]
    assert sender.clipped == {"channels": 1}


LARGEST = (2.0 - 2.0**-23) * 2.0**127  # of single precision


@pytest.mark.parametrize("value", [0.0, -1.5, 2.0**127, LARGEST, -LARGEST, math.nan])
def test_a_real_travels_as_it_is_and_one_beyond_single_precision_does_not(value: float) -> None:
    real = Real()
    assert repr(real.read(real.write(value))) == repr(value)
    assert real.write(math.copysign(2.0**128, value)) is None
    assert real.write(math.copysign(math.inf, value)) is None


def test_an_infinite_force_is_named(examples: list[Message]) -> None:
    frame = CanCodec(FINGERS, fd=True).encode(examples[0])[0]
    assert refused(forge(frame, at12=struct.pack("<f", float("inf"))), fd=True) == {"value": 1}


def test_a_raw_value_outside_its_range_is_named(examples: list[Message]) -> None:
    frame = CanCodec(FINGERS, fd=False).encode(examples[3])[0]
    assert refused(forge(frame, at2=struct.pack("<h", -32768)), fd=False) == {"value": 1}


def test_after_a_refusal_the_next_good_frame_is_taken(fd: bool, command: Frame) -> None:
    receiver = CanCodec(FINGERS, fd=fd)
    receiver.decode(command._replace(data=b"x" * len(command.data)))
    assert receiver.decode(command) is not None


def payload_of(body: object, topic: str = "/hand/index/force_command", counter: int = 7) -> bytes:
    route = Topics().incoming(topic)
    assert route is not None
    data = bytearray(P04_HEADER) + (body if isinstance(body, bytes) else msgpack.packb(body))
    data[2:4] = counter.to_bytes(2, "big")
    P04.protect(data, route.data_id)
    return bytes(data)


GOOD = {
    "version": 1,
    "stamp": 5,
    "finger": "index",
    "seq": 7,
    "normal_force": 4.2,
    "adjustment": 0,
    "reason": 1,
    "expires": 9,
}
FAULTS: dict[str, tuple[str, object]] = {
    "another version": ("version", GOOD | {"version": 2}),
    "no version": ("version", {k: v for k, v in GOOD.items() if k != "version"}),
    "not a map": ("schema", [1, 2, 3]),
    "a field missing": ("schema", {k: v for k, v in GOOD.items() if k != "expires"}),
    "text for a number": ("type", GOOD | {"normal_force": "4.2"}),
    "a flag for a number": ("type", GOOD | {"normal_force": True}),
    "nothing for a number": ("type", GOOD | {"normal_force": None}),
    "a fraction for a counter": ("type", GOOD | {"seq": 7.0}),
    "a flag for a counter": ("type", GOOD | {"seq": True}),
    "text for a time": ("type", GOOD | {"stamp": "5"}),
    "a negative counter": ("value", GOOD | {"seq": -1}),
    "a counter of more than 32 bits": ("value", GOOD | {"seq": 2**32}),
    "NaN for a command": ("value", GOOD | {"normal_force": float("nan")}),
    "infinity for a command": ("value", GOOD | {"adjustment": float("inf")}),
    "an unknown reason": ("value", GOOD | {"reason": 99}),
    "a finger that is not the topic's": ("finger", GOOD | {"finger": "thumb"}),
    "a name that is no name": ("value", GOOD | {"finger": "in dex"}),
    "a name too long": ("size", GOOD | {"finger": "i" * 65}),
    "a counter that is not the header's": ("counter", GOOD | {"seq": 8}),
    "an extension type": ("schema", GOOD | {"extra": msgpack.ExtType(5, b"x")}),
    "bytes": ("schema", GOOD | {"extra": b"x"}),
    "a number as a key": ("schema", {1: 2, **GOOD}),
    "nesting without end": ("schema", b"\x91" * 2000),
    "bytes that are no msgpack": ("schema", b"\xc1\xc1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_payload_is_named(fault: str) -> None:
    name, body = FAULTS[fault]
    receiver = MsgpackCodec()
    assert receiver.decode("/hand/index/force_command", payload_of(body), 0) is None
    assert receiver.rejected == {name: 1}


KNOWN = [0.25, 0.01, True, 0.0]
MARGIN = {"version": 1, "stamp": 5, "finger": "index", "seq": 7, "margin": KNOWN}
STATUS = {"version": 1, "stamp": 5, "node": "grasp", "seq": 7, "state": 2, "rejected": {"checksum": 3}}
OTHER_FAULTS: dict[str, tuple[str, str, object]] = {
    "an estimate that is no list": ("type", "slip_margin", MARGIN | {"margin": 0.25}),
    "an estimate of three": ("type", "slip_margin", MARGIN | {"margin": KNOWN[:3]}),
    "an infinite estimate": ("value", "slip_margin", MARGIN | {"margin": [float("inf"), *KNOWN[1:]]}),
    "text in an estimate": ("type", "slip_margin", MARGIN | {"margin": [0.25, "0.01", True, 0.0]}),
    "a number for a flag": ("type", "slip_margin", MARGIN | {"margin": [0.25, 0.01, 1, 0.0]}),
    "text for a quantity": ("type", "state", MARGIN | {"normal_force": "4.2"}),
    "an infinite quantity": ("value", "state", MARGIN | {"normal_force": float("-inf")}),
    "a number for a name": ("type", "slip_margin", MARGIN | {"finger": 7}),
    "a list of counts": ("type", "status", STATUS | {"rejected": [3]}),
    "a number for the name of a count": ("schema", "status", STATUS | {"rejected": {3: 3}}),
    "a fraction for a count": ("type", "status", STATUS | {"rejected": {"checksum": 3.0}}),
}


@pytest.mark.parametrize("fault", OTHER_FAULTS)
def test_a_faulty_part_of_an_estimate_or_a_status_is_named(fault: str) -> None:
    name, kind, body = OTHER_FAULTS[fault]
    topic = {"status": "/diagnostics"}.get(kind, f"/hand/index/{kind}")
    receiver = MsgpackCodec()
    assert receiver.decode(topic, payload_of(body, topic), 0) is None
    assert receiver.rejected == {name: 1}


def test_a_whole_number_is_a_number_in_an_estimate() -> None:
    topic, receiver = "/hand/index/slip_margin", MsgpackCodec()
    message = receiver.decode(topic, payload_of(MARGIN | {"margin": [0, 1, True, 2]}, topic), 0)
    assert isinstance(message, SlipMargin)
    assert message.margin == Estimate(0.0, 1.0, True, 2.0)


@pytest.mark.parametrize(
    ("message", "clipped"),
    [
        (
            NodeStatus(
                5, "grasp", 7, Lifecycle.ACTIVE, rejected={f"{n}".rjust(64, "x"): 2**62 for n in range(64)}
            ),
            "size",
        ),
        (FingertipState(5, "little", 7), "finger"),
        (ForceCommand(5, "index", 7, math.inf, 0.0, Reason.HOLD, 9), "normal_force"),
        (ForceCommand(5, "index", 7, math.nan, 0.0, Reason.HOLD, 9), "normal_force"),
    ],
)
def test_what_no_payload_can_carry_is_not_sent_and_counted(message: Message, clipped: str) -> None:
    sender = MsgpackCodec(fingers=FINGERS)
    assert sender.encode(message) is None
    assert sender.clipped == {clipped: 1}


def test_an_infinite_estimate_is_left_out_and_counted() -> None:
    sender, receiver = MsgpackCodec(), MsgpackCodec()
    sent = sender.encode(SlipMargin(5, "index", 7, Estimate(math.inf, 0.0, True, 0.0), 0.25, 0.95))
    assert sent is not None
    assert sender.clipped == {"margin": 1}
    told = receiver.decode(*sent, 0)
    assert isinstance(told, SlipMargin)
    assert (told.lower_bound, told.margin.valid) == (0.25, False)


def test_a_command_that_is_no_number_goes_in_no_classic_frames(fd: bool) -> None:
    sender = CanCodec(FINGERS, fd=fd)
    assert sender.encode(ForceCommand(5, "index", 7, math.nan, 0.0, Reason.HOLD, 9)) == []
    assert sender.clipped == {"normal_force": 1}


def test_fields_of_a_later_revision_are_passed_over() -> None:
    receiver = MsgpackCodec()
    body = GOOD | {"grip_mode": "soft", "weights": [1, 2, 3]}
    assert receiver.decode("/hand/index/force_command", payload_of(body), 0) is not None
    assert not receiver.rejected


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"finger": "i" * 64}, {}),
        ({"note": "n" * 256}, {}),
        ({"note": "n" * 257}, {"schema": 1}),
        ({"weights": [1] * 8}, {}),
        ({"weights": [1] * 9}, {"schema": 1}),
        ({"weights": dict.fromkeys(map(str, range(64)), 1)}, {}),
        ({"weights": dict.fromkeys(map(str, range(65)), 1)}, {"schema": 1}),
    ],
)
def test_texts_and_maps_may_be_so_long_and_no_longer(
    change: dict[str, object], fault: dict[str, int]
) -> None:
    receiver, body = MsgpackCodec(), GOOD | change
    topic = f"/hand/{body['finger']}/force_command"
    assert (receiver.decode(topic, payload_of(body, topic), 0) is not None) == (not fault)
    assert receiver.rejected == fault


def test_a_payload_too_long_or_too_short_is_named() -> None:
    receiver = MsgpackCodec()
    for size in (0, 11, 12, 4097, 10_000_000):
        assert receiver.decode("/hand/index/force_command", bytes(size), 0) is None
    assert receiver.rejected == {"size": 5}
    for size in (13, 4096):
        assert receiver.decode("/hand/index/force_command", bytes(size), 0) is None
    assert receiver.rejected == {"size": 5, "checksum": 2}


def test_a_payload_of_4096_bytes_is_sent_and_a_longer_one_is_not() -> None:
    def status(length: int) -> NodeStatus:
        names = [f"{n:02}".ljust(64 if n else length, "x") for n in range(60)]
        return NodeStatus(5, "grasp", 7, Lifecycle.ACTIVE, rejected=dict.fromkeys(names, 1))

    sender = MsgpackCodec()
    sent = [sender.encode(status(length)) for length in range(1, 65)]
    sizes = [len(payload) for _, payload in (one or ("", b"") for one in sent)]
    assert max(sizes) == 4096
    assert sender.clipped == {"size": sizes.count(0)}
    assert sizes.count(0) > 0


def test_bytes_after_the_message_are_refused() -> None:
    receiver = MsgpackCodec()
    assert receiver.decode("/hand/index/force_command", payload_of(GOOD) + b"\0", 0) is None
    assert receiver.rejected == {"checksum": 1}


@pytest.mark.parametrize(
    "topic", ["", "/", "/hand", "/hand/thumb", "/hand/thumb/states", "/right/hand/thumb/state"]
)
def test_an_unknown_topic_is_named(topic: str) -> None:
    receiver = MsgpackCodec()
    assert receiver.decode(topic, b"", 0) is None
    assert receiver.rejected == {"unknown_topic": 1}


def test_a_flood_of_finger_names_does_not_grow_the_memory_and_keeps_no_newcomer_out() -> None:
    receiver = MsgpackCodec()
    for number in range(3000):
        topic = f"/hand/f{number}/force_command"
        assert receiver.decode(topic, payload_of(GOOD | {"finger": f"f{number}"}, topic), 0) is not None
    assert receiver.rejected == {}
    assert MOST_STRANGERS == 1024
    assert receiver.crowded == 3000 - MOST_STRANGERS


def test_a_flood_of_finger_names_leaves_no_more_than_1024_routes_of_each_way() -> None:
    topics = Topics()
    for number in range(1500):
        assert topics.incoming(f"/hand/f{number}/state") is not None
        assert topics.incoming(f"/hand/f{number}/nonsense") is None
        assert topics.outgoing(FingertipState, f"f{number}") is not None
        assert topics.outgoing(FingertipState, f"in dex {number}") is None
    assert len(topics._incoming) == len(topics._outgoing) == 1024
    assert None not in topics._incoming.values()


@pytest.mark.parametrize("before", [0, 1], ids=["first heard after the flood", "heard before it"])
def test_a_flood_of_node_names_takes_no_place_of_a_configured_finger(before: int) -> None:
    sender, receiver = MsgpackCodec(), MsgpackCodec(fingers=FINGERS)
    states = [sender.encode(FingertipState(0, "index", seq)) or ("", b"") for seq in range(3)]
    for seq in range(before):
        assert receiver.decode(*states[seq], 0) is not None
    for number in range(5000):
        receiver.decode(*(sender.encode(NodeStatus(0, f"n{number}", 0, Lifecycle.ACTIVE)) or ("", b"")), 0)
    for seq in range(before, 3):
        assert receiver.decode(*states[seq], 0) is not None
    assert receiver.decode(*states[2], 0) is None, "its counter was not forgotten"
    assert receiver.rejected == {"counter": 1}


def test_of_those_who_crowd_the_one_silent_for_longest_gives_way() -> None:
    streams = Streams((), 2**32)
    steady = streams.of("/diagnostics", "steady")
    for number in range(5000):
        streams.of("/diagnostics", f"n{number}")
        assert streams.of("/diagnostics", "steady") is steady
    assert streams.crowded == 5001 - MOST_STRANGERS


def test_what_forgotten_streams_have_lost_stays_counted() -> None:
    streams = Streams((), 2**32)
    for number in range(3000):
        stream = streams.of("/diagnostics", f"n{number}")
        stream.advance(0, 0)
        stream.advance(2, 0)
    assert streams.lost == 3000


@pytest.mark.parametrize("at", [2**63, 2**64 - 1])
@pytest.mark.parametrize("field", ["stamp", "expires"])
def test_a_time_beyond_64_bits_is_refused(field: str, at: int) -> None:
    receiver = MsgpackCodec()
    assert receiver.decode("/hand/index/force_command", payload_of(GOOD | {field: at}), 0) is None
    assert receiver.rejected == {"value": 1}


@pytest.mark.parametrize("at", [-(2**63), 2**63 - 1])
def test_a_time_moved_to_our_clock_that_leaves_64_bits_is_refused(at: int) -> None:
    receiver = MsgpackCodec(use_sender_time=False)
    body = GOOD | {"stamp": -at - 1, "expires": at}
    assert receiver.decode("/hand/index/force_command", payload_of(body), 10**18) is None
    assert receiver.rejected == {"value": 1}


@pytest.mark.parametrize("at", [2**63, -(2**63) - 1, 2**64, 2**200])
def test_a_time_beyond_64_bits_is_not_sent_and_counted(at: int) -> None:
    sender = MsgpackCodec()
    assert sender.encode(FingertipState(at, "index", 0)) is None
    assert sender.clipped == {"stamp": 1}


@pytest.mark.parametrize(("entries", "letters"), [(64, 2), (65, 2), (200, 3), (3, 64), (3, 65), (3, 99)])
def test_of_long_counts_64_entries_are_sent_and_64_letters_of_each_name(entries: int, letters: int) -> None:
    """What is said beyond that is cut off by the sender, for a receiver would refuse the whole message."""
    names = [f"{number:02d}".ljust(letters, "x") for number in range(entries)]
    sender, receiver = MsgpackCodec(), MsgpackCodec()
    status = NodeStatus(1, "node", 0, Lifecycle.ACTIVE, rejected={name: i for i, name in enumerate(names)})
    found = receiver.decode(*(sender.encode(status) or ("", b"")), 0)
    assert isinstance(found, NodeStatus)
    assert found.rejected == {name[:64]: i for i, name in enumerate(names[:64])}
    assert receiver.rejected == {}


@pytest.mark.parametrize("length", [63, 64, 65, 300])
def test_of_a_long_text_64_letters_are_sent(length: int) -> None:
    sender, receiver = MsgpackCodec(), MsgpackCodec()
    status = GraspStatus(1, "node", 0, GraspPhase.WEAK, length * "x")
    found = receiver.decode(*(sender.encode(status) or ("", b"")), 0)
    assert isinstance(found, GraspStatus)
    assert found.reason == min(length, 64) * "x"


@pytest.mark.parametrize(
    ("entries", "letters", "is_taken"), [(64, 2, True), (65, 2, False), (3, 64, True), (3, 65, False)]
)
def test_of_counts_a_receiver_takes_64_entries_and_64_letters_of_each_name(
    entries: int, letters: int, is_taken: bool
) -> None:
    topic, payload = MsgpackCodec().encode(NodeStatus(1, "node", 0, Lifecycle.ACTIVE)) or ("", b"")
    fields = msgpack.unpackb(payload[P04_HEADER:])
    fields["rejected"] = {f"{number:02d}".ljust(letters, "x"): 1 for number in range(entries)}
    data = bytearray(payload[:P04_HEADER] + msgpack.packb(fields))
    P04.protect(data, data_id_of(topic))
    receiver = MsgpackCodec()
    found = receiver.decode(topic, bytes(data), 0)
    assert (found is not None) == is_taken
    assert sum(receiver.rejected.values()) == (not is_taken)
