"""How CURVE handshakes went, of a publisher and of subscriptions: a wrong key is otherwise only silence."""

from collections import Counter
from collections.abc import Mapping

import zmq


class Handshakes:
    """Counts refused connections by name.

    ``key_refused``: a publisher does not know our key; ``key_wrong``: a publisher has not the key that we
    expect; ``key_unknown``: we do not know the key of one who wanted to subscribe; ``key_stale``: one who
    wanted to subscribe has not our key. The last two are the trouble of others: ``in_trouble`` is about the
    first two.
    """

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._failing: set[str] = set()  # addresses of publishers that we cannot hear

    def refused(self) -> Mapping[str, int]:
        """Return the counts up to now."""
        return self._counts

    @property
    def in_trouble(self) -> bool:
        """Whether a publisher cannot be heard because of keys."""
        return bool(self._failing)

    def published(self, event: int) -> None:
        """Note the outcome of a handshake with a subscriber."""
        if event != zmq.EVENT_HANDSHAKE_SUCCEEDED:
            known = event == zmq.EVENT_HANDSHAKE_FAILED_AUTH
            self._counts["key_unknown" if known else "key_stale"] += 1

    def subscribed(self, address: str, event: int) -> None:
        """Take note of how a handshake with the publisher at ``address`` went."""
        if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
            self._failing.discard(address)
            return
        known = event == zmq.EVENT_HANDSHAKE_FAILED_AUTH
        self._counts["key_refused" if known else "key_wrong"] += 1
        self._failing.add(address)
