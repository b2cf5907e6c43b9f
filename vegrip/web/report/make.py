"""Make the report of what a folder holds: a recording, a run, a check, or what `refine --report` wrote."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vegrip.errors import InputError, UsageError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.account import account, described, versions
from vegrip.identification.experiment.design import next_experiment
from vegrip.identification.fit import noise_of
from vegrip.identification.recording import read_recording
from vegrip.identification.recording.folder import TOML
from vegrip.identification.recording.session import is_run, summarise_run
from vegrip.model import ContactModel
from vegrip.web.check.session import CHECK_FILE, load
from vegrip.web.report.model_report import account_of_check, model_report
from vegrip.web.report.run_report import run_report

REFINED = "report.json"
NEEDED = ("ladder", "verdict", "data", "diagnosis", "before", "after", "parameters", "warnings", "versions")


def make_report(
    what: Path, model: ContactModel | None, model_file: Path | None, report: Callable[[str], None]
) -> str:
    """Return the report of ``what`` as HTML; ``report`` is told what is done.

    Raises:
        InputError: the folder holds nothing to report of, or what it holds cannot be read.
        UsageError: a model was given for something that has its own.

    """
    if (what / TOML).is_file():
        return _of_recording(what, model, model_file, report)
    if model is not None:
        raise UsageError(f"{what} has a model of its own; --model goes with a recording")
    if is_run(what):
        return run_report(summarise_run(what), [f"vegrip report {shlex.quote(str(what))}"], versions())
    if (what / CHECK_FILE).is_file():
        return _of_check(what)
    if (what / REFINED).is_file():
        return model_report(_refined(what / REFINED))
    raise InputError(
        f"{what}: is neither a recording, nor a run that was recorded, nor the folder of `vegrip check` or "
        "`vegrip refine --report`"
    )


def _of_recording(
    folder: Path, model: ContactModel | None, model_file: Path | None, report: Callable[[str], None]
) -> str:
    recording = read_recording(folder)
    found = diagnose(recording, model, noise=noise_of(recording), report=report)
    given = f" --model {shlex.quote(str(model_file))}" if model_file is not None else ""
    again = [f"vegrip report {shlex.quote(str(folder))}{given}"]
    return model_report(account(found, folder, again, next_experiment(found)))


def _of_check(folder: Path) -> str:
    recording = Path(str(_read(folder / CHECK_FILE).get("recording", "")))
    session = load(folder, str(recording))
    if session is None or session.rung is None:
        raise InputError(f"{folder}: the check has not found anything yet")
    if (
        session.path[0].comparison is None
        or session.rung.comparison is None
        or session.rung.diagnosis is None
    ):
        raise InputError(f"{folder}: the check has not ended; go on with `vegrip check {recording}`")
    data = described(read_recording(recording), recording)
    again = [f"vegrip check {shlex.quote(str(recording))} -o {shlex.quote(str(folder))}"]
    return model_report(account_of_check(session, data, again, versions()))


def _refined(file: Path) -> dict[str, Any]:
    told = _read(file)
    if missing := [name for name in NEEDED if name not in told]:
        raise InputError(f"{file} lacks {', '.join(missing)}; make it again with `vegrip refine --report`")
    return told


def _read(file: Path) -> dict[str, Any]:
    try:
        told = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{file} cannot be read: {error}") from None
    if not isinstance(told, dict):
        raise InputError(f"{file} is no report")
    return told
