"""A CANopen node that does not run is started again, ever more rarely; one that is away is named."""

from collections import Counter

import pytest

from vegrip.transport.codec import Frame
from vegrip.transport.mapped.canopen_nodes import CanopenNodes

S = 10**9
START = Frame(0, bytes((1, 33)))


@pytest.fixture
def nodes():
    return CanopenNodes([33], [], S, Counter(), {33: "thumb"}, {0x1A1: 33})


def heartbeat(nodes, state):
    nodes.receive(Frame(0x721, bytes((state,))))


def starts(nodes, begin, seconds, state=None, period=0.1):
    """Return when the node is started, looked at 50 times a second."""
    found = []
    for k in range(round(50 * seconds)):
        now = round(begin * S) + k * S // 50
        if state is not None and k % round(50 * period) == 0:
            heartbeat(nodes, state)
        found += [now / S] * nodes.due(now).count(START)
    return found


@pytest.mark.parametrize("state", [0x7F, 0x04])
def test_a_node_that_waits_is_started_ever_more_rarely(nodes, state):
    at = starts(nodes, 0.0, 20.0, state)
    assert at == [0.26, 0.76, 1.76, 3.76, 7.76, 11.76, 15.76, 19.76]  # after 0.25 s, doubled up to 4 s
    assert nodes.rejected["started_again"] == len(at)


@pytest.mark.parametrize(("ran", "gap"), [(5.0, 4.0), (5.02, 0.5)])
def test_only_more_than_five_seconds_of_running_make_the_waits_short_again(nodes, ran, gap):
    assert starts(nodes, 0.0, 3.78, 0x7F)[-1] == 3.76
    assert starts(nodes, 3.78, ran, 5) == []
    first, second = starts(nodes, 3.78 + ran, 4.1, 0x7F)[:2]
    assert second - first == pytest.approx(gap)


def test_a_node_whose_start_was_lost_is_started_without_any_heartbeat(nodes):
    assert len(starts(nodes, 0.0, 1.0)) == 2


def test_a_node_that_runs_is_left_alone(nodes):
    assert not nodes.receive(Frame(0x1A1, bytes(8)))
    assert starts(nodes, 0.0, 10.0) == []
    assert nodes.rejected["started_again"] == 0


def test_a_node_that_answers_runs():
    nodes = CanopenNodes([33], [(33, 0x2000, 1)], S, Counter(), {33: "thumb"})
    assert nodes.identifiers == {0x721, 0x0A1, 0x5A1}
    assert nodes.receive(Frame(0x5A1, b"\x4f\x00\x20\x01" + bytes(4)))
    assert starts(nodes, 0.0, 1.0) == []


def test_a_node_that_falls_back_is_started_at_once_and_later_again(nodes):
    heartbeat(nodes, 5)
    assert starts(nodes, 0.0, 6.0, 5) == []
    assert starts(nodes, 6.0, 0.2, 0x7F) == [6.0]
    assert starts(nodes, 6.2, 6.0, 5) == []
    assert starts(nodes, 20.0, 0.2, 0x7F) == [20.0]


def test_a_node_that_falls_back_at_every_start_is_not_started_at_every_beat(nodes):
    count = 0
    for k in range(100):
        heartbeat(nodes, 5 if k % 2 else 0x7F)
        count += nodes.due(k * S // 10).count(START)
    assert count <= 8


def test_a_bus_that_was_opened_again_knows_nothing_of_its_nodes(nodes):
    nodes.receive(Frame(0x1A1, bytes(8)))
    assert starts(nodes, 0.0, 2.0) == []
    nodes.begin()
    assert len(starts(nodes, 2.0, 1.0)) == 2


def test_a_node_that_stays_away_is_named_once(nodes):
    nodes.receive(Frame(0x1A1, bytes(8)))
    starts(nodes, 0.0, 5.0)
    assert nodes.rejected["away_thumb"] == 1
    nodes.receive(Frame(0x1A1, bytes(8)))
    starts(nodes, 5.0, 5.0)
    assert nodes.rejected["away_thumb"] == 2


def test_a_node_is_away_once_two_seconds_have_passed_without_a_frame(nodes):
    for now, is_away in ((0, False), (2 * S, False), (2 * S + 1, True)):
        nodes.due(now)
        assert nodes.rejected["away_thumb"] == is_away


def test_a_node_that_is_heard_is_not_away_however_late_it_is(nodes):
    heartbeat(nodes, 5)
    starts(nodes, 1e5, 5.0, 5, period=1.9)
    assert nodes.rejected["away_thumb"] == 0


@pytest.mark.parametrize(
    ("identifier", "data"), [(0x0A1, b"\x30\x81\x11" + bytes(5)), (0x5A1, b"\x4f\0\x20\1" + bytes(4))]
)
def test_whatever_comes_of_a_node_says_that_it_is_there(identifier, data):
    """Emergencies alone, or answers alone, are frames too; two seconds after the last it is away."""
    nodes = CanopenNodes([33], [(33, 0x2000, 1)], S, Counter(), {33: "thumb"})
    for beat in range(5):
        assert nodes.receive(Frame(identifier, data))
        nodes.due(round(1.9 * beat * S))
        assert nodes.rejected["away_thumb"] == 0
    last = round(1.9 * 4 * S)
    for now, is_away in ((last + 2 * S, 0), (last + 2 * S + 1, 1), (last + 5 * S, 1)):
        nodes.due(now)
        assert nodes.rejected["away_thumb"] == is_away


@pytest.mark.parametrize(
    ("state", "counted"),
    [(0x05, {}), (0x85, {}), (0x7F, {"not_operational": 1}), (0xFF, {"not_operational": 1}),
     (0x84, {"not_operational": 1}), (0x80, {"restarted": 1})],
)  # fmt: skip
def test_the_toggle_bit_of_a_heartbeat_changes_nothing_of_what_it_says(nodes, state, counted):
    heartbeat(nodes, state)
    assert +nodes.rejected == counted
    assert starts(nodes, 0.0, 0.2) == ([0.0] if "restarted" in counted else [])


def test_a_boot_up_is_a_restart_and_no_start_again(nodes):
    heartbeat(nodes, 0)
    assert nodes.due(S) == [START]
    assert +nodes.rejected == {"restarted": 1}


@pytest.mark.parametrize("beats", [1, 4])
def test_a_boot_up_takes_no_turn_of_the_waits(nodes, beats):
    """However often it comes: from the last on the first wait, of a quarter of a second, counts."""
    for beat in range(beats):
        heartbeat(nodes, 0)
        assert nodes.due(beat * S // 50) == [START]
    begin = (beats - 1) / 50
    at = starts(nodes, begin, 2.0)
    assert [one - begin for one in at] == pytest.approx([0.26, 0.76, 1.76])


def test_a_boot_up_leaves_the_waits_of_a_node_that_never_runs_as_long_as_they_are(nodes):
    assert starts(nodes, 0.0, 1.0) == [0.26, 0.76]
    heartbeat(nodes, 0)
    assert starts(nodes, 1.0, 1.5) == [1.0, 2.0]
