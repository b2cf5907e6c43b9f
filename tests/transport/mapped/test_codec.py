"""Laws of decoding a foreign hand: what cantools reads, we read, in SI, under our names."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, load, seeded, written
from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.commands import rounding
from vegrip.transport.mapped.compiled import compile_reader, groups_of, packing
from vegrip.transport.mapped.plan import Slot, open_plan
from vegrip.transport.maps.checksums import make_crc
from vegrip.transport.maps.signals import ForeignMessage, Signal

CRC = make_crc(8, 0x2F, 0xFF, 0xFF, reflected=False)
DBC = load(PLAIN_DBC)
MS = 1_000_000


@pytest.fixture
def hand(tmp_path):
    return MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, PLAIN_MAP)))


def tip(n, stamp=None, **values):
    data = bytearray(
        DBC.encode_message("Tip1", {"Cnt": n % 16, "Crc": 0, "Fz": 1.0, "Fx": 0.1, "Fy": 0.1, **values})
    )
    data[7] = CRC(data[:7])
    return Frame(256, bytes(data), False, n * 5 * MS if stamp is None else stamp)


def position(stamp, **values):
    return Frame(
        272, DBC.encode_message("Pos1", {"Depth": 1.0, "Tz": 0.1, "Slip": 0, **values}), False, stamp
    )


def command(force, stamp=0, finger="thumb", seq=0):
    return ForceCommand(stamp, finger, seq, force, 0.0, Reason.HOLD, stamp + 100 * MS)


def test_a_state_has_the_values_of_several_messages_in_si(hand):
    assert not hand.decode_all(position(1, Depth=1.5, Tz=-0.02))
    (state,) = hand.decode_all(tip(1, Fz=1.5, Fx=-0.2, Fy=0.3))
    assert (state.finger, state.stamp) == ("thumb", 5 * MS)
    assert state.normal_force == pytest.approx(1.5)
    assert state.tangential_force_x == pytest.approx(-0.2)
    assert state.tangential_force_y == pytest.approx(0.3)
    assert state.displacement == pytest.approx(1.5e-3)
    assert state.torque_z == pytest.approx(-0.02)
    assert math.isnan(state.slip)


def test_what_has_grown_old_is_missing_and_comes_back(hand):
    hand.decode_all(position(1))
    assert hand.decode_all(tip(1, stamp=50 * MS))[0].displacement == pytest.approx(1e-3)
    assert math.isnan(hand.decode_all(tip(2, stamp=150 * MS))[0].displacement)
    hand.decode_all(position(151 * MS))
    assert hand.decode_all(tip(3, stamp=152 * MS))[0].displacement == pytest.approx(1e-3)


def test_a_channel_that_was_never_other_than_zero_is_missing(hand):
    hand.decode_all(position(1, Tz=0.0))
    first = hand.decode_all(tip(1, Fx=0.0))[0]
    assert math.isnan(first.tangential_force_x)
    assert math.isnan(first.torque_z)
    assert first.tangential_force_y == pytest.approx(0.1)
    assert hand.decode_all(tip(2, Fx=0.01))[0].tangential_force_x == pytest.approx(0.01)
    assert hand.decode_all(tip(3, Fx=0.0))[0].tangential_force_x == 0.0


def test_repeats_wrong_checksums_and_short_frames_give_nothing_and_a_count(hand):
    assert hand.decode_all(tip(1, Fz=1.0))
    assert not hand.decode_all(tip(1, Fz=1.0))
    damaged = tip(2, Fz=1.0)
    assert not hand.decode_all(damaged._replace(data=damaged.data[:3] + b"\xff" + damaged.data[4:]))
    assert not hand.decode_all(damaged._replace(data=damaged.data[:5]))
    assert not hand.decode_all(Frame(0x7FF, b"", False, 1))
    assert hand.rejected == {"counter": 1, "checksum": 1, "length": 1}
    assert hand.broken == {"thumb": 2}
    assert hand.foreign == 1
    hand.decode_all(tip(5, Fz=1.0))
    assert hand.lost == 3


@given(st.binary(max_size=70), st.sampled_from([256, 272, 512, 0, 1 << 31]))
def test_no_bytes_raise(tmp_path_factory, data, identifier):
    codec = no_bytes_raise_hand(tmp_path_factory)
    codec.decode_all(Frame(identifier, data, False, 5))


KEPT = {}


def no_bytes_raise_hand(factory):
    if "hand" not in KEPT:
        KEPT["hand"] = MappedCodec(open_plan(written(factory.mktemp("hand"), PLAIN_DBC, PLAIN_MAP)))
    return KEPT["hand"]


def test_a_command_is_what_cantools_reads(hand):
    for n, force in enumerate((0.0, 3.21, 12.0)):
        (frame,) = hand.encode(command(force, stamp=n))
        values = DBC.decode_message(frame.arbitration_id, frame.data)
        assert values["Grip"] == pytest.approx(force)
        assert (values["Enable"], values["Cnt"]) == (1, n)
        assert values["Crc"] == CRC(frame.data[:7])


def test_a_force_beyond_their_range_stops_at_its_end_and_one_that_is_none_is_not_sent(hand):
    (frame,) = hand.encode(command(70.0))
    assert DBC.decode_message(512, frame.data)["Grip"] == pytest.approx(50.0)
    assert hand.encode(command(math.nan)) == []
    assert hand.encode(command(-1.0)) == []
    assert hand.clipped == {"thumb": 3}


def test_the_last_command_is_repeated_at_the_rate_and_never_becomes_zero(hand):
    assert hand.encoder.due(0) == []  # nothing was commanded and nothing is known
    hand.encode(command(4.0, stamp=0))
    assert hand.encoder.due(19 * MS) == []
    sent = [frame for n in range(1, 51) for frame in hand.encoder.due(n * 20 * MS)]
    assert len(sent) == 50
    assert {round(DBC.decode_message(512, frame.data)["Grip"], 6) for frame in sent} == {4.0}
    assert hand.encoder.held == 46  # after 100 ms its time is over


def test_a_force_that_is_taken_over_is_not_let_down_by_a_sensor_that_reads_too_little(hand):
    pressed, sent = 10.0, []
    for n in range(1, 51):
        hand.decode_all(position(n * 20 * MS))
        hand.decode_all(tip(n, stamp=n * 20 * MS, Fz=0.9 * pressed))
        for frame in hand.encoder.due(n * 20 * MS):
            pressed = DBC.decode_message(512, frame.data)["Grip"]
            sent.append(pressed)
    assert len(sent) == 50
    assert sent == pytest.approx([9.0] * 50)  # was 0.05 N after a second


def test_only_what_is_sent_counts_as_a_held_command(tmp_path):
    text = PLAIN_MAP + 'kind = "increment"\n'
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    assert hand.encode(command(4.0, stamp=0)) == []  # to which force it adds is not known
    assert hand.encoder.due(200 * MS) == []
    assert hand.encoder.held == 0


def test_a_hand_that_holds_by_itself_is_sent_nothing_after_the_lifetime(tmp_path):
    text = PLAIN_MAP + '\n[command]\nsilence = "holds"\n'
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    hand.encode(command(4.0, stamp=0))
    assert len(hand.encoder.due(20 * MS)) == 1
    assert hand.encoder.due(200 * MS) == []


def random_message(seed):
    """Signals of any kind, order and sign that do not overlap."""
    rng = seeded(seed)
    length = rng.choice([8, 8, 12, 64])
    signals, bit = {}, 0
    big = rng.random() < 0.5
    while bit < 8 * length - 1:
        is_float = rng.random() < 0.2 and bit % 8 == 0
        size = rng.choice([16, 32]) if is_float else rng.randint(1, 24)
        if bit + size > 8 * length:
            break
        start = 8 * (bit // 8) + 7 - bit % 8 if big else bit
        name = f"s{len(signals)}"
        signed = not is_float and size > 1 and rng.random() < 0.5
        signals[name] = Signal(
            name, start, size, big, signed, is_float, rng.choice([1.0, 0.01, -0.5]), rng.choice([0.0, -40.0])
        )
        bit += size
    return ForeignMessage("M", 1, length, False, signals)


@pytest.mark.parametrize("seed", range(25))
def test_any_layout_is_read_as_cantools_reads_it(seed):
    from cantools.database.can import Message
    from cantools.database.can import Signal as Peer
    from cantools.database.conversion import BaseConversion

    message = random_message(seed)
    peers = [
        Peer(
            s.name,
            s.start,
            s.length,
            byte_order="big_endian" if s.is_big_endian else "little_endian",
            is_signed=s.is_signed,
            conversion=BaseConversion.factory(s.scale, s.offset, is_float=s.is_float),
        )
        for s in message.signals.values()
    ]
    peer = Message(1, "M", message.length, peers, strict=True)
    slots = [Slot(i, "M", s.name, s, s.scale, s.offset) for i, s in enumerate(message.signals.values())]
    read = compile_reader(message, groups_of(message, slots), 0)
    rng = seeded(seed)
    for _ in range(20):
        data = rng.randbytes(message.length)
        got = [0.0] * len(slots)
        assert read(data, got) == (0,)
        wanted = peer.decode(data, decode_choices=False)
        assert got == [pytest.approx(wanted[slot.signal], rel=1e-12, nan_ok=True) for slot in slots]
        raws = peer.decode(data, scaling=False, decode_choices=False)
        whole = {name: raw for name, raw in raws.items() if not message.signals[name].is_float}
        if len(whole) == len(raws):
            packed = eval(packing(message, whole))  # noqa: S307 (numbers alone)
            assert packed == bytes(peer.encode(whole, scaling=False, strict=False))


def test_bounds_of_a_signal_that_are_both_zero_are_none_and_a_command_passes_them(tmp_path):
    unbounded = PLAIN_DBC.replace("[0|50]", "[0|0]")
    hand = MappedCodec(open_plan(written(tmp_path, unbounded, PLAIN_MAP)))
    (frame,) = hand.encode(command(12.34))
    assert load(unbounded).decode_message(512, frame.data)["Grip"] == pytest.approx(12.34)


def test_a_force_in_a_float_with_scale_and_offset_is_what_cantools_reads(tmp_path):
    real = PLAIN_DBC.replace('0|16@1+ (0.01,0) [0|50] "N"', '0|32@1- (0.5,-1) [0|50] "N"')
    real = real.replace("Enable : 16|", "Enable : 32|")
    real += "SIG_VALTYPE_ 512 Grip : 1;\n"
    hand = MappedCodec(open_plan(written(tmp_path, real, PLAIN_MAP)))
    (frame,) = hand.encode(command(12.3))
    assert load(real).decode_message(512, frame.data)["Grip"] == pytest.approx(12.3)


@pytest.mark.parametrize(("bits", "form"), [(16, "<e"), (32, "<f")])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_force_beyond_a_float_stops_at_its_largest_value_and_never_becomes_zero(bits, form, sign):
    write = rounding(Signal("f", 0, bits, False, False, True, 1.0, 0.0))
    raw, is_beyond = write(sign * 1e39)
    largest = struct.unpack(form, raw.to_bytes(bits // 8, "little"))[0]
    assert is_beyond
    assert math.isfinite(largest)
    assert sign * largest >= 65504.0
    assert write(largest) == (raw, False)
    assert math.isinf(struct.unpack(form, (raw + 1).to_bytes(bits // 8, "little"))[0])


@pytest.mark.parametrize("besides", ["tangential_force_x", "tangential_force_y"])
def test_a_tangential_force_is_polar_or_cartesian_and_never_both(tmp_path, besides):
    other = {"tangential_force_x": "tangential_force_y", "tangential_force_y": "tangential_force_x"}[besides]
    polar = PLAIN_MAP.replace(
        f'[fingers.thumb.{other}]\nsignal = "Tip1.{other[-2:].replace("_", "F")}"',
        '[fingers.thumb.tangential_magnitude]\nsignal = "Pos1.Tz"\nunit = "N"\n'
        '[fingers.thumb.tangential_direction]\nsignal = "Pos1.Slip"\nunit = "rad"',
    )
    assert polar != PLAIN_MAP
    with pytest.raises(ConfigError, match="tangential_magnitude"):
        open_plan(written(tmp_path, PLAIN_DBC, polar))


POLAR_MAP = PLAIN_MAP.replace("tangential_force_x", "tangential_magnitude").replace(
    '[fingers.thumb.tangential_force_y]\nsignal = "Tip1.Fy"',
    '[fingers.thumb.tangential_direction]\nsignal = "Tip1.Fy"\nunit = "rad"',
)


def test_a_polar_force_measures_two_components(tmp_path):
    (finger,) = open_plan(written(tmp_path, PLAIN_DBC, POLAR_MAP)).fingers
    forces = {"normal_force", "tangential_force_x", "tangential_force_y"}
    assert finger.measured == forces | {"displacement", "torque_z"}


def test_a_polar_force_is_turned_like_its_components(tmp_path):
    turned = f"{POLAR_MAP}\n[fingers.thumb]\nrotation = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, turned)))
    (state,) = hand.decode_all(tip(1, Fz=3.0, Fx=2.0, Fy=0.5))
    assert state.normal_force == pytest.approx(2.0 * math.cos(0.5))
    assert state.tangential_force_x == pytest.approx(2.0 * math.sin(0.5))
    assert state.tangential_force_y == pytest.approx(3.0)
