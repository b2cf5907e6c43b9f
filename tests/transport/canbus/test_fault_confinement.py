"""The rules of ISO 11898-1 for the error counters of one node."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.transport.canbus.fault_confinement import Confinement, ErrorState

STEPS = {
    "sent": lambda c: c.sent(),
    "received": lambda c: c.received(),
    "failed to send": lambda c: c.failed_to_send(),
    "not acknowledged": lambda c: c.not_acknowledged(),
    "failed to receive": lambda c: c.failed_to_receive(is_first=False),
    "failed first": lambda c: c.failed_to_receive(is_first=True),
}


def after(step, count):
    confinement = Confinement()
    for _ in range(count):
        STEPS[step](confinement)
    return confinement


@pytest.mark.parametrize(
    ("step", "passive_after"),
    [("failed to send", 16), ("not acknowledged", 16), ("failed to receive", 128), ("failed first", 15)],
)
def test_a_node_turns_passive_when_a_counter_exceeds_127(step, passive_after):
    assert after(step, passive_after - 1).state is ErrorState.ACTIVE
    assert after(step, passive_after).state is ErrorState.PASSIVE


def test_a_sender_turns_off_when_its_counter_exceeds_255():
    assert after("failed to send", 31).state is ErrorState.PASSIVE
    assert after("failed to send", 32).state is ErrorState.OFF


@pytest.mark.parametrize("step", ["not acknowledged", "failed to receive", "failed first"])
def test_neither_a_lone_node_nor_a_receiver_ever_turns_off(step):
    assert after(step, 10_000).state is ErrorState.PASSIVE


def test_eight_good_frames_pay_for_one_bad_one():
    confinement = after("failed to send", 1)
    for _ in range(8):
        assert not confinement.is_clean
        confinement.sent()
    assert confinement.is_clean


def test_one_good_frame_brings_a_passive_receiver_back():
    confinement = after("failed to receive", 200)
    confinement.received()
    assert (confinement.receive, confinement.state) == (127, ErrorState.ACTIVE)


def test_a_node_that_is_off_comes_back_clean_after_128_sequences_and_not_before():
    confinement = after("failed to send", 32)
    assert not confinement.count_silence(127)
    assert confinement.count_silence(1)
    assert confinement.is_clean
    assert confinement.state is ErrorState.ACTIVE
    assert not confinement.count_silence(1000), "it is not off any more"


@given(st.lists(st.sampled_from(sorted(STEPS))))
def test_counters_stay_within_their_registers_and_state_follows_from_them(steps):
    confinement = Confinement()
    for step in steps:
        if confinement.state is not ErrorState.OFF:
            STEPS[step](confinement)
        assert 0 <= confinement.receive <= 255
        assert 0 <= confinement.transmit <= 263
        assert (confinement.state is ErrorState.ACTIVE) == (
            max(confinement.transmit, confinement.receive) <= 127
        )
