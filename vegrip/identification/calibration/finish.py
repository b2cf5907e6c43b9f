"""The end of a calibration: one recording, the model with what it lacked, and an account for the report."""

from dataclasses import dataclass, replace
from typing import Any

from vegrip.identification.calibration.goals import Known, known_of
from vegrip.identification.calibration.plan import Report
from vegrip.identification.calibration.session import JOINED, MODEL, Calibration
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.account import account
from vegrip.identification.experiment.next_experiment import next_experiment
from vegrip.identification.fit import Fit, noise_of
from vegrip.identification.recording import Recording, write_recording
from vegrip.identification.slip_channel import SlipChannel
from vegrip.model import write_model


@dataclass(frozen=True, eq=False)
class Ended:
    """What a calibration came to.

    Attributes:
        verdict: of the diagnosis: adequate, named, ambiguous or unexplained.
        added: effects that the paper's model lacked.
        error: rms of the whitened residuals; 1 is the noise.
        known: how well each parameter is known.
        slip: what the slides tell of the channel that feels them.
        account: everything that the report needs.

    """

    verdict: str
    added: list[str]
    error: float
    known: list[Known]
    slip: SlipChannel
    account: dict[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "verdict": self.verdict,
            "added": self.added,
            "error": self.error,
            "parameters": {one.symbol: one.as_dict() for one in self.known},
            "friction": self.slip.settings,
            "slip_channel": self.slip.lacking or "measured",
            "slip_felt": "" if self.slip.lacking else self.slip.bracket,
        }


def finish(calibration: Calibration, command: str, report: Report = lambda _: None) -> Ended:
    """Look for what the paper's model lacks, and write recording and model into the folder.

    Raises:
        UsageError: nothing was recorded yet.

    """
    whole, trials = calibration.joined()
    folder = calibration.folder / JOINED
    found = diagnose(whole, noise=noise_of(whole), zeros=trials, report=report)
    write_recording(_from_touch(whole, found.result), folder)
    write_model(found.model, calibration.folder / MODEL)
    known = known_of(found.result)
    told = account(found, folder, [command], next_experiment(found))
    told["calibration"] = {
        "trials": [
            {"kind": one.kind, "name": one.name, "problems": one.problems} for one in calibration.trials
        ],
        "known": {one.symbol: one.as_dict() for one in known},
        "again": calibration.again,
    }
    added = [rung["effect"] for rung in told["ladder"] if rung["effect"] is not None]
    return Ended(
        found.verdict, added, float(told["ladder"][-1]["error"]), known, calibration.slip_channel(), told
    )


def _from_touch(whole: Recording, fitted: Fit) -> Recording:
    """Return ``whole`` without the zeros that were fitted to its trials, so that one zero goes for all."""
    _, (depth, force) = fitted.problem.parts(fitted.optimum.u)
    columns = dict(whole.columns)
    columns["displacement"] = columns["displacement"] - depth
    columns["normal_force"] = columns["normal_force"] - force
    return replace(whole, columns=columns)
