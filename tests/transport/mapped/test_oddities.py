"""A made-up hand with every oddity at once: what each does to the numbers is worked out by hand."""

import math

import pytest

from tests.transport.maps.hands import load, written
from vegrip.errors import ConfigError
from vegrip.messages import ForceCommand, Reason
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.database import EXTENDED

MS = 1_000_000
TAXELS = "".join(f' SG_ T{n} : {8 * n}|8@1+ (1,0) [0|0] "" X\n' for n in range(4))
SHEARS = "".join(
    f' SG_ {a}{n} : {8 * (n + 4 * (a == "Y"))}|8@1- (1,0) [0|0] "" X\n' for a in "XY" for n in range(4)
)
DBC = f"""VERSION ""
NS_ :
BS_:
BU_: X
BO_ 2566844416 Both: 8 X
 SG_ Mux M : 0|4@1+ (1,0) [0|0] "" X
 SG_ FzA m1 : 8|12@1- (0.01,0) [0|0] "kgf" X
 SG_ FxA m1 : 20|12@1- (10,0) [0|0] "mN" X
 SG_ FyA m1 : 32|12@1- (10,0) [0|0] "mN" X
 SG_ FzB m2 : 15|12@0- (1,0) [0|0] "" X
 SG_ Current m3 : 8|16@1- (1,0) [0|0] "mA" X
BO_ 600 Joints: 8 X
 SG_ qA : 0|16@1- (0.1,0) [0|0] "deg" X
 SG_ q1 : 16|16@1- (0.1,0) [0|0] "deg" X
 SG_ q2 : 32|16@1- (0.1,0) [0|0] "deg" X
 SG_ Temp : 48|16@1+ (0.5,-40) [0|0] "degF" X
BO_ 601 Pad: 4 X
{TAXELS}BO_ 602 PadShear: 8 X
{SHEARS}BO_ 603 Real: 12 X
 SG_ F : 0|32@1- (1,0) [0|0] "N" X
 SG_ Touch : 32|32@1- (1,0) [0|0] "" X
BO_ 700 Cmd: 8 X
 SG_ Which M : 0|4@1+ (1,0) [0|0] "" X
 SG_ Step m1 : 8|16@1- (1,0) [-300|300] "mN" X
 SG_ Place m2 : 8|16@1- (0.01,0) [-300|300] "mm" X
 SG_ Amps m3 : 8|16@1- (1,0) [-2000|2000] "mA" X
SIG_VALTYPE_ 603 F : 1;
SIG_VALTYPE_ 603 Touch : 1;
"""
MAP = """
database = "plain.dbc"

[fingers.a]
trigger = "Both.FzA"
axes = ["z", "x", "y"]                      # ours from theirs
[fingers.a.normal_force]
signal = "Both.FzA"
invalid = [2047]
zero_is_measured = true
[fingers.a.tangential_force_x]
signal = "Both.FxA"
zero_is_measured = true
[fingers.a.tangential_force_y]
signal = "Both.FyA"
zero_is_measured = true
[fingers.a.displacement]
signal = "Joints.qA"
table = [[0.0, 0.0], [10.0, 1.0], [30.0, 1.5]]
table_unit = "mm"
[fingers.a.temperature]
signal = "Joints.Temp"
[fingers.a.command]
signal = "Cmd.Step"
kind = "increment"

[fingers.b]
[fingers.b.normal_force]
signal = "Both.FzB"
raw = true
unit = "N"
scale = -0.02
zero = 1.5
[fingers.b.displacement]
signals = ["Joints.q1", "Joints.q2"]
weights = [1.0, 0.5]
gain = "40 mm/rad"
zero = 20.0
[fingers.b.command]
signal = "Cmd.Place"
kind = "position"
stiffness = "2 N/mm"
feedback = "Real.Touch"
sign = -1

[fingers.c.normal_force]
signal = "Both.Current"
gain = "2.5 N/A"
[fingers.c.command]
signal = "Cmd.Amps"
kind = "current"
gain = "0.4 A/N"

[fingers.d]
trigger = "Pad"
[fingers.d.taxels]
normal = ["Pad.T{0..3}"]
x = ["PadShear.X{0..3}"]
y = ["PadShear.Y{0..3}"]
positions = [[-2, -2], [2, -2], [-2, 2], [2, 2]]
unit = "mN"
scale = 10.0
[fingers.d.slip]
signal = "Real.F"
above = 0.5
"""


@pytest.fixture
def codec(tmp_path):
    return MappedCodec(open_plan(written(tmp_path, DBC, MAP)))


DATABASE = load(DBC)


def frame(name, stamp=1, **values):
    message = DATABASE.get_message_by_name(name)
    signals = {s.name: 0 for s in message.signals if not s.multiplexer_ids} | values
    data = DATABASE.encode_message(name, signals, strict=False)
    identifier = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
    return Frame(identifier, data, False, stamp)


def test_pages_of_a_29_bit_message_make_states_of_different_fingers(codec):
    page = frame("Both", Mux=1, FzA=1.0, FxA=500, FyA=-300)
    assert page.arbitration_id & EXTENDED
    (a,) = codec.decode_all(page)
    assert a.finger == "a"
    (c,) = codec.decode_all(frame("Both", Mux=3, Current=800))
    assert (c.finger, c.normal_force) == ("c", pytest.approx(2.0))
    assert not codec.decode_all(page._replace(data=b"\x07" + page.data[1:]))  # a page that nobody declared


def test_axes_turn_the_forces_and_units_become_si(codec):
    (a,) = codec.decode_all(frame("Both", Mux=1, FzA=1.0, FxA=500, FyA=-300))
    assert a.tangential_force_x == pytest.approx(9.80665)  # our x is their z
    assert a.tangential_force_y == pytest.approx(0.5)
    assert a.normal_force == pytest.approx(-0.3)


def test_a_raw_value_that_says_so_is_missing_with_all_that_it_makes(codec):
    (a,) = codec.decode_all(frame("Both", Mux=1, FzA=20.47, FxA=500, FyA=-300))
    assert math.isnan(a.tangential_force_x)
    assert a.normal_force == pytest.approx(-0.3)


@pytest.mark.parametrize(
    ("angle", "depth"), [(0.0, 0.0), (5.0, 5e-4), (10.0, 1e-3), (20.0, 1.25e-3), (31.0, math.nan)]
)
def test_a_table_makes_indentation_of_an_angle_and_ends_where_it_ends(codec, angle, depth):
    codec.decode_all(frame("Joints", qA=1.0))
    codec.decode_all(frame("Joints", stamp=2, qA=angle, Temp=68.0))
    codec.decode_all(frame("Both", stamp=2, Mux=1, FzA=1.0, FxA=500, FyA=-300))
    (a,) = codec.decode_all(frame("Both", stamp=3, Mux=1, FzA=1.0, FxA=500, FyA=-300))
    assert a.temperature == pytest.approx(20.0)
    if angle:
        assert a.displacement == pytest.approx(depth, nan_ok=True)


def test_raw_counts_with_their_own_scale_and_zero(codec):
    (b,) = codec.decode_all(frame("Both", Mux=2, FzB=-200))
    assert b.normal_force == pytest.approx(-0.02 * -200 - 1.5)


def test_a_row_of_a_jacobian_makes_indentation_of_two_angles(codec):
    codec.decode_all(frame("Joints", q1=15.0, q2=20.0))
    (b,) = codec.decode_all(frame("Both", Mux=2, FzB=-200))
    assert b.displacement == pytest.approx(0.04 * math.radians(15.0 + 10.0 - 20.0))


def test_taxels_give_force_and_torque_about_the_centre_of_pressure(codec):
    codec.decode_all(frame("PadShear", X0=1, X1=1, X2=-1, X3=-1, Y0=1, Y1=1, Y2=1, Y3=1))
    codec.decode_all(frame("Real", F=0.7, Touch=0.0))
    (d,) = codec.decode_all(frame("Pad", T0=10, T1=30, T2=10, T3=30))
    assert d.normal_force == pytest.approx(0.8)
    assert d.tangential_force_x == pytest.approx(0.0, abs=1e-12)
    assert d.tangential_force_y == pytest.approx(0.04)
    # about the middle: y_i fx_i gives 8e-3 * 1e-2 ... and the centre of pressure is 1 mm to the right of it
    about_middle = sum(
        x * 0.01 - y * fx for x, y, fx in ((-2, -2, 0.01), (2, -2, 0.01), (-2, 2, -0.01), (2, 2, -0.01))
    )
    assert d.torque_z == pytest.approx(1e-3 * (about_middle - 1.0 * 0.04))
    assert d.slip == 1.0


def test_a_shear_that_was_always_zero_is_missing(codec):
    codec.decode_all(frame("PadShear", Y0=1))
    (d,) = codec.decode_all(frame("Pad", T0=1))
    assert math.isnan(d.tangential_force_x)
    assert d.tangential_force_y == pytest.approx(0.01)


@pytest.mark.parametrize("gone", ["x", "y", "positions"])
def test_a_torque_of_taxels_needs_both_shears_and_the_positions(tmp_path, gone):
    text = "".join(line for line in MAP.splitlines(keepends=True) if not line.startswith(f"{gone} = ["))
    finger = open_plan(written(tmp_path, DBC, text)).fingers[-1]
    assert (finger.name, finger.torque) == ("d", None)
    assert "torque_z" not in finger.measured


def test_a_torque_of_taxels_and_of_a_signal_is_refused(tmp_path):
    text = f'{MAP}[fingers.d.torque_z]\nsignal = "Real.Touch"\nunit = "N*m"\n'
    with pytest.raises(ConfigError, match="torque_z comes from the taxels and from a signal"):
        open_plan(written(tmp_path, DBC, text))


ALONE = 'database = "plain.dbc"\n[fingers.a.normal_force]\n'


def test_a_state_is_complete_with_the_page_of_the_normal_force_whatever_stands_first_in_the_map(tmp_path):
    text = f"""{ALONE.replace("normal_force", "torque_z")}signal = "Both.Current"\nraw = true\nunit = "N*m"
[fingers.a.normal_force]\nsignal = "Both.FzA"\n"""
    hand = MappedCodec(open_plan(written(tmp_path, DBC, text)))
    assert hand.decode_all(frame("Both", Mux=3, Current=800)) == []
    (state,) = hand.decode_all(frame("Both", stamp=2, Mux=1, FzA=1.0, FxA=0, FyA=0))
    assert (state.normal_force, state.torque_z) == (pytest.approx(9.80665), 800.0)


def test_beside_a_stated_force_the_first_measured_channel_completes_a_state(tmp_path):
    text = f'{ALONE}stated = "2 N"\n[fingers.a.displacement]\nsignal = "Joints.qA"\ngain = "1 mm/deg"\n'
    hand = MappedCodec(open_plan(written(tmp_path, DBC, text)))
    (state,) = hand.decode_all(frame("Joints", qA=1.5))
    assert (state.normal_force, state.displacement) == (2.0, pytest.approx(1.5e-3))


def test_a_table_in_a_unit_with_a_zero_of_its_own_is_brought_to_si(tmp_path):
    text = f"""{ALONE}signal = "Both.FzA"\n[fingers.a.temperature]\nsignal = "Joints.Temp"
table = [[32.0, 32.0], [212.0, 212.0]]\ntable_unit = "degF"\n"""
    hand = MappedCodec(open_plan(written(tmp_path, DBC, text)))
    hand.decode_all(frame("Joints", Temp=68.0))
    (state,) = hand.decode_all(frame("Both", stamp=2, Mux=1, FzA=1.0, FxA=0, FyA=0))
    assert state.temperature == pytest.approx(20.0)


@pytest.mark.parametrize(("unit", "newtons"), [("", 1.0), ('unit = "mN"\n', 1e-3)])
def test_a_raw_count_is_newtons_unless_its_unit_is_stated(tmp_path, unit, newtons):
    text = f'{ALONE}signal = "Both.FzA"\nraw = true\nscale = 0.5\n{unit}'
    (state,) = MappedCodec(open_plan(written(tmp_path, DBC, text))).decode_all(
        frame("Both", Mux=1, FzA=-2.0, FxA=0, FyA=0)
    )
    assert state.normal_force == pytest.approx(-100.0 * newtons)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_zero_of_each_taxel_is_a_force_in_their_unit_and_taken_off_after_the_scale(tmp_path, sign):
    text = MAP.replace("scale = 10.0", f"scale = 10.0\nzero = 30.0\nsign = {sign}")
    hand = MappedCodec(open_plan(written(tmp_path, DBC, text)))
    hand.decode_all(frame("PadShear", X0=1, Y0=1))
    (d,) = hand.decode_all(frame("Pad", T0=5, T1=7, T2=11, T3=13))
    assert d.normal_force == pytest.approx(sign * sum(10.0 * t - 30.0 for t in (5, 7, 11, 13)) * 1e-3)
    assert d.tangential_force_x == pytest.approx(0.01)  # a shear has none


def test_a_single_taxel_without_a_stated_unit_has_that_of_its_signal(tmp_path):
    text = MAP.partition("[fingers.d]")[0] + '[fingers.d.taxels]\nnormal = ["Real.F"]\n'
    hand = MappedCodec(open_plan(written(tmp_path, DBC, text)))
    (d,) = hand.decode_all(frame("Real", F=0.25))
    assert d.normal_force == pytest.approx(0.25)


def command(finger, force, seq=0):
    return ForceCommand(seq * MS, finger, seq, force, 0.0, Reason.HOLD, (seq + 100) * MS)


def decoded(frames):
    (one,) = frames
    return DATABASE.decode_message(one.arbitration_id, one.data)


def test_increments_add_up_to_the_force_and_nothing_is_added_by_a_repeat(codec):
    codec.decode_all(frame("Both", Mux=1, FzA=0.0, FxA=0, FyA=2000))  # our normal force: 2 N
    steps = [
        decoded(codec.encode(command("a", force, seq)))["Step"] for seq, force in enumerate((2.1, 2.15, 2.0))
    ]
    assert steps == [100, 50, -150]
    assert decoded(codec.encoder.due(30 * MS))["Step"] == 0


def test_a_position_follows_the_measured_force_by_the_stiffness(codec):
    codec.decode_all(frame("Both", Mux=2, FzB=-200))  # 2.5 N
    assert codec.encode(command("b", 3.5)) == []  # where it stands is not known
    codec.decode_all(frame("Real", Touch=12.0))
    assert decoded(codec.encode(command("b", 3.5, 1))) == {"Which": 2, "Place": pytest.approx(12.0 - 0.5)}


def test_a_current_has_its_gain_and_ends_at_its_range(codec):
    assert decoded(codec.encode(command("c", 3.0)))["Amps"] == 1200
    assert decoded(codec.encode(command("c", 30.0, 1)))["Amps"] == 2000
    assert codec.clipped == {"c": 1}


def test_what_no_finger_sets_is_named_of_every_page_of_a_message(tmp_path):
    extra = DBC.replace(" SG_ Place m2", ' SG_ Extra m1 : 24|8@1+ (1,0) [0|0] "" X\n SG_ Place m2')
    hand = MappedCodec(open_plan(written(tmp_path, extra, MAP)))
    assert hand.encoder.unset == {"Cmd": ["Extra"]}


def test_a_normal_force_made_of_what_is_not_mapped_is_refused(tmp_path):
    text = MAP.replace('[fingers.a.tangential_force_y]\nsignal = "Both.FyA"\nzero_is_measured = true\n', "")
    with pytest.raises(ConfigError, match="map all three forces before turning them"):
        open_plan(written(tmp_path, DBC, text))
