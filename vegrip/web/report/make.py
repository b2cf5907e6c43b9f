"""Make the report of what a folder holds: a recording, a run, a check, or what `refine --report` wrote."""

import json
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vegrip.errors import InputError, UsageError
from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.account import account, described, effects_of, versions
from vegrip.identification.experiment.design import next_experiment
from vegrip.identification.fit import noise_of
from vegrip.identification.recording import read_recording
from vegrip.identification.recording.folder import TOML, existing_folder
from vegrip.identification.recording.session import is_run, summarise_run
from vegrip.model import ContactModel, read_model
from vegrip.web.axes import Axes, extent
from vegrip.web.check.session import CHECK_FILE, load
from vegrip.web.figures import WIDE
from vegrip.web.markup import commands, document, facts, legend, listed, section, table, versions_line
from vegrip.web.report.methods import methods_of_run
from vegrip.web.report.model_report import account_of_check, model_report

Answer = Mapping[str, Any]
FAULTY = 0.01  # share of the time under a fault from which on it is said


def run_report(answer: Answer, commands_run: list[str], versions: Answer) -> str:
    """Return the report of :func:`~vegrip.identification.recording.session.summarise_run`."""
    fingers = answer["fingers"]
    parts = (
        section("what happened", listed(_findings(answer))),
        section("fingers", _fingers(fingers)),
        section("nodes", _nodes(answer["nodes"])),
        *(section(name, _finger(name, one)) for name, one in fingers.items()),
        section("data", facts({"run": answer["folder"], **answer["about"]})),
        methods_of_run(answer, versions),
        section("how to make this again", commands(commands_run)),
    )
    return document(answer["name"], "".join(parts), versions_line(versions))


def _findings(answer: Answer) -> list[str]:
    fingers = answer["fingers"]
    slips = sum(one["slips"] for one in fingers.values())
    said = [f"{slips} slips were felt" if slips else "no slip was felt"]
    bounds = {name: one["bound_lowest"] for name, one in fingers.items() if one["bound_lowest"] is not None}
    if bounds:
        worst = min(bounds, key=lambda name: bounds[name])
        said.append(f"the lowest bound of a margin was {bounds[worst]:.2f}, at {worst}")
    said += [
        f"{name}: {_percent(one['fault'])} of its commands were held for a fault ({_shares(one['reasons'])})"
        for name, one in fingers.items()
        if one["fault"] > FAULTY
    ]
    said += [
        f"{name}: the model did not explain {100.0 * (1.0 - one['consistent']):.0f} % of the reports"
        + (f"; suspects: {', '.join(one['suspects'])}" if one["suspects"] else "")
        for name, one in fingers.items()
        if one.get("consistent", 1.0) < 1.0 - FAULTY
    ]
    return said


def _fingers(fingers: Answer) -> str:
    head = (
        "finger", "time [s]", "slips", "mean force [N]", "largest force [N]", "lowest bound", "5 % bound",
        "below 0", "under a fault", "why",
    )  # fmt: skip
    rows = [
        (
            name, f"{one['duration']:.0f}", one["slips"], _two(one["force_mean"]), _two(one["force_max"]),
            _two(one["bound_lowest"]), _two(one["bound_q05"]), _percent(one["below_zero"]),
            _percent(one["fault"]), _shares(one["reasons"]),
        )
        for name, one in fingers.items()
    ]  # fmt: skip
    return table(head, rows, numbers=range(1, 9))


def _nodes(nodes: Answer) -> str:
    head = ("node", "out [Hz]", "p50 [ms]", "p99 [ms]", "max [ms]", "late", "dropped", "refused")
    rows = [
        (
            name, _two(one["rate_out"]), _ms(one["latency_p50"]), _ms(one["latency_p99"]),
            _ms(one["latency_max"]), _two(one["deadline_misses"]), _two(one["dropped"]), one["rejected"],
        )
        for name, one in nodes.items()
    ]  # fmt: skip
    note = '<p class="soft">p50 and p99: medians over the reports of the node; max: of the whole run.</p>'
    return table(head, rows, numbers=range(1, 7)) + note


def _finger(name: str, one: Answer) -> str:
    margin = _margins(name, one["traces"])
    force = _forces(name, one["traces"])
    return f"<figure>{margin}</figure><figure>{force}</figure>"


def _margins(name: str, traces: Answer) -> str:
    margin, bound = traces["margin"], traces["bound"]
    if margin is None or bound is None:
        return ""
    axes = Axes(
        extent(margin["time"], room=0.0),
        (min(-0.05, *bound["low"]), 1.0),
        "time [s]",
        "margin and bound [1]",
        WIDE,
    )
    axes.line(axes.x, (0.0, 0.0), "red", **{"stroke-dasharray": "4 3"})
    axes.band(margin["time"], margin["low"], margin["high"], "band")
    axes.line(margin["time"], margin["high"], "blue")
    axes.line(bound["time"], bound["low"], "orange", **{"stroke-width": 1.2})
    return legend(("blue", "margin"), ("orange", "its lower bound")) + axes.svg(f"{name}: margin over time")


def _forces(name: str, traces: Answer) -> str:
    command, force = traces["command"], traces["normal_force"]
    if command is None:
        return ""
    values = [*command["low"], *command["high"], *((force or {}).get("high", []))]
    axes = Axes(extent(command["time"], room=0.0), extent([0.0, *values]), "time [s]", "force [N]", WIDE)
    if force is not None:
        axes.line(force["time"], force["high"], "blue")
    axes.line(command["time"], command["high"], "orange", **{"stroke-dasharray": "5 4"})
    lines = (("blue", "estimated normal force"), ("orange dash", "commanded"))
    return legend(*lines) + axes.svg(f"{name}: force over time")


def _shares(reasons: Answer) -> str:
    ordered = sorted(reasons.items(), key=lambda item: -item[1])
    return ", ".join(
        f"{name.replace('_', ' ')} {100.0 * share:.0f} %" for name, share in ordered if share >= 0.005
    )


def _two(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}".removesuffix(".00")


def _percent(value: float | None) -> str:
    return "–" if value is None else f"{100.0 * value:.1f} %"


def _ms(value: float | None) -> str:
    return "–" if value is None else f"{value / 1e3:.2f}"


REFINED = "report.json"
NEEDED = (
    "ladder",
    "verdict",
    "data",
    "effects",
    "diagnosis",
    "before",
    "after",
    "parameters",
    "warnings",
    "versions",
)


def make_report(
    what: Path, model: ContactModel | None, model_file: Path | None, report: Callable[[str], None]
) -> str:
    """Return the report of ``what`` as HTML; ``report`` gets each step as a sentence."""
    if (existing_folder(what) / TOML).is_file():
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
    effects = effects_of(read_model(folder / session.rung.model))
    return model_report(account_of_check(session, data, effects, again, versions()))


def _refined(file: Path) -> dict[str, Any]:
    answer = _read(file)
    if missing := [name for name in NEEDED if name not in answer]:
        raise InputError(f"{file} lacks {', '.join(missing)}; make it again with `vegrip refine --report`")
    return answer


def _read(file: Path) -> dict[str, Any]:
    try:
        answer = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{file} cannot be read: {error}") from None
    if not isinstance(answer, dict):
        raise InputError(f"{file} is no report")
    return answer
