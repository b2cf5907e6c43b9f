"""Laws of decoding a foreign hand: what cantools reads, we read, in SI, under our names."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, load, seeded, written
from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.commands import Law, Outgoing, law_of, rounding
from vegrip.transport.mapped.compiled import compile_reader, groups_of, interpolated, packing
from vegrip.transport.mapped.plan import Slot, open_plan
from vegrip.transport.maps.checksums import make_crc
from vegrip.transport.maps.schema import CommandMap
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


def test_a_zero_that_is_stated_to_be_measured_is_one_from_the_first_on(tmp_path):
    text = PLAIN_MAP.replace('"Tip1.Fx"', '"Tip1.Fx"\nzero_is_measured = true')
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    assert hand.decode_all(tip(1, Fx=0.0))[0].tangential_force_x == 0.0


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


@pytest.mark.parametrize(("stated", "modulus"), [("", 16), ("modulus = 15\n", 15)])
def test_counters_of_both_ways_begin_anew_after_their_bits_or_what_is_stated(tmp_path, stated, modulus):
    text = PLAIN_MAP.replace('counter = "Cnt"\n', f'counter = "Cnt"\n{stated}')
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    frames = [frame for n in range(20) for frame in hand.encode(command(1.0, stamp=n))]
    counts = [DBC.decode_message(512, frame.data)["Cnt"] for frame in frames]
    assert counts == [n % modulus for n in range(20)]
    states = [state for n in (modulus - 1, 0) for state in hand.decode_all(tip(n, stamp=n))]
    assert [state.seq for state in states] == [modulus - 1, modulus]


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
        size = rng.choice([16, 32, 64]) if is_float else rng.randint(1, 24)
        if bit + size > 8 * length:
            break
        start = 8 * (bit // 8) + 7 - bit % 8 if big else bit
        name = f"s{len(signals)}"
        signed = not is_float and size > 1 and rng.random() < 0.5
        signals[name] = Signal(
            name,
            start,
            size,
            big,
            signed,
            is_float,
            rng.choice([1.0, 0.01, -0.5, 2.0]),
            rng.choice([0.0, -40.0]),
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


@pytest.mark.parametrize("bits", [16, 32, 64])
@pytest.mark.parametrize("raw", [False, True])
def test_a_float_of_any_size_is_what_numpy_makes_and_ends_at_its_largest_number(bits, raw):
    kind = np.dtype(f"<f{bits // 8}")
    write = rounding(Signal("F", 0, bits, is_float=True, scale=0.5, offset=-1.0), raw=raw)
    for value in (12.3, -1.0, 1e5, -1e5, 1e39, -1e39, 1.7e308):
        steps = value if raw else (value + 1.0) / 0.5
        end = float(np.finfo(kind).max)
        found, is_beyond = write(value)
        assert np.frombuffer(found.to_bytes(bits // 8, "little"), kind)[0] == kind.type(
            np.clip(steps, -end, end)
        )
        assert is_beyond == (abs(steps) > end)


@pytest.mark.parametrize(
    ("value", "raw", "is_beyond"),
    [(12.3, 5, False), (10.0, 0, False), (9.0, 0, True), (137.6, 255, False), (138.0, 255, True)],
)
def test_a_whole_number_is_rounded_and_ends_where_its_bits_do(value, raw, is_beyond):
    signal = Signal("W", 0, 8, scale=0.5, offset=10.0)
    assert rounding(signal)(value) == (raw, is_beyond)
    assert rounding(signal, raw=True)(value) == (round(value), False)


@pytest.mark.parametrize(("force", "count"), [(50.0, 0), (50.0 + 9e-6, 0), (50.0 + 1.1e-5, 1)])
def test_a_command_above_the_range_by_the_rounding_of_a_map_is_not_counted(hand, force, count):
    (frame,) = hand.encode(command(force))
    assert DBC.decode_message(512, frame.data)["Grip"] == pytest.approx(50.0)
    assert hand.clipped["thumb"] == count


@pytest.mark.parametrize(("force", "count"), [(12.7, 0), (12.7 + 1e-6, 0), (20.0, 1)])
def test_a_command_that_the_bits_cannot_hold_stops_at_their_end(tmp_path, force, count):
    few = PLAIN_DBC.replace('0|16@1+ (0.01,0) [0|50] "N"', '0|7@1+ (0.1,0) [0|0] "N"')
    hand = MappedCodec(open_plan(written(tmp_path, few, PLAIN_MAP)))
    (frame,) = hand.encode(command(force))
    assert load(few).decode_message(512, frame.data)["Grip"] == pytest.approx(12.7)
    assert hand.clipped["thumb"] == count


@pytest.mark.parametrize("kind", ["force", "current", "increment", "position"])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_device_makes_of_a_value_the_force_that_it_was_made_of(kind, sign):
    law = Law(kind, 0.4, sign, 2.0, 0.0 if kind == "position" else 7.0)
    for before in (math.nan, 1.5):
        known = {"force": 3.25, "before": before, "felt": 2.25, "position": 12.0}
        value = eval(law.text("force", "before"), known)  # noqa: S307 (numbers and names of ours)
        assert law.force(value, before, 2.25, 12.0) == pytest.approx(3.25)
    assert law.at_rest(3.25) == pytest.approx(sign * 2.0 * 0.4 * 3.25)


@pytest.mark.parametrize(
    ("stiffness", "unit", "per_newton"), [("2000 N/m", "mm", 0.5), ("0.5 N/mm", "mm", 2.0), ("4", "", 0.25)]
)
def test_a_position_moves_by_the_inverse_of_the_stiffness_in_its_unit(stiffness, unit, per_newton):
    given = CommandMap("S.p", kind="position", stiffness=stiffness, feedback="S.q")
    assert law_of(given, unit, "map").per_newton == pytest.approx(per_newton)


@pytest.mark.parametrize("stiffness", ["0 N/mm", "-1 N/mm"])
def test_a_stiffness_that_is_not_positive_is_refused(stiffness):
    with pytest.raises(ConfigError, match="must be positive"):
        law_of(CommandMap("S.p", kind="position", stiffness=stiffness, feedback="S.q"), "mm", "map")


def test_each_new_force_goes_with_the_next_position_and_a_force_of_zero_opens():
    motion = CommandMap("S.f", motion="p", closed=(250, 251, 252), low=0.0, opened=3)
    one = Outgoing("S", motion=motion)
    asked = [(1.0, 10), (1.0, 10), (0.5, 11), (0.0, 0), (1.0, 12), (1.0, 13)]
    assert [one.position(*each) for each in asked] == [251, 251, 252, 3, 250, 251]


def test_a_hand_that_is_opened_by_a_motion_is_sent_its_least_force_with_it_and_nothing_is_counted(tmp_path):
    motion = 'motion = "Enable"\nclosed = [1]\nlow = 2.0'
    text = PLAIN_MAP.replace("set = { Enable = 1 }", motion)
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    for n, (force, sent, is_closed) in enumerate([(3.0, 3.0, 1), (0.0, 2.0, 0)]):
        (frame,) = hand.encode(command(force, stamp=n))
        values = DBC.decode_message(512, frame.data)
        assert (values["Grip"], values["Enable"]) == (pytest.approx(sent), is_closed)
    assert not hand.clipped


@pytest.mark.parametrize(("size", "missing", "count"), [(1, 2, 1), (2, 1, 1), (4, 0, 0)])
def test_a_short_frame_gives_the_values_that_it_holds_whole(hand, size, missing, count):
    whole = position(1)
    hand.decode_all(whole._replace(data=whole.data[:size]))
    assert hand.rejected["length"] == count
    (state,) = hand.decode_all(tip(1, stamp=2))
    assert [math.isnan(state.displacement), math.isnan(state.torque_z)].count(True) == missing


def test_a_sum_over_two_messages_is_missing_once_one_of_them_is_old(tmp_path):
    text = PLAIN_MAP.replace('signal = "Tip1.Fz"', 'signals = ["Tip1.Fz", "Pos1.Tz"]\nunit = "N"')
    text = text.replace('[fingers.thumb.torque_z]\nsignal = "Pos1.Tz"\n', "")
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    hand.decode_all(position(1, Tz=0.5))
    assert hand.decode_all(tip(1, stamp=100 * MS + 1, Fz=2.0))[0].normal_force == pytest.approx(2.5)
    assert math.isnan(hand.decode_all(tip(2, stamp=100 * MS + 2, Fz=2.0))[0].normal_force)


@pytest.mark.parametrize(
    "asked",
    ['poll = [{ identifier = 48, expects = "Tip1" }]', 'opening = [{ identifier = 48, data = "01" }]'],
)
def test_frames_that_come_answer_a_poll_and_break_the_silence_after_an_opening(tmp_path, asked):
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, f"{PLAIN_MAP}\n[device]\n{asked}\n")))
    sent = []
    for n in range(1, 31):
        sent += [frame for frame in hand.due(n * 100 * MS) if frame.arbitration_id == 48]
        assert hand.decode_all(tip(n, stamp=n * 100 * MS + MS))
    assert len(sent) == (30 if asked.startswith("poll") else 1)
    assert hand.rejected.total() == 0


def test_what_a_device_says_of_its_contact_is_reported_fifty_times_a_second(tmp_path):
    text = PLAIN_MAP.replace("thumb.torque_z]", 'thumb.device_grip_force]\nunit = "N"\nzero = -2.0')
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    hand.decode_all(position(1, Tz=0.5))
    (state,) = hand.decode_all(tip(1))
    reports = []
    for now in (0, 1, 20 * MS - 1, 20 * MS, 39 * MS, 40 * MS):
        messages, arrivals = [state], [0]
        hand.add_reports(messages, arrivals, now)
        assert arrivals == [0, now][: len(messages)]
        reports += messages[1:]
    assert [(one.finger, one.stamp, one.seq) for one in reports] == [
        ("thumb", n * 20 * MS, n) for n in range(3)
    ]
    assert [one.grip_force for one in reports] == pytest.approx([2.5] * 3)
    empty = []
    hand.add_reports(empty, [], 99 * MS)
    assert empty == []


@pytest.mark.parametrize(
    ("x", "y"), [(0.0, 1.0), (10.0, 2.0), (15.0, 1.75), (30.0, 1.0), (-0.1, math.nan), (30.1, math.nan)]
)
def test_a_table_holds_from_its_first_to_its_last_point(x, y):
    assert interpolated((0.0, 10.0, 30.0), (1.0, 2.0, 1.0), x) == pytest.approx(y, nan_ok=True)


def test_one_big_endian_signal_alone_is_packed():
    message = ForeignMessage("M", 1, 3, False, {"a": Signal("a", 7, 16, is_big_endian=True)})
    assert eval(packing(message, {"a": 0x1234})) == b"\x12\x34\x00"  # noqa: S307 (numbers alone)


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


def test_a_polar_force_beside_a_displacement_alone_gives_no_normal_force(tmp_path):
    text = POLAR_MAP.replace('[fingers.thumb.normal_force]\nsignal = "Tip1.Fz"\n', "")
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    (finger,) = hand.plan.fingers
    assert finger.measured == {"tangential_force_x", "tangential_force_y", "displacement", "torque_z"}
    hand.decode_all(tip(1, stamp=1, Fx=2.0, Fy=0.5))
    (state,) = hand.decode_all(position(2))
    assert math.isnan(state.normal_force)
    assert state.tangential_force_x == pytest.approx(2.0 * math.cos(0.5))


DIRECTION = '[fingers.thumb.tangential_direction]\nsignal = "Tip1.Fy"\nunit = "rad"'


def test_a_direction_needs_a_unit_or_what_gives_it_one(tmp_path):
    assert DIRECTION in POLAR_MAP
    counts = DIRECTION.replace("Tip1.Fy", "Pos1.Slip").replace('unit = "rad"', "")
    with pytest.raises(ConfigError, match="nothing says the unit of this angle"):
        open_plan(written(tmp_path, PLAIN_DBC, POLAR_MAP.replace(DIRECTION, counts)))
    for key in ('unit = "deg"', 'gain = "0.1 rad"', "table = [[0.0, 0.0], [1.0, 1.5]]"):
        open_plan(written(tmp_path, PLAIN_DBC, POLAR_MAP.replace(DIRECTION, counts + key)))


def test_half_of_a_polar_force_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="tangential_magnitude"):
        open_plan(written(tmp_path, PLAIN_DBC, POLAR_MAP.replace(DIRECTION, "")))


NORMAL = '[fingers.thumb.normal_force]\nsignal = "Tip1.Fz"\n'


def test_without_a_normal_force_the_plane_may_be_turned(tmp_path):
    turned = f"{PLAIN_MAP}\n[fingers.thumb]\nrotation = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]\n"
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, turned.replace(NORMAL, ""))))
    hand.decode_all(tip(1, stamp=1, Fx=2.0, Fy=0.5))
    (state,) = hand.decode_all(position(2))
    assert (state.tangential_force_x, state.tangential_force_y) == (pytest.approx(0.5), pytest.approx(-2.0))


def test_three_forces_alone_may_be_turned_any_way(tmp_path):
    rows = np.array([[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]]) / 3.0
    head, _, _ = PLAIN_MAP.partition("[fingers.thumb.displacement]")
    text = f"{head}\n[fingers.thumb]\nrotation = {rows.tolist()}\n"
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, text)))
    assert hand.plan.fingers[0].measured == {"normal_force", "tangential_force_x", "tangential_force_y"}
    (state,) = hand.decode_all(tip(1, Fz=3.0, Fx=2.0, Fy=0.5))
    found = state.tangential_force_x, state.tangential_force_y, state.normal_force
    assert found == pytest.approx(rows @ (2.0, 0.5, 3.0))


def test_a_trigger_that_is_no_message_is_refused_with_the_nearest(tmp_path):
    text = f'{PLAIN_MAP}\n[fingers.thumb]\ntrigger = "Tip2"\n'
    with pytest.raises(ConfigError, match=r"'Tip2' is no message of this finger; .* did you mean Tip1"):
        open_plan(written(tmp_path, PLAIN_DBC, text))


def test_a_polar_force_is_turned_like_its_components(tmp_path):
    turned = f"{POLAR_MAP}\n[fingers.thumb]\nrotation = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"
    hand = MappedCodec(open_plan(written(tmp_path, PLAIN_DBC, turned)))
    (state,) = hand.decode_all(tip(1, Fz=3.0, Fx=2.0, Fy=0.5))
    assert state.normal_force == pytest.approx(2.0 * math.cos(0.5))
    assert state.tangential_force_x == pytest.approx(2.0 * math.sin(0.5))
    assert state.tangential_force_y == pytest.approx(3.0)


TWO = """
[fingers.index.normal_force]
signal = "Pos1.Slip"
unit = "N"
[fingers.index.command]
signal = "Set1.THEIRS"
unit = "N"
"""
TWO_DBC = PLAIN_DBC.replace(
    ' SG_ Enable : 16|1@1+ (1,0) [0|1] "" Hand', ' SG_ Other : 16|16@1+ (0.01,0) [0|50] "N" Hand'
)


def test_two_fingers_cannot_be_commanded_by_one_signal_and_can_by_two_of_a_message(tmp_path):
    text = PLAIN_MAP.replace("set = { Enable = 1 }", "") + TWO
    with pytest.raises(
        ConfigError,
        match=r"fingers\.index\.command\]: Set1\.Grip already takes the command of another finger",
    ):
        MappedCodec(open_plan(written(tmp_path, TWO_DBC, text.replace("THEIRS", "Grip"))))
    hand = MappedCodec(open_plan(written(tmp_path, TWO_DBC, text.replace("THEIRS", "Other"))))
    assert hand.encode(command(2.0)) == []  # until all fingers of the message have theirs
    (frame,) = hand.encode(command(3.0, finger="index"))
    found = load(TWO_DBC).decode_message("Set1", frame.data)
    assert (found["Grip"], found["Other"]) == (2.0, 3.0)
