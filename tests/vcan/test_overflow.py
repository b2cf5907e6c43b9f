"""A reader that does not read: the kernel drops the newest frames and tells nobody; the counters show it."""

from vegrip.messages import FingertipState

SENT = 600


def test_what_the_kernel_dropped_is_counted_as_lost_and_what_follows_is_taken(endpoint):
    sender, receiver = endpoint(), endpoint()
    for seq in range(SENT):
        sender.send(FingertipState(0, "thumb", seq, normal_force=1.0))
    kept = []
    while got := receiver.receive(0.0):
        kept += got
    assert 0 < len(kept) < SENT, "the receive buffer of a socket is finite"
    assert [m.seq for m in kept] == list(range(len(kept))), "what is kept is in order"
    sender.send(FingertipState(0, "thumb", SENT, normal_force=2.0))
    (fresh,) = receiver.receive(1.0)
    assert (fresh.seq, fresh.normal_force) == (SENT, 2.0)
    silent = fresh.stamp - kept[-1].stamp > 500_000_000  # on a slow machine: then a stream may go on anywhere
    assert receiver.rejected == ({} if silent else {"lost": SENT - len(kept)})
    assert sender.rejected == {}
