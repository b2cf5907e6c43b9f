"""What the live page shows, worked out without a browser."""

import json
import math
import time
import urllib.error
import urllib.request
from contextlib import closing
from dataclasses import replace

import pytest

from vegrip.clock import NS
from vegrip.messages import (
    KNOWN,
    PROBED,
    Condition,
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    LearnedParameter,
    Lifecycle,
    ModelHealth,
    NodeStatus,
    Reason,
    SlipMargin,
)
from vegrip.runtime.monitor.board import Board
from vegrip.runtime.monitor.rows import Present
from vegrip.web.live.alarms import ALARM_HOLD_S, CONDITIONS, REASONS, Alarms, Level, alarms_of, states_of
from vegrip.web.live.finger_view import finger_view, limit_curve
from vegrip.web.live.stream import FedPage
from vegrip.web.live.view import COLUMN_COUNT, COLUMN_NAMES, Columns, LiveView

NODE = "/grasp_force"


def sure(value: float, std: float = 0.01) -> Estimate:
    return Estimate(value, std, True, 0.0)


CONTACT = ContactEstimate(
    0,
    "thumb",
    0,
    in_contact=True,
    indentation=sure(1e-3),
    normal_force=sure(2.0, 0.1),
    contact_radius=sure(4e-3, 1e-4),
    pressure_exponent=sure(2.0),
    friction_coefficient=sure(0.8),
    limit_force=sure(1.6, 0.2),
    limit_torque=sure(3.8e-3),
    limit_radius=sure(1.6),
)
MARGIN = SlipMargin(0, "thumb", 0, sure(0.5), 0.2, 0.95, 0.4, math.inf, math.inf)
COMMAND = ForceCommand(0, "thumb", 0, 2.0, 0.1, Reason.HOLD, NS)
HEALTH = ModelHealth(0, "thumb", 0, Condition.OK, 1.0, consistent=True)
STATE = FingertipState(0, "thumb", 0, 2.0, 0.3, 0.4, 1e-3)


def wanted(node: str) -> float | None:
    return 0.15 if node == NODE else None


@pytest.fixture
def view() -> LiveView:
    view = LiveView(Board(0, ("thumb",)))
    view.attend([Present(NODE, 1, 1.0, ("thumb",))], 0)
    view.receive(NodeStatus(0, NODE, 0, Lifecycle.ACTIVE, 500.0, 500.0), 0, NODE)
    for message in (CONTACT, MARGIN, COMMAND, HEALTH, STATE):
        view.receive(message, 0, NODE)
    view.board.refresh(0)
    return view


def thumb(view: LiveView, now: int) -> dict:
    return view.snapshot(now, wanted)["fingers"]["thumb"]


def test_a_finger_is_shown_with_its_margin_command_and_load(view: LiveView) -> None:
    shown = thumb(view, 0)
    assert shown["margin"]["value"] == 0.5
    assert shown["margin"]["bound"] == 0.2
    assert shown["margin"]["wanted"] == 0.15
    assert shown["margin"]["never"]
    assert shown["command"]["words"] == "holds: the force suffices"
    assert shown["load"] == {"force": 0.5, "torque": 1e-3}


def test_nothing_of_a_finger_is_shown_when_it_is_older_than_the_monitor_allows(view: LiveView) -> None:
    shown = thumb(view, round(0.51 * NS))
    assert not shown["fresh"]
    assert shown["age"] == pytest.approx(0.51)
    assert [shown[name] for name in ("margin", "command", "contact", "surface", "load")] == [None] * 5


def test_the_sure_part_of_the_surface_is_where_the_bound_of_the_margin_puts_it(view: LiveView) -> None:
    shown = thumb(view, 0)
    load = 1.0 - shown["margin"]["value"]  # over the limit
    assert 1.0 - load / shown["surface"]["sure"] == pytest.approx(shown["margin"]["bound"], abs=2e-3)


def test_without_load_the_sure_part_comes_from_the_std_of_the_limit(view: LiveView) -> None:
    view.receive(replace(MARGIN, margin=sure(1.0), lower_bound=1.0), 0, NODE)
    assert thumb(view, 0)["surface"]["sure"] == pytest.approx(math.exp(-1.645 * 0.2 / 1.6), abs=2e-3)


def test_in_the_air_there_is_no_surface(view: LiveView) -> None:
    view.receive(replace(CONTACT, in_contact=False), 0, NODE)
    assert thumb(view, 0)["surface"] is None
    assert thumb(view, 0)["contact"]["peak_pressure"] is None


def test_a_snapshot_is_json_whatever_is_not_a_number(view: LiveView) -> None:
    view.receive(ContactEstimate(0, "thumb", 1), 0, NODE)
    view.receive(SlipMargin(0, "thumb", 1), 0, NODE)
    view.receive(replace(STATE, tangential_force_x=math.nan), 0, NODE)
    view.receive(LearnedParameter(0, "thumb", 0, "K"), 0, NODE)
    view.receive(NodeStatus(0, NODE, 1, Lifecycle.ACTIVE), 0, NODE)
    json.dumps(view.snapshot(0, wanted), allow_nan=False)


def test_what_a_node_received_is_no_sign_that_it_lives(view: LiveView) -> None:
    view.receive(STATE, 5 * NS, NODE)
    assert view.snapshot(5 * NS, wanted)["nodes"][NODE]["age"] == 5.0


def test_learned_parameters_of_a_node_that_has_gone_are_not_shown(view: LiveView) -> None:
    view.receive(LearnedParameter(0, "thumb", 0, "K", sure(2.0), sure(2.0), 3.0), 0, NODE)
    assert [one["symbol"] for one in thumb(view, 0)["learned"]] == ["K"]
    view.attend([], NS)
    for i in range(20):
        shown = thumb(view, NS + i * NS // 10)
    assert shown["learned"] == []


def test_a_column_keeps_the_peaks_of_what_it_is_made_of() -> None:
    columns = Columns()
    for value in (0.5, 0.1, 0.9, 0.4):
        columns.add("margin", value)
    at = 3 * COLUMN_NAMES.index("margin")
    assert columns.close()[at : at + 3] == [0.1, 0.9, 0.4]
    assert columns.close()[at : at + 3] == [None] * 3


def test_columns_do_not_grow_beyond_half_a_minute() -> None:
    columns = Columns()
    for _ in range(3 * COLUMN_COUNT):
        columns.close()
    assert len(columns.closed) == COLUMN_COUNT


def test_the_curve_goes_from_pure_torque_to_pure_force_and_bulges() -> None:
    for exponent in (1.0, 2.0, 4.0, math.nan, 1e9, -1.0):
        curve = limit_curve(exponent)
        assert curve[0] == (0.0, 1.0)
        assert curve[-1] == (1.0, 0.0)
        assert all(f + m >= 0.999 for f, m in curve)  # outside of the chord: convex


def texts(view: LiveView, now: int = 0) -> list[str]:
    return [alarm.text for alarm in alarms_of(view.board, now)]


def test_nothing_is_wrong_with_a_hand_that_holds(view: LiveView) -> None:
    assert texts(view) == []


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (replace(MARGIN, lower_bound=-0.1), "may be slipping"),
        (replace(MARGIN, earliest_slip=0.4), "may slip within"),
        (replace(COMMAND, reason=Reason.SLIP), "slip is felt"),
        (replace(COMMAND, reason=Reason.MAX_LIMIT), "largest force"),
        (replace(HEALTH, limit="near"), "half as much load again needs more than the largest force"),
        (replace(HEALTH, limit="reached"), "more is needed than the largest force"),
        (replace(HEALTH, condition=Condition.FROZEN), "frozen"),
        (
            replace(HEALTH, consistent=False, channel="normal_force", regime="hold", suspect="adhesion"),
            "adhesion",
        ),
    ],
)
def test_each_cause_gives_its_alarm(view: LiveView, message: object, said: str) -> None:
    view.receive(message, 0, NODE)  # type: ignore[arg-type]
    (text,) = texts(view)
    assert said in text


PROBING = replace(HEALTH, friction=PROBED)
LOW = replace(MARGIN, lower_bound=-0.1, earliest_slip=0.4)


def test_what_is_done_on_purpose_is_one_calm_state_and_no_alarm(view: LiveView) -> None:
    for friction, said in ((PROBED, "probing friction"), (KNOWN, "friction is known")):
        view.receive(replace(HEALTH, friction=friction), 0, NODE)
        view.receive(LOW, 0, NODE)
        assert texts(view) == []
        (state,) = states_of(view.board, 0)
        assert (state.level, state.finger) == (Level.CALM, "thumb")
        assert state.text.startswith(said)


def test_a_slip_that_is_felt_is_an_alarm_while_friction_is_probed_too(view: LiveView) -> None:
    view.receive(PROBING, 0, NODE)
    view.receive(replace(COMMAND, reason=Reason.SLIP), 0, NODE)
    (text,) = texts(view)
    assert "slip is felt" in text


def test_a_finger_of_known_friction_whose_margin_is_gone_is_an_alarm(view: LiveView) -> None:
    view.receive(replace(HEALTH, friction=KNOWN), 0, NODE)
    view.receive(replace(LOW, margin=sure(-0.02)), 0, NODE)
    (text,) = texts(view)
    assert "may be slipping" in text


def test_a_state_on_purpose_that_is_old_excuses_nothing(view: LiveView) -> None:
    view.receive(PROBING, 0, NODE)
    view.receive(LOW, 5 * NS, NODE)
    view.receive(CONTACT, 5 * NS, NODE)
    (text,) = texts(view, 5 * NS)
    assert "may be slipping" in text
    assert states_of(view.board, 5 * NS) == []


def test_a_node_that_is_killed_gives_an_alarm(view: LiveView) -> None:
    view.attend([Present(NODE, failure="killed")], NS)
    view.board.refresh(2 * NS)
    assert texts(view, 2 * NS) == [f"{NODE} has died (killed); the last numbers are old"]


def test_an_alarm_stays_long_enough_to_be_seen_and_then_goes(view: LiveView) -> None:
    alarms = Alarms()
    view.receive(replace(COMMAND, reason=Reason.SLIP), 0, NODE)
    assert len(alarms.update(alarms_of(view.board, 0), 0)) == 1
    assert len(alarms.update([], round(0.9 * ALARM_HOLD_S * NS))) == 1
    assert alarms.update([], round(1.1 * ALARM_HOLD_S * NS)) == []


def test_the_card_of_a_finger_says_its_alarm_as_long_as_the_banner_does(view: LiveView) -> None:
    view.receive(replace(COMMAND, reason=Reason.SLIP), 0, NODE)
    view.snapshot(0, wanted)
    view.receive(COMMAND, 1, NODE)
    for now in (1, round(1.1 * ALARM_HOLD_S * NS)):
        shown = view.snapshot(now, wanted)
        assert bool(shown["alarms"]) == (shown["fingers"][COMMAND.finger]["alarm"] is not None)


def test_the_same_alarm_of_several_fingers_is_one_that_names_them(view: LiveView) -> None:
    for finger in ("thumb", "index"):
        view.receive(replace(HEALTH, finger=finger, condition=Condition.STALE), 0, NODE)
    (shown,) = Alarms().update(alarms_of(view.board, 0), 0)
    assert shown["text"] == "thumb, index: no input of late"


def test_every_reason_and_condition_has_words() -> None:
    assert set(REASONS) == set(Reason)
    assert set(CONDITIONS) == set(Condition)


def test_the_finger_view_knows_no_clock_of_its_own(view: LiveView) -> None:
    row = view.board.rows["thumb"]
    assert finger_view(row, 7, wanted=None, learned={}) == finger_view(row, 7, wanted=None, learned={})


def test_a_card_names_the_worst_alarm_of_its_finger_and_none_while_friction_is_probed(view: LiveView) -> None:
    view.receive(LOW, 0, NODE)
    view.receive(CONTACT, 0, NODE)
    assert thumb(view, 0)["alarm"] == {"level": "bad", "label": "may slip"}
    view.receive(PROBING, 0, NODE)
    assert alarms_of(view.board, 0) == []
    assert thumb(view, 0)["health"]["friction"] == "probed"


def test_what_is_learned_has_its_unit_and_what_the_contact_has_is_not_said_twice(view: LiveView) -> None:
    for symbol in ("K", "mu", "nu1"):
        view.receive(LearnedParameter(0, "thumb", 0, symbol, sure(2.0), sure(2.0), 3.0), 0, NODE)
    assert [(one["symbol"], one["unit"]) for one in thumb(view, 0)["learned"]] == [("K", "N"), ("nu1", "1/s")]


def test_a_node_that_could_not_start_is_in_the_log_and_no_alarm(view: LiveView) -> None:
    view.attend([Present(NODE, 1), Present("/replay", 2)], 0)
    view.attend([Present(NODE, 1), Present("/replay", failure="no such file")], NS)
    view.board.refresh(NS)
    assert "no such file" in view.board.log[-1].text
    assert not [one for one in texts(view, NS) if "replay" in one]


def margin(stamp: int) -> SlipMargin:
    value = Estimate(0.6, 0.05, True, 0.0)
    return SlipMargin(stamp, "thumb", 0, value, 0.5, 0.95, 1.0, 9.0, 5.0)


@pytest.fixture
def page():
    with closing(FedPage(0.15, 0)) as page:
        yield page


def test_nothing_is_taken_until_a_page_looks(page: FedPage) -> None:
    now = time.monotonic_ns()
    page.receive(margin(now), now, "/grasp_force")
    page.tick()
    assert page.first()[1].startswith('{"layout"')  # no event was made
    page.receive(margin(now), time.monotonic_ns(), "/grasp_force")
    page.tick()
    number, text = page.since(0)
    assert number == 1
    assert '"thumb"' in text
    assert '"wanted":0.15' in text


def test_the_page_is_served_with_its_key_and_ends(page: FedPage) -> None:
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with opener.open(page.address) as answer:
        assert b"vegrip" in answer.read()
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.build_opener().open(page.address.split("?")[0])
