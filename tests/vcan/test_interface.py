"""An interface that is missing, down, too small, lowered or removed under a running node."""

import contextlib
import time

import pytest

from vegrip.errors import DeviceError
from vegrip.messages import FingertipState


@pytest.fixture
def spare(links):
    """An interface of this test alone."""
    links.add("vcan7")
    yield "vcan7"
    with contextlib.suppress(OSError):
        links.remove("vcan7")


def heard(sender, receiver, patience=60.0):
    """Send until something arrives: a lost bus is opened again once a second."""
    deadline = time.monotonic() + patience
    seq = time.monotonic_ns() & 0xFFFF
    while time.monotonic() < deadline:
        seq += 1
        sender.send(FingertipState(0, "thumb", seq, normal_force=1.0))
        if receiver.receive(0.1):
            return True
        sender.receive(0.0)
    return False


def classic_only(links, name):
    links.remove(name)
    links.add(name, links.CLASSIC_MTU)


@pytest.mark.parametrize(
    ("spoil", "remedy"),
    [
        (lambda links, name: links.remove(name), "sudo ip link add vcan7 type vcan"),
        (lambda links, name: links.set_down(name), "sudo ip link set vcan7 up"),
        (classic_only, "sudo ip link set vcan7 mtu 72"),
    ],
    ids=["missing", "down", "classic only"],
)
def test_an_interface_that_cannot_serve_is_refused_with_the_remedy(links, spare, endpoint, spoil, remedy):
    spoil(links, spare)
    with pytest.raises(DeviceError, match=remedy) as caught:
        endpoint(channel=spare)
    assert "\n" not in str(caught.value)


def test_classic_frames_go_over_an_interface_that_has_room_for_no_more(links, endpoint, spare):
    classic_only(links, spare)
    assert heard(endpoint(channel=spare, fd=False), endpoint(channel=spare, fd=False))


def test_a_lowered_interface_is_counted_and_used_again_when_it_is_raised(links, endpoint, spare):
    sender, receiver = endpoint(channel=spare), endpoint(channel=spare)
    assert heard(sender, receiver)
    links.set_down(spare)
    assert not heard(sender, receiver, patience=0.5)
    assert receiver.rejected["bus_lost"] >= 1
    assert sender.rejected["unsent"] >= 1
    links.set_up(spare)
    assert heard(sender, receiver)


def test_an_interface_that_was_removed_and_made_again_is_opened_again(links, endpoint, spare):
    sender, receiver = endpoint(channel=spare), endpoint(channel=spare)
    assert heard(sender, receiver)
    links.remove(spare)
    assert not heard(sender, receiver, patience=0.5)
    links.add(spare)
    assert heard(sender, receiver)
    assert receiver.rejected["bus_lost"] >= 1
