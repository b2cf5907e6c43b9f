"""Laws of the largest force that a map gives: of what command and sensor declare, never of mere bits."""

import pytest

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, written
from vegrip.cli.node import configured
from vegrip.transport.mapped.largest_force import LargestForce, largest_force
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import price, settings

GRIP = 'SG_ Grip : 0|16@1+ (0.01,0) [0|50] "N" Hand'
FORCE = 'SG_ Fz : 0|16@1- (0.01,0) [-300|300] "N" X'
COMMAND = 'signal = "Set1.Grip"'


def plan_of(folder, dbc=PLAIN_DBC, text=PLAIN_MAP):
    return open_plan(written(folder, dbc, text))


SENSOR = 'signal = "Tip1.Fz"'


def changed(folder, grip=GRIP, force=FORCE, command=COMMAND, sensor=SENSOR):
    text = PLAIN_MAP.replace(COMMAND, command).replace(SENSOR, sensor)
    return plan_of(folder, PLAIN_DBC.replace(GRIP, grip).replace(FORCE, force), text)


@pytest.mark.parametrize(
    ("change", "force"),
    [
        ({}, 50.0),
        ({"command": f"{COMMAND}\nhigh = 12.5"}, 12.5),
        ({"force": 'SG_ Fz : 0|16@1- (0.01,0) [-20|20] "N" X'}, 20.0),
        # counts in percent: 4 % make a newton
        (
            {"grip": 'SG_ Grip : 0|16@1+ (0.01,0) [0|100] "%" Hand', "command": f'{COMMAND}\ngain = "4 %/N"'},
            25.0,
        ),
        # theirs is negative when it closes
        ({"grip": 'SG_ Grip : 0|16@1- (0.01,0) [-8|0] "N" Hand', "command": f"{COMMAND}\nsign = -1"}, 8.0),
        # seven bits carry 12.7 N, whatever else is declared
        ({"grip": 'SG_ Grip : 0|7@1+ (0.1,0) [0|0] "N" Hand'}, 12.7),
        # a range in their unit says nothing of a command in counts
        ({"command": f'{COMMAND}\nraw = true\nunit = "N"'}, 60.0),
        # a larger force counts as a fault of the sensor
        ({"grip": 'SG_ Grip : 0|16@1+ (0.01,0) [0|200] "N" Hand'}, 60.0),
        # a sensor that is declared to feel pull alone says nothing of how hard we may press
        ({"force": 'SG_ Fz : 0|16@1- (0.01,0) [-30|0] "N" X'}, 50.0),
        # nor does one whose bits hold pull alone
        ({"force": 'SG_ Fz : 0|16@1+ (-0.01,0) [0|0] "N" X'}, 50.0),
        # a range of one value is none
        ({"force": 'SG_ Fz : 0|16@1- (0.01,0) [7|7] "N" X'}, 50.0),
        # seven bits read 12.7 N, and less with a zero of their own
        ({"force": 'SG_ Fz : 0|7@1+ (0.1,0) [0|0] "N" X'}, 12.7),
        ({"force": 'SG_ Fz : 0|7@1+ (0.1,-2) [0|0] "N" X'}, 10.7),
        ({"grip": 'SG_ Grip : 0|7@1+ (0.1,-2) [0|0] "N" Hand'}, 10.7),
        ({"force": 'SG_ Fz : 0|16@1- (0.01,-5) [-20|20] "N" X', "sensor": f"{SENSOR}\nzero = 5.0"}, 15.0),
        # a range of the sensor that is all its bits hold says nothing, one from zero on does
        ({"force": 'SG_ Fz : 0|12@1- (0.01,0) [-20.48|20.47] "N" X'}, 50.0),
        ({"force": 'SG_ Fz : 0|12@1- (0.01,0) [0|20.47] "N" X'}, 20.47),
        # little is little
        ({"grip": 'SG_ Grip : 0|16@1+ (0.01,0) [0|0.5] "N" Hand'}, 0.5),
        ({"grip": 'SG_ Grip : 0|1@1+ (0.5,0) [0|0] "N" Hand'}, 0.5),
        # the unit of the map goes before that of the database
        (
            {"grip": 'SG_ Grip : 0|16@1+ (0.01,0) [0|2] "N" Hand', "command": f'{COMMAND}\nunit = "kgf"'},
            19.6133,
        ),
        # of a sum, or through a table, no part says what the whole can be
        (
            {
                "force": 'SG_ Fz : 0|16@1- (0.01,0) [-20|20] "N" X',
                "sensor": 'signals = ["Tip1.Fz", "Pos1.Slip"]\nunit = "N"',
            },
            50.0,
        ),
        (
            {
                "force": 'SG_ Fz : 0|16@1- (0.01,0) [-20|20] "N" X',
                "sensor": f"{SENSOR}\ntable = [[0.0, 0.0], [20.0, 30.0]]",
            },
            50.0,
        ),
        # a position says nothing of force, the sensor does
        (
            {
                "command": f'{COMMAND}\nkind = "position"\nunit = "mm"\nstiffness = "2 N/mm"'
                '\nfeedback = "Pos1.Depth"',
                "force": 'SG_ Fz : 0|16@1- (0.01,0) [-30|30] "N" X',
            },
            30.0,
        ),
    ],
)
def test_the_largest_force_is_the_least_that_command_and_sensor_declare(tmp_path, change, force):
    plan = changed(tmp_path, **change)
    found = largest_force(plan)
    assert found is not None
    assert found.force == pytest.approx(force)
    assert settings(plan)["limits"]["max_force"] == found.force
    assert f"limits.max_force is {force:g} N where you state none: {found.why}" in price(plan)


@pytest.mark.parametrize(("most", "why"), [(60.0, "the command of thumb"), (60.01, "no greater force is")])
def test_what_is_not_believed_of_a_sensor_is_not_asked_for(tmp_path, most, why):
    found = largest_force(changed(tmp_path, grip=GRIP.replace("|50]", f"|{most}]")))
    assert found is not None
    assert found.force == 60.0
    assert found.why.startswith(why)


def test_the_largest_force_over_a_network_is_that_of_the_map(tmp_path):
    path = tmp_path / "hand.toml"
    path.write_text("""format = "json"
[fingers.thumb.normal_force]\nsignal = "state:f"
[fingers.thumb.command]\nsignal = "set:f"\nunit = "mN"\nhigh = 9000.0\n""")
    assert largest_force(open_plan(path)) == LargestForce(9.0, "the command of thumb carries no more")


@pytest.mark.parametrize("layout", ["16@1+ (0.01,0) [0|0]", "16@1+ (0.01,0) [0|655.35]", "4@1+ (1,0) [0|0]"])
def test_a_range_that_is_only_that_of_the_bits_says_nothing_of_a_hand(tmp_path, layout):
    plan = changed(tmp_path, f'SG_ Grip : 0|{layout} "N" Hand', 'SG_ Fz : 0|16@1- (0.01,0) [0|0] "N" X')
    assert largest_force(plan) is None
    assert "limits" not in settings(plan)
    assert any(
        "limits.max_force is 15 N where you state none: the map does not say" in one for one in price(plan)
    )


def test_what_the_map_states_goes_before_what_follows_from_it(tmp_path):
    text = f"{PLAIN_MAP}\n[limits]\nmax_force = 9.0\n[sensors]\ntangential_gain = 0.93\n"
    plan = plan_of(tmp_path, text=text)
    assert settings(plan)["limits"] == {"max_force": 9.0}
    assert settings(plan)["sensors"] == {"tangential_gain": 0.93}
    assert "limits.max_force is 9.0 N, as the map states" in price(plan)


def test_a_node_that_is_started_with_a_map_has_what_the_map_gives_and_its_own_goes_before(tmp_path):
    path = written(tmp_path, PLAIN_DBC, PLAIN_MAP)
    asked = [f"transport.map={path}"]
    assert configured("grasp_force", None, None, None, asked).parameters["limits"] == {"max_force": 50.0}
    asked.append("parameters.limits.max_force=9.0")
    assert configured("grasp_force", None, None, None, asked).parameters["limits"] == {"max_force": 9.0}


def test_without_a_command_no_limit_is_spoken_of(tmp_path):
    head, _, _ = PLAIN_MAP.partition("[fingers.thumb.command]")
    plan = plan_of(tmp_path, text=head)
    assert largest_force(plan) is None
    assert not any("max_force" in sentence for sentence in price(plan))
