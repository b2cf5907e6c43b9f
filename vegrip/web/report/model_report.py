"""The report of a model against a recording: from the account of a diagnosis or of a check. Pure."""

from collections.abc import Mapping
from typing import Any

from vegrip.identification.compare.where import format_quantity
from vegrip.web.check.render import VERDICTS, channels, comparison, parameters, ranking, where
from vegrip.web.check.session import Rung, Session
from vegrip.web.figures import ladder
from vegrip.web.markup import commands, document, facts, legend, listed, section, spread, table, versions_line
from vegrip.web.report.methods import methods_of_model

Account = Mapping[str, Any]


def model_report(answer: Account) -> str:
    """Return the report of an :func:`~vegrip.identification.diagnosis.account.account`."""
    last = Rung("", None, None, answer["ladder"][-1]["error"], answer["after"], answer["diagnosis"])
    last.parameters, last.warnings = answer["parameters"], answer["warnings"]
    added = [rung["effect"] for rung in answer["ladder"] if rung["effect"] is not None]
    parts = (
        f'<div class="overview">{_result(answer, added)}{section("ladder of errors", _ladder(answer))}</div>',
        section("what was measured", _data(answer["data"])),
        _calibration(answer.get("calibration")),
        section("where the first model failed", where(answer["before"]), channels(answer["before"])),
        ranking(last, [], is_busy=False, has_buttons=False),
        comparison(answer["after"], ("the first model", answer["before"]) if added else None),
        parameters(last),
        section("what remains unknown", _unknown(answer)),
        methods_of_model(answer),
        section("how to make this again", commands(answer["commands"])),
    )
    return document(answer["data"]["name"], "".join(parts), versions_line(answer["versions"]))


def account_of_check(
    session: Session,
    data: Account,
    effects: list[dict[str, Any]],
    commands_run: list[str],
    versions: Account,
) -> dict[str, Any]:
    """Return the account of what a check has found, up to the model that is looked at."""
    path = session.path
    diagnosed = [rung for rung in path if rung.diagnosis is not None]
    first = path[0]
    last = path[-1]
    return {
        "ladder": [{"effect": rung.effect, "error": rung.error} for rung in path if not rung.is_refit],
        "verdict": last.diagnosis["verdict"] if last.diagnosis is not None else "unexplained",
        "data": data,
        "effects": effects,
        "diagnosis": diagnosed[-1].diagnosis if diagnosed else None,
        "before": first.comparison,
        "after": last.comparison,
        "parameters": last.parameters,
        "warnings": last.warnings,
        "commands": commands_run,
        "versions": versions,
    }


def _result(answer: Account, added: list[str]) -> str:
    level, name, sentence = VERDICTS[answer["verdict"]]
    if answer["verdict"] == "named":
        level, name, sentence = "ok", "named", "what was added explains the misfit"
    errors = [rung["error"] for rung in answer["ladder"]]
    change = f"{errors[0]:.2f} → {errors[-1]:.2f}" if added else f"{errors[-1]:.2f}"
    model = f"with {', '.join(one.replace('_', ' ') for one in added)}" if added else "as it was"
    return section(
        f"the model {model}",
        f'<p><span class="chip {level}">{name}</span></p>',
        f'<p class="huge">{change} <small>times the noise</small></p>',
        f"<p>{sentence}</p>",
        channels(answer["after"]),
    )


def _ladder(answer: Account) -> str:
    lines = (("blue", "fitted"), ("orange dash", "held-out episodes"), ("green dash", "noise"))
    return legend(*lines) + ladder(answer["ladder"])


def _data(data: Account) -> str:
    ranges = {
        name.replace("_", " "): f"{format_quantity(_kind(name), low)} to {format_quantity(_kind(name), high)}"
        for name, (low, high) in data["channels"].items()
    }
    return facts(
        {
            "recording": data["folder"],
            "SHA-256 of its table": data["sha256"] or "-",
            "rows": data["rows"],
            "duration": f"{data['duration']:.1f} s in {data['episodes']} episodes",
            "radius of the fingertip": format_quantity("contact_radius", data["tip_radius"]),
            **ranges,
        }
    )


def _calibration(answer: Account | None) -> str:
    if answer is None:
        return ""
    trials = [
        (i, one["kind"], one["name"], "; ".join(one["problems"]) or "good")
        for i, one in enumerate(answer["trials"], 1)
    ]
    known = [
        (
            symbol,
            f"{one['value']:.4g}",
            spread(one, "std"),
            spread(one, "goal"),
            "known" if one["known"] else "not known well enough",
        )
        for symbol, one in answer["known"].items()
    ]
    again = listed(answer["again"]) if answer["again"] else "<p>Nothing has to be recorded again.</p>"
    return section(
        "calibration",
        table(("trial", "kind", "motion", "what it lacks"), trials, numbers=(0,)),
        "<h3>how well each parameter is known</h3>",
        table(("symbol", "value", "standard error", "wanted", ""), known, numbers=(1, 2, 3)),
        f"<h3>to record again</h3>{again}",
    )


def _kind(channel: str) -> str:
    """Return the quantity of a channel: both components of the tangential force are one."""
    return channel.removesuffix("_x").removesuffix("_y")


def _unknown(answer: Account) -> str:
    found = answer["diagnosis"]
    said = list(answer["warnings"])
    if found is not None:
        said += [f"not separated: {', '.join(group)}" for group in found["indistinguishable"]]
        if found["unexplained"]:
            said.append(found["unexplained"]["note"])
        said += [f"{name} could not be seen: {reason}" for name, reason in found["out_of_sight"].items()]
        said += found["doubts"]
    return listed(said) or "<p>Nothing that this recording could show.</p>"
