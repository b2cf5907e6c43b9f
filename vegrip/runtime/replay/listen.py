"""Record what a running node receives and says, from its telemetry: without a second access to its bus."""

import math
import time
from collections.abc import Callable
from typing import Any

from vegrip.errors import DeviceError
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.messages import DeviceReport, FingertipState
from vegrip.runtime.registry import Entry, ask
from vegrip.runtime.telemetry_socket import TelemetryReader

WAIT_S = 0.2  # [s] between two flushes
SILENCE_S = 5.0  # [s] without one state after which the node is said to receive nothing


def record_node(
    entry: Entry,
    writer: RecordingWriter,
    duration: float,
    report: Callable[[int], None] = lambda _: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> int:
    """Write what ``entry`` receives and says for ``duration`` [s] (0 = until stopped); return the states."""
    reader, states = TelemetryReader([entry]), 0
    begin = time.monotonic()
    try:
        while not should_stop() and not (0.0 < duration <= time.monotonic() - begin):
            for _, _, direction, message in reader.read(WAIT_S):
                if direction == "out" or isinstance(message, (FingertipState, DeviceReport)):
                    writer.write(message)
                    states += isinstance(message, FingertipState)
            writer.flush()
            report(states)
            if not states and time.monotonic() - begin > SILENCE_S:
                raise DeviceError(f"{entry.name} has received no state for {SILENCE_S:g} s; is it active?")
    finally:
        reader.close()
    if not states:
        raise DeviceError(f"{entry.name} received no state within {duration:g} s; record for longer")
    return states


def tip_of(entry: Entry) -> tuple[str, float]:
    """Return model file (empty: the paper's model) and radius [m] (NaN: unknown) of a node's fingertips."""
    rows: dict[str, Any] = {row["name"]: row["value"] for row in ask(entry, "parameters")}
    return str(rows.get("tip.model") or ""), float(rows.get("tip.radius") or math.nan)
