"""Whether and when a node that has ended is started again. Pure."""

FIRST_DELAY = 1.0  # [s]
LAST_DELAY = 30.0  # [s] it doubles up to this
STEADY = 60.0  # [s] a node that ran as long begins with the first delay again


class RestartPolicy:
    """One node's ``restart``: never, on-failure or always."""

    def __init__(self, when: str) -> None:
        self._when = when
        self._delay = FIRST_DELAY

    def delay(self, exit_code: int, ran: float) -> float | None:
        """Return the wait [s] before a node that ``ran`` so long [s] starts again; None: it does not."""
        if self._when == "never" or (self._when == "on-failure" and exit_code == 0):
            return None
        if ran >= STEADY:
            self._delay = FIRST_DELAY
        delay, self._delay = self._delay, min(2 * self._delay, LAST_DELAY)
        return delay
