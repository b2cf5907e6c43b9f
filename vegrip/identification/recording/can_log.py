"""CAN logs (Vector's, PEAK's, candump's) become recordings: frames through the same codec as on the bus."""

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.can_frames import Log, read_log
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.checks import kept_rows
from vegrip.identification.recording.data import Fingertip, Recording
from vegrip.identification.recording.mended_times import mended
from vegrip.identification.recording.report import MISSING, Kind, LoadReport, MissingStates, describe_missing
from vegrip.messages import FingertipState
from vegrip.transport.codec import CanCodec


def read_can_log(
    path: Path | str,
    fingers: Sequence[str],
    *,
    radius: float = math.nan,
    channel: str = "",
    spread: bool = False,
    remedy: str = "--channel {0}",
) -> dict[str, Recording]:
    """Return the recording of every finger that speaks in the log, by finger.

    Args:
        path: ``.asc``, ``.blf``, ``.trc``, ``.mf4`` or what candump writes.
        fingers: names in the order of the bus.
        radius: of the fingertips [m]; a log does not hold it.
        channel: the one to read, where the log has several.
        spread: rows of one time stamp are spread until the next.
        remedy: how the user says which channel is meant.

    Raises:
        RecordingError: not a log, or no frame of a fingertip in it.

    """
    path, refused = Path(path), Counter[str]()
    states: dict[str, list[FingertipState]] = defaultdict(list)
    codecs = {fd: CanCodec(fingers, fd=fd) for fd in (False, True)}
    log = read_log(path, channel=channel, remedy=remedy)
    last: dict[int, tuple[str, bytes]] = {}
    behind = Counter[str]()
    for frame in log.frames:
        codec, at = codecs[frame.fd], frame.arbitration_id
        counted = codec.rejected["counter"]
        message = codec.decode(frame)
        if isinstance(message, FingertipState):
            states[message.finger].append(message)
            last[at] = message.finger, frame.data
        elif codec.rejected["counter"] > counted and at in last and last[at][1] != frame.data:
            behind[last[at][0]] += 1  # one that repeats the last is an echo, and no loss
    for codec in codecs.values():
        refused.update(codec.rejected)
    if not states:
        causes = ", ".join(f"{count} {cause}" for cause, count in sorted(refused.items()))
        remedy = f"refused: {causes}" if causes else "for a hand of another make see vegrip connect -h"
        raise RecordingError(
            f"{path}: none of its {len(log.frames)} frames is a fingertip's state ({remedy})"
        )
    start = min(found[0].stamp for found in states.values())
    broken = {f: behind[f] + sum(codec.broken[f] for codec in codecs.values()) for f in fingers}
    return {
        f: _recording(path, f, states[f], start, refused, broken[f], log, radius, spread=spread)
        for f in fingers
        if f in states
    }


def _recording(
    path: Path,
    finger: str,
    states: list[FingertipState],
    start: int,
    refused: Counter[str],
    broken: int,
    log: Log,
    radius: float,
    *,
    spread: bool,
) -> Recording:
    report = LoadReport(rows_read=len(states))
    for cause, count in sorted(refused.items()):
        report.add(Kind.NOTE, f"{count} frames refused: {cause}")
    missing = MissingStates()
    for state in states:
        missing.take(state)
    source: dict[str, str | int | float | bool] = {"file": path.name}
    if missing.count:
        source[MISSING] = missing.count
        report.add(Kind.NOTE, describe_missing(missing.count))
    _add_losses(report, log, broken, missing.count)
    t = np.array([(state.stamp - start) / NS for state in states])
    columns = {name: np.array([getattr(s, name) for s in states]) for name in CHANNELS}
    lines, one_trial = np.arange(1, len(states) + 1), np.zeros(len(states), dtype=np.int64)
    kept = kept_rows(path, mended(t, report, spread=spread), one_trial, columns, radius, lines, report)
    return Recording(f"{path.stem} {finger}", *kept, Fingertip(radius, finger), {}, source, start, report)


def _add_losses(report: LoadReport, log: Log, broken: int, missing: int) -> None:
    """Count what of the log, and of the frames of a finger, is in no state; a broken one is missing, too."""
    torn = 0
    for finding in log.report.findings:
        if finding.kind.lost:
            where = f" from line {finding.lines[0]} on" if finding.lines else ""
            report.add(finding.kind, f"{finding.what}{where}", count=finding.count)
            torn += finding.count
        else:
            report.add(finding.kind, finding.what)
    unseen = max(missing - broken - torn, 0)
    for kind, count in ((Kind.REFUSED, broken), (Kind.UNSEEN, unseen)):
        if count:
            report.add(kind, count=count)
    report.rows_read += sum(f.count for f in report.findings if f.kind.lost)
