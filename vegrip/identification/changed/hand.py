"""A hand of several fingers: what changed of each, and which cannot be compared."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vegrip.errors import RecordingError
from vegrip.identification.changed.changes import Changed, changed
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel


@dataclass(frozen=True, eq=False)
class ChangedHand:
    """What changed of each finger that both recordings show, and why others were not compared."""

    fingers: Mapping[str, Changed]
    not_compared: Mapping[str, str]

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        told = {finger: one.as_dict() for finger, one in self.fingers.items()}
        return {"fingers": told, "not_compared": dict(self.not_compared)}


def changed_fingers(
    first: Mapping[str, Recording],
    second: Mapping[str, Recording],
    model: ContactModel | None = None,
    *,
    tolerance: float = 0.0,
    report: Report = lambda _: None,
) -> ChangedHand:
    """Say what changed of every finger, by its name, as :func:`~vegrip.changed` does of one.

    Raises:
        RecordingError: no finger can be compared; says why.

    """
    found, not_compared = dict[str, Changed](), dict[str, str]()
    for finger in {**first, **second}:
        if finger not in first or finger not in second:
            not_compared[finger] = f"only the {'first' if finger in first else 'second'} recording has it"
            continue

        def told(text: str, finger: str = finger) -> None:
            report(f"{finger}: {text}")

        try:
            found[finger] = changed(first[finger], second[finger], model, tolerance=tolerance, report=told)
        except RecordingError as error:
            not_compared[finger] = str(error)
    if not found:
        each = [f"{finger}: {reason}" for finger, reason in not_compared.items()]
        raise RecordingError("; ".join(each if len(each) > 1 else not_compared.values()))
    return ChangedHand(found, not_compared)
