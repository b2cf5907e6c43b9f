"""A calibration in its folder: limits, trials with their recordings, and its end, the model and an account.

::

    FOLDER/calibration.json     this
    FOLDER/trials/1-press       the recording of each trial
    FOLDER/next.toml            the motion of the next one
    FOLDER/recording            all trials as one recording, FOLDER/model.toml, FOLDER/report.html: at the end
"""

import json
import math
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vegrip.errors import InputError, UsageError
from vegrip.identification.calibration.checks import check_trial, without_zeros
from vegrip.identification.calibration.plan import Known, Next, first_of, known_of, next_of
from vegrip.identification.calibration.trials import TRIAL_KINDS
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.account import account
from vegrip.identification.experiment.design import next_experiment
from vegrip.identification.experiment.design_space import RigLimits, complete_limits
from vegrip.identification.fit import Fit, fit, noise_of
from vegrip.identification.fit.noise import find_copies
from vegrip.identification.fit.result import MISFIT
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Fingertip, Recording, read_recording, write_recording
from vegrip.identification.recording.data import join_recordings
from vegrip.identification.slip_channel import SlipChannel, slides_of, slip_channel
from vegrip.model import read_model, write_model
from vegrip.whole_file import write_whole, writing

CALIBRATION_FILE = "calibration.json"
NEXT, MODEL, JOINED, REPORT = "next.toml", "model.toml", "recording", "report.html"
VERSION = 1
DEPTH_SHARE = 0.12  # of the radius: the usual greatest depth
FORCE_N = 5.0  # [N] the usual greatest normal force
SPEED_SHARE = 2.0  # radii a second: the usual fastest motion
MOST_TRIALS = 20


@dataclass
class Done:
    """One trial that was recorded."""

    kind: str
    name: str
    folder: str  # below that of the calibration
    problems: list[str] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)  # [m/s] of the slide of each episode, as asked for

    @property
    def is_good(self) -> bool:
        return not self.problems


@dataclass
class Calibration:
    """One fingertip on its way to a model."""

    folder: Path  # where everything is kept
    radius: float  # of the fingertip [m]
    limits: RigLimits  # of the rig, all given
    trials: list[Done] = field(default_factory=list)  # done so far
    asked: dict[str, Any] = field(default_factory=dict)  # the next one, as asked for: kind, name and speeds

    def take(self, recording: Recording, kind: str = "") -> Done:
        """Keep the recording of the trial that was asked for, or of a ``kind``.

        Raises:
            RecordingError: it cannot be used; nothing is kept.
            UsageError: there is no such kind, or there are too many trials.

        """
        kind = kind or str(self.asked.get("kind", "press"))
        if kind not in TRIAL_KINDS:
            raise UsageError(f"there is no trial {kind!r}; there are {', '.join(TRIAL_KINDS)}")
        if len(self.trials) >= MOST_TRIALS:
            raise UsageError(f"there are {MOST_TRIALS} trials already; begin anew, or drop one")
        problems = check_trial(kind, recording)
        kept = replace(recording, fingertip=Fingertip(self.radius, recording.fingertip.name))
        for place, one in enumerate(self.trials, 1):
            former = read_recording(self.folder / one.folder)
            if find_copies(join_recordings([former, kept], "both")):
                raise UsageError(f"{recording.name} is the recording of trial {place} ({one.kind}) again")
        number = 1 + max((int(Path(one.folder).name.split("-")[0]) for one in self.trials), default=0)
        asked = self.asked if self.asked.get("kind") == kind else {}
        name, speeds = str(asked.get("name", kind)), list(asked.get("speeds", []))
        done = Done(kind, name, f"trials/{number}-{kind}", problems, speeds)
        write_recording(kept, self.folder / done.folder)
        self.trials.append(done)
        return done

    def drop(self, number: int) -> None:
        """Forget a trial, counted from 1.

        Raises:
            UsageError: there is none of that number.

        """
        if not 1 <= number <= len(self.trials):
            raise UsageError(f"there is no trial {number}; there are {len(self.trials)}")
        shutil.rmtree(self.folder / self.trials.pop(number - 1).folder, ignore_errors=True)

    def joined(self) -> tuple[Recording, tuple[int, ...]]:
        """Return all trials as one recording, each without its zeros of load, and the trial of each episode.

        Raises:
            UsageError: there is none yet.

        """
        if not self.trials:
            raise UsageError("nothing was recorded yet")
        parts = [without_zeros(read_recording(self.folder / one.folder)) for one in self.trials]
        trials = [number for number, part in enumerate(parts) for _ in np.unique(part.episode)]
        return join_recordings(parts, self.folder.resolve().name), tuple(trials)

    def slip_channel(self) -> SlipChannel:
        """Return what the slides show of the channel that feels them."""
        slides = [one for one in self.trials if one.kind == "slide"]
        return slip_channel(
            [
                slide
                for one in slides
                for slide in slides_of(without_zeros(read_recording(self.folder / one.folder)), one.speeds)
            ]
        )

    @property
    def good(self) -> list[str]:
        return [one.kind for one in self.trials if one.is_good]

    @property
    def again(self) -> list[str]:
        """What to record again, a sentence each: kinds without a good trial."""
        return [
            f"{one.kind} ({one.name}): {problem}"
            for one in self.trials
            if one.kind not in self.good
            for problem in one.problems
        ]


@dataclass(frozen=True, eq=False)
class Standing:
    """Where a calibration stands: what is known, and what is next."""

    fit: Fit | None
    known: Sequence[Known]
    next: Next

    @property
    def misfit(self) -> str:
        """What is said when the model leaves more than the noise, else nothing."""
        if self.fit is None or self.fit.error <= MISFIT:
            return ""
        return (
            f"the model leaves {self.fit.error:.2f} times the noise: an effect is missing; "
            "the end of the calibration looks for it"
        )


def judge(calibration: Calibration, report: Report = lambda _: None) -> Standing:
    """Fit what there is and find out what is next; ``calibration.asked`` is set to it.

    The model is the paper's, and after an end the one that it wrote, with the effects that were missing.
    """
    if not calibration.trials:
        found = Standing(None, (), first_of(calibration.radius, calibration.limits))
    else:
        extended = calibration.folder / MODEL  # with what a former end found missing
        start = read_model(extended) if extended.is_file() else None
        whole, trials = calibration.joined()
        fitted = fit(whole, start, zeros=trials, report=report)
        known = known_of(fitted)
        tried = [one.kind for one in calibration.trials]
        good, lacking = calibration.good, ""
        if "slide" in good and (lacking := calibration.slip_channel().lacking):
            good = [kind for kind in good if kind != "slide"]
        following = next_of(fitted, good, tried, calibration.limits, report)
        if lacking and following.trial is not None and following.trial.kind == "slide":
            following = replace(following, why=f"one more slide, to learn friction by slip: {lacking}")
        found = Standing(fitted, known, following)
    trial = found.next.trial
    calibration.asked = {}
    if trial is not None:
        speeds = [max(math.hypot(s.pull_x, s.pull_y) for s in one) for one in trial.protocol.episodes]
        calibration.asked = {"kind": trial.kind, "name": trial.protocol.name, "speeds": speeds}
    return found


def other_limits(limits: RigLimits, given: RigLimits) -> RigLimits:
    """Return ``limits`` with what is ``given``, neither NaN nor as usual, instead."""
    usual = asdict(RigLimits())
    said = {name: v for name, v in asdict(given).items() if not math.isnan(v) and v != usual[name]}
    return replace(limits, **said)


def usual_limits(given: RigLimits, radius: float) -> RigLimits:
    """Return the limits with what was not given as it is usual for a fingertip of ``radius`` [m]."""
    usual = RigLimits(DEPTH_SHARE * radius, FORCE_N, SPEED_SHARE * radius, FORCE_N, FORCE_N * radius)
    return complete_limits(given, usual)


def save(calibration: Calibration) -> None:
    """Write the state; a reader sees the old one or the new one."""
    answer = {
        "version": VERSION,
        "radius": calibration.radius,
        "limits": asdict(calibration.limits),
        "trials": [asdict(one) for one in calibration.trials],
        "asked": calibration.asked,
    }
    with writing(calibration.folder):
        calibration.folder.mkdir(parents=True, exist_ok=True)
        write_whole(calibration.folder / CALIBRATION_FILE, json.dumps(answer, indent=1) + "\n")


def load(folder: Path) -> Calibration | None:
    """Read the calibration in ``folder``, None where there is none."""
    file = folder / CALIBRATION_FILE
    if not file.is_file():
        return None
    try:
        answer = json.loads(file.read_text(encoding="utf-8"))
        return Calibration(
            folder,
            float(answer["radius"]),
            RigLimits(**answer["limits"]),
            [Done(**one) for one in answer["trials"]],
            dict(answer["asked"]),
        )
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise InputError(f"{file} cannot be read ({error}); begin anew in another folder") from None


@dataclass(frozen=True, eq=False)
class Ended:
    """The result of a calibration."""

    verdict: str  # of the diagnosis: adequate, named, ambiguous or unexplained
    added: list[str]  # effects that the paper's model lacked
    error: float  # rms of the whitened residuals; 1 is the noise
    known: list[Known]  # how well each parameter is known
    slip: SlipChannel  # what the slides show of the channel that feels them
    account: dict[str, Any]  # everything that the report needs

    def as_dict(self) -> dict[str, Any]:
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
    answer = account(found, folder, [command], next_experiment(found))
    answer["calibration"] = {
        "trials": [
            {"kind": one.kind, "name": one.name, "problems": one.problems} for one in calibration.trials
        ],
        "known": {one.symbol: one.as_dict() for one in known},
        "again": calibration.again,
    }
    added = [rung["effect"] for rung in answer["ladder"] if rung["effect"] is not None]
    return Ended(
        found.verdict, added, float(answer["ladder"][-1]["error"]), known, calibration.slip_channel(), answer
    )


def _from_touch(whole: Recording, fitted: Fit) -> Recording:
    """Return ``whole`` without the zeros that were fitted to its trials, so that one zero goes for all."""
    _, (depth, force) = fitted.problem.parts(fitted.optimum.u)
    columns = dict(whole.columns)
    columns["displacement"] = columns["displacement"] - depth
    columns["normal_force"] = columns["normal_force"] - force
    return replace(whole, columns=columns)
