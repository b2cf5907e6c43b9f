"""Laws of what is said, and set, for what a hand does not tell."""

import math

import pytest
from scipy.stats import norm

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, written
from vegrip.grip.safety import WatchdogSettings
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import price, settings


def said(tmp_path, text):
    return " | ".join(price(open_plan(written(tmp_path, PLAIN_DBC, text))))


def test_each_thing_that_is_missing_is_said_with_its_price(tmp_path):
    told = said(tmp_path, PLAIN_MAP)
    assert "thumb: friction stays as in the model file unless a slip shows" in told
    assert "Pos1: no counter" in told
    assert "Pos1: no checksum" in told
    assert "Tip1: no" not in told
    assert "what it does when they stop is not known" in told
    assert "Grip" not in told


@pytest.mark.parametrize(
    ("gone", "sentence"),
    [
        ('[fingers.thumb.tangential_force_x]\nsignal = "Tip1.Fx"\n', "no slip margin and no grip command"),
        ('[fingers.thumb.torque_z]\nsignal = "Pos1.Tz"\n', "torque_z is not measured and counts as zero"),
        (
            '[fingers.thumb.displacement]\nsignal = "Pos1.Depth"\n',
            "displacement is not measured beside",
        ),
        ("rate = 200.0\n", "the rate of states is not stated"),
        ("set = { Enable = 1 }", "Set1: sent as zero, since the map does not say otherwise: Enable"),
    ],
)
def test_what_is_taken_out_of_the_map_is_told(tmp_path, gone, sentence):
    assert gone in PLAIN_MAP
    assert sentence not in said(tmp_path, PLAIN_MAP)
    assert sentence in said(tmp_path, PLAIN_MAP.replace(gone, ""))


def test_a_stated_load_gives_a_margin_and_says_that_it_is_for_that_load(tmp_path):
    text = PLAIN_MAP.replace(
        'tangential_force_x]\nsignal = "Tip1.Fx"', 'tangential_force_x]\nstated = "1.5 N"'
    )
    told = said(tmp_path, text)
    assert "no slip margin" not in told
    assert "tangential_force_x is stated as 1.5 N, not measured" in told


def test_a_sensor_whose_steps_hide_its_noise_may_stand_still_for_half_an_hour(tmp_path):
    text = PLAIN_MAP.replace('"Tip1.Fz"', '"Tip1.Fz"\nnoise = 0.002')  # a step has 0.01 N
    asked = settings(open_plan(written(tmp_path, PLAIN_DBC, text)))
    assert asked["watchdog"]["force_frozen_after"] == 1800.0


CHANNELS = ("normal_force", "displacement", "torque_z", "temperature", "slip")
COARSE = {  # signal -> its step and the noise that is measured in front of it, in SI
    "Tip1.Fz": (0.01, 0.004), "Tip1.Fx": (0.01, 0.0035), "Tip1.Fy": (0.01, 0.0032),
    "Pos1.Depth": (1e-6, 3.5e-7), "Pos1.Tz": (1e-4, 3.3e-5),
}  # fmt: skip


@pytest.mark.parametrize(
    ("rate", "counted"),
    [(200.0, ("Tip1",)), (41.0, ("Tip1",)), (40.0, ("Tip1", "Pos1")), (39.0, ("Tip1", "Pos1"))],
)
def test_what_is_held_between_two_of_its_messages_says_nothing_of_a_sensor_that_stands_still(
    tmp_path, rate, counted
):
    """Where more than four states may be of the age of one message; the others all repeat themselves."""
    text = PLAIN_MAP.replace("rate = 200.0", f"rate = {rate}")
    chance = 1.0
    for signal, (step, noise) in COARSE.items():
        text = text.replace(f'"{signal}"', f'"{signal}"\nnoise = {noise}')
        if signal.startswith(counted):
            chance *= 1.0 - 2.0 * norm.sf(0.5 * step, scale=math.sqrt(noise**2 - step**2 / 12.0))
    told = settings(open_plan(written(tmp_path, PLAIN_DBC, text)))["watchdog"]["frozen_after"]
    assert told == pytest.approx(
        math.log(WatchdogSettings().frozen_chance) / math.log(chance) / rate, abs=1e-3
    )
    assert told == round(told, 3)


def test_a_force_that_is_turned_stands_still_when_all_stand_that_it_is_made_of(tmp_path):
    text = f"{PLAIN_MAP}\n[fingers.thumb]\nrotation = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"
    chance = 1.0
    for signal in ("Tip1.Fz", "Tip1.Fx", "Tip1.Fy"):
        step, noise = COARSE[signal]
        text = text.replace(f'"{signal}"', f'"{signal}"\nnoise = {noise}')
        chance *= 1.0 - 2.0 * norm.sf(0.5 * step, scale=math.sqrt(noise**2 - step**2 / 12.0))
    found = settings(open_plan(written(tmp_path, PLAIN_DBC, text.replace("200.0", "20.0"))))["watchdog"]
    run = math.log(WatchdogSettings().frozen_chance) / math.log(chance) / 20.0
    assert found["force_frozen_after"] == pytest.approx(run, abs=1e-3)


REAL_DBC = PLAIN_DBC.replace("Tip1: 8", "Tip1: 12").replace("Fz : 0|16@1- (0.01,", "Fz : 64|32@1- (0.5,")
REAL_DBC += "SIG_VALTYPE_ 256 Fz : 1;\n"


@pytest.mark.parametrize(
    ("dbc", "text"),
    [
        (REAL_DBC, PLAIN_MAP),
        (PLAIN_DBC, PLAIN_MAP.replace('"Tip1.Fz"', '"Tip1.Fz"\ntable = [[0.0, 0.0], [9.0, 9.0]]')),
        (PLAIN_DBC, 'database = "plain.dbc"\n[fingers.thumb.command]\nsignal = "Set1.Grip"\n'),
    ],
    ids=["float", "table", "drive"],
)
def test_where_no_steps_are_known_the_watchdog_stays_as_it_is(tmp_path, dbc, text):
    text = text.replace('"Tip1.Fz"', '"Tip1.Fz"\nnoise = 0.0029')
    assert "watchdog" not in settings(open_plan(written(tmp_path, dbc, text)))


def test_the_noise_of_taxels_is_that_of_the_normal_force(tmp_path):
    text = PLAIN_MAP.replace(
        'normal_force]\nsignal = "Tip1.Fz"', 'taxels]\nnormal = ["Tip1.Fz"]\nnoise = 0.002'
    )
    found = settings(open_plan(written(tmp_path, PLAIN_DBC, text)))
    assert found["noise"] == {"normal_force": 0.002}
    assert found["watchdog"]["force_frozen_after"] == 1800.0


@pytest.mark.parametrize(
    ("keys", "is_told"),
    [('unit = "A"\ngain = "2 N/A"', True), ('unit = "A"\ngain = "2 N/A"\nnoise = 0.1', False), ("", False)],
)
def test_a_force_made_of_another_quantity_wants_its_noise_stated(tmp_path, keys, is_told):
    told = said(tmp_path, PLAIN_MAP.replace('"Tip1.Fz"', f'"Tip1.Fz"\n{keys}'))
    assert ("normal_force is made from another quantity and has no 'noise'" in told) == is_told


@pytest.mark.parametrize(
    ("rate", "late", "silent", "time_out"),
    [(100.0, None, None, None), (99.0, 10, None, None), (60.0, 17, None, None), (35.0, 29, 86, 0.0857)],
)
def test_below_100_states_a_second_a_slip_is_seen_late_and_below_60_silence_too(
    tmp_path, rate, late, silent, time_out
):
    text = PLAIN_MAP.replace("rate = 200.0", f"rate = {rate}")
    told = said(tmp_path, text)
    assert ("states come at" in told) == (late is not None)
    assert f"states come at {rate:g} Hz: a slip is seen up to {late} ms later" in told or late is None
    assert ("counts as silent after" in told) == (silent is not None)
    assert f"counts as silent after {silent} ms instead of 50 ms" in told or silent is None
    found = settings(open_plan(written(tmp_path, PLAIN_DBC, text))).get("watchdog", {})
    assert found.get("time_out") == time_out


def test_of_several_fingers_those_without_a_command_are_named_and_the_others_priced(tmp_path):
    text = PLAIN_MAP + 'kind = "increment"\n[fingers.index.normal_force]\nsignal = "Pos1.Slip"\nunit = "N"\n'
    told = said(tmp_path, text)
    assert "index: no command is mapped" in told
    assert "the last one is repeated every 20 ms" in told
    assert "thumb: commands are increments" in told


@pytest.mark.parametrize(("count", "named"), [(4, "M0, M1, M2, M3: no"), (5, "M0, M1, M2 and 2 more: no")])
def test_of_more_than_four_messages_three_are_named(tmp_path, count, named):
    dbc = 'VERSION ""\nBU_: X\n'
    dbc += "".join(f'BO_ {n + 1} M{n}: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n' for n in range(count))
    text = 'database = "plain.dbc"\n'
    for n, channel in enumerate(CHANNELS[:count]):
        text += f'[fingers.f.{channel}]\nsignal = "M{n}.S"\nraw = true\n'
    assert named in " | ".join(price(open_plan(written(tmp_path, dbc, text))))


def test_a_slow_hand_has_a_longer_time_out_and_its_noise(tmp_path):
    text = PLAIN_MAP.replace("rate = 200.0", "rate = 40.0").replace('"Tip1.Fz"', '"Tip1.Fz"\nnoise = 0.03')
    assert "states come at 40 Hz" in said(tmp_path, text)
    path = written(tmp_path, PLAIN_DBC, text)
    asked = {"noise": {"normal_force": 0.03}, "watchdog": {"time_out": 0.075}}
    limits = {"limits": {"max_force": 50.0}}
    assert settings(open_plan(path)) == asked | limits
    assert settings(open_plan(written(tmp_path, PLAIN_DBC, PLAIN_MAP))) == limits


SECOND = """
[fingers.{}.normal_force]
signal = "Pos1.Slip"
unit = "N"
noise = {}
"""


@pytest.mark.parametrize(("first", "second"), [(0.02, 0.03), (0.03, 0.02)])
@pytest.mark.parametrize("is_of_taxels", [False, True])
def test_of_several_fingers_the_largest_noise_serves_all(tmp_path, first, second, is_of_taxels):
    text = PLAIN_MAP.replace('"Tip1.Fz"', f'"Tip1.Fz"\nnoise = {first}')
    if is_of_taxels:
        own = f'normal_force]\nsignal = "Tip1.Fz"\nnoise = {first}'
        text = text.replace(own, f'taxels]\nnormal = ["Tip1.Fz"]\nnoise = {first}')
    before, place, after = text.partition("[fingers.thumb.")
    other = SECOND.format("index", second)
    text = before + other + place + after if is_of_taxels else text + other
    assert settings(open_plan(written(tmp_path, PLAIN_DBC, text)))["noise"] == {"normal_force": 0.03}


def test_of_a_command_that_adds_to_the_one_before_it_is_said_what_its_loss_does(tmp_path):
    told = price(open_plan(written(tmp_path, PLAIN_DBC, PLAIN_MAP + 'kind = "increment"\n')))
    flaw = "one that is lost is missing from the grip until the measured force says so"
    assert [one for one in told if "increment" in one] == [f"thumb: commands are increments: {flaw}"]


@pytest.mark.parametrize(("unit", "factor"), [("N", 1.0), ("mN", 1e-3)])
def test_a_number_in_a_text_comes_in_no_steps(tmp_path, unit, factor):
    """Whatever its unit: what stands in no place of a frame is as fine as it is sent."""
    (tmp_path / "hand.toml").write_text(
        f'format = "json"\nrate = 200.0\n[fingers.a.normal_force]\nsignal = "state:f"\nunit = "{unit}"\n'
    )
    assert "watchdog" not in settings(open_plan(tmp_path / "hand.toml"))


def run_of(noise, step, rate):
    """Return for how long a channel repeats itself by chance once in ten million times [s]."""
    live = math.sqrt(noise**2 - step**2 / 12.0)
    return math.log(1e-7) / math.log(math.erf(0.5 * step / (math.sqrt(2.0) * live))) / rate


def test_a_hand_that_states_no_rate_counts_as_one_of_three_states_in_the_time_out(tmp_path):
    text = PLAIN_MAP.replace("rate = 200.0\n", "").replace('"Tip1.Fz"', '"Tip1.Fz"\nnoise = 0.0035')
    found = settings(open_plan(written(tmp_path, PLAIN_DBC, text)))["watchdog"]["force_frozen_after"]
    assert found == pytest.approx(run_of(0.0035, 0.01, 60.0), abs=1e-3)


def test_a_force_of_which_no_noise_is_stated_has_that_of_a_hundredth_of_a_newton(tmp_path):
    dbc = PLAIN_DBC.replace("Fz : 0|16@1- (0.01,", "Fz : 0|16@1- (0.03,")
    found = settings(open_plan(written(tmp_path, dbc, PLAIN_MAP)))["watchdog"]["force_frozen_after"]
    assert found == pytest.approx(run_of(0.01, 0.03, 200.0), abs=1e-3)
