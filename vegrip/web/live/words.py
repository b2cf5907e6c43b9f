"""Why a command is what it is, and what is wrong with an input, in words for the page."""

from vegrip.messages import KNOWN, PROBED, Condition, ModelHealth, Reason

REASONS = {
    Reason.HOLD: "holds: the force suffices",
    Reason.RAISE: "raises: the margin is below its target",
    Reason.LOWER: "lowers: less force suffices",
    Reason.SLIP: "raises: slip is felt",
    Reason.FORECAST: "raises: the relaxing contact would slip soon",
    Reason.RATE_LIMIT: "changes as fast as the limit allows",
    Reason.MIN_LIMIT: "at the least force allowed",
    Reason.MAX_LIMIT: "at the largest force allowed",
    Reason.INPUT_HOLD: "holds the last safe force: bad input",
    Reason.FAIL_SAFE: "goes to the fail-safe grip: bad input for long",
    Reason.UNTRUSTED: "never below the last safe force: the estimate is not valid",
    Reason.INACTIVE: "no control: the node is not active",
}
CONDITIONS = {
    Condition.OK: "input ok",
    Condition.DEGRADED: "a channel is missing",
    Condition.STALE: "no input of late",
    Condition.MISSING: "no input yet",
    Condition.OUT_OF_RANGE: "input out of range",
    Condition.FROZEN: "input frozen",
    Condition.REPLAYED: "input replayed",
    Condition.CORRUPT: "input corrupt",
}

FRICTION = {
    PROBED: "probing friction: let go of slowly on purpose",
    KNOWN: "friction is known: held with little more than the least force on purpose",
}
"""What is done on purpose, by :attr:`vegrip.messages.ModelHealth.friction`."""


def health_in_words(health: ModelHealth) -> str:
    """Return whether the model explains what is measured, where it fails, and what it may lack."""
    if health.consistent:
        return "the model explains what is measured"
    if not health.channel:
        return "not judged yet"
    text = f"the model does not explain {health.channel.replace('_', ' ')}"
    if health.regime:
        text += f" in {health.regime}"
    if health.suspect == "unexplained":
        return text + "; no known effect explains it"
    return text + (f"; suspect: {health.suspect.replace('_', ' ')}" if health.suspect else "")
