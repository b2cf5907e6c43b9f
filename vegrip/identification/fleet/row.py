"""One recording examined: a row that says what was found, or why nothing could be."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from vegrip.errors import DeviceError, VegripError

FAILED = "failed"


@dataclass(frozen=True)
class Row:
    """What came of one recording.

    Attributes:
        path: of its folder.
        verdict: of the diagnosis, or "failed".
        effects: what was named; a set that was not separated is one text, "a or b".
        sizes: parameters of what was named.
        before, after: error in units of the noise; NaN when it failed.
        note: why it failed, or what is left that nothing explains.
        doubts: what else may have caused what was named.
        lost: what of the recording could not be read, and was left out.
        is_machine_failure: whether it failed for a reason of the machine, so that another run tries it again.

    """

    path: str
    verdict: str
    effects: tuple[str, ...] = ()
    sizes: dict[str, float] = field(default_factory=dict)
    before: float = float("nan")
    after: float = float("nan")
    note: str = ""
    doubts: tuple[str, ...] = ()
    lost: str = ""
    is_machine_failure: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self)


def examine_recording(path: str, model: str = "") -> Row:
    """Diagnose the recording in ``path``; ``model`` is a file to start from. Nothing is raised.

    A recording that is too short or too faulty to name anything has failed: that it shows no effect says
    nothing about its pad.
    """
    from vegrip.identification.diagnosis import diagnose  # noqa: PLC0415 (in the worker, not in the command)
    from vegrip.identification.recording import read_recording  # noqa: PLC0415
    from vegrip.identification.recording.missing import MISSING  # noqa: PLC0415
    from vegrip.model import read_model  # noqa: PLC0415

    for needed in (path, model or path):
        if not Path(needed).exists():
            return Row(
                path, FAILED, note=f"the process that examines it sees no {needed}", is_machine_failure=True
            )
    try:
        recording = read_recording(Path(path), announce=False)
        is_whole = not recording.report.rows_lost and MISSING not in recording.source
        lost = "" if is_whole else _in_a_line(recording.report.summary())
        found = diagnose(recording, read_model(Path(model)) if model else None, threads=1)
        grave = [one.text for one in found.doubts if one.is_grave]
        if grave:
            return Row(path, FAILED, note="; ".join(grave), lost=lost)
        verdict = found.verdict
        values = found.model.values
        effects = tuple(found.named)
        if verdict == "ambiguous":
            effects = tuple(" or ".join(sorted(group)) for group in found.indistinguishable)
        taken = [one.candidate.effect for one in found.search.accepted]
        sizes = {p.symbol: values[p.symbol].value for e in taken for p in e.parameters if p.null is not None}
        left = found.unexplained
        note = f"depends on {left.variable}" if verdict == "unexplained" and left is not None else ""
        error = found.error
    except (DeviceError, MemoryError, OSError) as wrong:
        return Row(path, FAILED, note=f"{type(wrong).__name__}: {wrong}", is_machine_failure=True)
    except VegripError as wrong:
        return Row(path, FAILED, note=str(wrong))
    except Exception as wrong:  # noqa: BLE001 (one recording must not stop the others)
        return Row(path, FAILED, note=f"{type(wrong).__name__}: {wrong}")
    doubts = tuple(one.text for one in found.doubts)
    return Row(path, verdict, effects, sizes, error["before"], error["after"], note, doubts, lost)


def _in_a_line(text: str) -> str:
    return "; ".join(line.strip() for line in text.splitlines())
