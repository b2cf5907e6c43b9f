"""Which commands a drive obeys."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.grip.safety import AHEAD, LONGEST_LIFE, reason_to_reject

NOW = 10**12
MS = 1_000_000


def command(force=2.0, stamp=NOW, life=100 * MS):
    return force, stamp, stamp + life


@pytest.mark.parametrize(
    ("given_command", "words"),
    [
        (command(), ""),
        (command(stamp=NOW - 99 * MS), ""),
        (command(stamp=NOW + 20 * MS), ""),
        (command(stamp=NOW - 100 * MS), "expired"),
        (command(life=0), "expired"),
        (command(life=10_000 * MS), ""),
        (command(life=10_000 * MS + 1), "lives too long"),
        (command(stamp=NOW + 1000 * MS), ""),
        (command(stamp=NOW + 1000 * MS + 1), "from the future"),
        (command(force=0.0), ""),
        (command(force=math.nan), "no usable force"),
        (command(force=-1.0), "no usable force"),
    ],
)
def test_a_command_is_obeyed_while_it_is_fresh_and_bounded(given_command, words):
    assert reason_to_reject(*given_command, NOW) == words


@given(st.integers(), st.integers(), st.integers(0, 10**18))
def test_no_command_is_obeyed_for_longer_than_the_longest_life_and_the_clocks_apart(stamp, expires, later):
    hostile = 2.0, stamp, expires
    if not reason_to_reject(*hostile, NOW) and not reason_to_reject(*hostile, NOW + later):
        assert later < LONGEST_LIFE + AHEAD
