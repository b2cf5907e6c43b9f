"""How the CURVE handshakes of a publisher and a subscriber went: a wrong key is otherwise only silence."""

from collections import Counter
from collections.abc import Mapping
from typing import Final

import zmq
from zmq.utils.monitor import parse_monitor_message

WATCHED: Final = (
    zmq.EVENT_HANDSHAKE_SUCCEEDED
    | zmq.EVENT_HANDSHAKE_FAILED_AUTH
    | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
    | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
)
MOST_EVENTS = 256  # taken in one go; somebody who knocks without end must not keep us


class Handshakes:
    """Counts refused connections by name.

    ``key_refused``: a publisher does not know our key; ``key_wrong``: a publisher has not the key that we
    expect; ``key_unknown``: we do not know the key of one who wanted to subscribe; ``key_stale``: one who
    wanted to subscribe has not our key. The last two are the trouble of others: ``in_trouble`` is about the
    first two.
    """

    def __init__(self, publisher: zmq.Socket[bytes], subscriber: zmq.Socket[bytes]) -> None:
        self._publisher, self._subscriber = publisher, subscriber
        self._at_publisher = publisher.get_monitor_socket(int(WATCHED))
        self._at_subscriber = subscriber.get_monitor_socket(int(WATCHED))
        self._counts: Counter[str] = Counter()
        self._failing: set[bytes] = set()  # addresses of publishers that we cannot hear

    def refused(self) -> Mapping[str, int]:
        """Return the counts up to now."""
        self._look()
        return self._counts

    @property
    def in_trouble(self) -> bool:
        """Whether a publisher cannot be heard because of keys."""
        self._look()
        return bool(self._failing)

    def close(self) -> None:
        """Watch no more; before the sockets are closed."""
        for watched in (self._publisher, self._subscriber):
            watched.disable_monitor()
        for monitor in (self._at_publisher, self._at_subscriber):
            monitor.close(linger=0)

    def _look(self) -> None:
        for event, _ in _events(self._at_publisher):
            if event != zmq.EVENT_HANDSHAKE_SUCCEEDED:
                known = event == zmq.EVENT_HANDSHAKE_FAILED_AUTH
                self._counts["key_unknown" if known else "key_stale"] += 1
        for event, address in _events(self._at_subscriber):
            if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
                self._failing.discard(address)
                continue
            known = event == zmq.EVENT_HANDSHAKE_FAILED_AUTH
            self._counts["key_refused" if known else "key_wrong"] += 1
            self._failing.add(address)


def _events(monitor: zmq.Socket[bytes]) -> list[tuple[int, bytes]]:
    found = []
    for _ in range(MOST_EVENTS):
        try:
            told = parse_monitor_message(monitor.recv_multipart(zmq.DONTWAIT))
        except zmq.Again:
            break
        found.append((int(told["event"]), bytes(told["endpoint"])))
    return found
