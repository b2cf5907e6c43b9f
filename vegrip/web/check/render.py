"""The check page as HTML, from what a check has found. Pure."""

import shlex
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from vegrip.web.check.session import Rung, Session
from vegrip.web.figures import (
    bar,
    in_noise,
    ladder,
    over_law,
    over_phases,
    over_time,
    over_variable,
    residual_over_time,
    short_name,
)
from vegrip.web.markup import (
    Markup,
    attributes,
    button,
    choice,
    entry,
    form,
    huge_error,
    legend,
    listed,
    section,
    table,
    unit_name,
)

Answer = Mapping[str, Any]
VERDICTS = {
    "adequate": ("ok", "adequate", "nothing is missing that this recording can show"),
    "named": ("warn", "an effect is missing", "what is named below explains the misfit: add it"),
    "ambiguous": ("warn", "ambiguous", "several effects explain the misfit equally well"),
    "unexplained": ("bad", "unexplained misfit", "no effect of the catalogue explains it"),
}
MAX_FINE_ERROR = 1.05  # error over noise up to which a model that is not diagnosed yet is not called a misfit


def verdict(rung: Rung) -> tuple[str, str, str]:
    """Return level, name and sentence of what is known of a model."""
    if rung.diagnosis is not None:
        return VERDICTS[rung.diagnosis["verdict"]]
    if rung.error > MAX_FINE_ERROR:
        return "bad", "unexplained misfit", f"the model leaves {rung.error:.2f} times the noise"
    return "unknown", "not diagnosed", f"the model leaves {rung.error:.2f} times the noise"


Beside = tuple[str, Answer]
"""Name and comparison of a model that is shown beside another."""


def body(
    session: Session,
    *,
    is_busy: bool,
    beside: int | None = None,
    other: Beside | None = None,
    node: str = "grasp_force",
) -> str:
    """Return the page below its header.

    Args:
        session: what was found.
        is_busy: whether something runs, and nothing can be pressed.
        beside: place of the model to compare with; None = the one before.
        other: a model that is not of this check, to compare with instead.
        node: that the model may be written into.

    """
    rung = session.rung
    if rung is None:
        return '<section class="card"><h3>The first model is being fitted</h3></section>'
    shown = other or _beside(session, beside)
    return "".join(
        (
            '<div class="overview">',
            _verdict(session, rung, is_busy=is_busy),
            _ladder(session, is_busy=is_busy),
            "</div>",
            ranking(rung, session.effects, is_busy=is_busy),
            _law(rung, is_busy=is_busy),
            _beside_card(session, rung, shown, beside, is_busy=is_busy),
            comparison(rung.comparison, shown),
            _held_out(rung),
            '<div class="overview">',
            parameters(rung),
            _held_back_card(rung, is_busy=is_busy)
            + _experiment(rung, is_busy=is_busy)
            + _use(rung, node, is_busy=is_busy),
            "</div>",
        )
    )


def comparison(answer: Answer | None, beside: Beside | None = None) -> str:
    """Return measured against modelled, and the residual by regime and over every variable."""
    if answer is None or "curves" not in answer:
        return ""
    name, other = beside or ("", {})
    return "".join(
        _channel(channel, answer["channels"].get(channel), curves, name, other.get("curves", {}).get(channel))
        for channel, curves in answer["curves"].items()
    )


def where(answer: Answer | None) -> str:
    """Return in words where the model fails."""
    if answer is None:
        return ""
    notes = [one["note"] for one in answer["where"]] or ["nothing stands out of the noise"]
    if answer.get("repeated"):
        notes.append(answer["repeated"]["note"])
    doubts = [*answer.get("doubts", [])]
    return listed(notes) + (f'<p class="warn">{escape("; ".join(doubts))}</p>' if doubts else "")


def channels(answer: Answer | None) -> str:
    """Return error, noise and coverage of every channel."""
    if answer is None:
        return ""
    rows = [
        (
            name.replace("_", " "),
            f"{one['ratio']:.2f}",
            in_noise(name, one),
            f"{100.0 * one['coverage95']:.0f} %",
        )
        for name, one in answer["channels"].items()
    ]
    return table(("channel", "error / noise", "rms", "within 95 %"), rows, numbers=(1, 3))


def ranking(rung: Rung, have: Sequence[str], *, is_busy: bool, has_buttons: bool = True) -> str:
    """Return what was tried, best first, each with its evidence and a button that adds it."""
    answer = rung.diagnosis
    if answer is None:
        return ""
    tried = [one for one in answer["effects"][:8] if one["name"] not in have]
    if not tried:
        nothing = "<p>No further effect of the catalogue explains anything more.</p>"
        return section("what may be missing", nothing, _undecided(answer))
    most = max([1.0, *(one["heldout_gain"] for one in answer["effects"])])
    named = [place for place, one in enumerate(tried, 1) if one["name"] in answer["named"]]
    rows = [
        _candidate(one, most, named=place in named, has_buttons=has_buttons, is_busy=is_busy)
        for place, one in enumerate(tried, 1)
    ]
    head = ("effect", "evidence [nats]", "held out [nats]", "", "error after / noise", "outcome", "")
    return section(
        "what may be missing",
        _undecided(answer) + table(head, rows, numbers=(1, 2, 4), kind="ranking", named=named),
        '<p class="soft">Evidence: how much better the effect explains the recording, its price paid. '
        "Held out: on episodes that the fit has not seen. An effect that fails a test is no finding.</p>",
    )


def parameters(rung: Rung) -> str:
    rows = [
        (
            symbol,
            _number(one["value"]),
            _number(one.get("std")),
            unit_name(one.get("unit")),
            str(one.get("effect", "")).replace("_", " "),
        )
        for symbol, one in rung.parameters.items()
    ]
    head = ("symbol", "value", "standard error", "unit", "effect")
    return section("parameters", table(head, rows, numbers=(1, 2)), listed(rung.warnings))


def _verdict(session: Session, rung: Rung, *, is_busy: bool) -> str:
    level, name, sentence = verdict(rung)
    added = ", ".join(effect.replace("_", " ") for effect in session.effects)
    undo = "" if rung.parent is None else button("undo", "undo", is_busy=is_busy, id="undo")
    is_judged = rung.diagnosis is not None and rung.comparison is not None
    again = "" if is_judged else button("compare and diagnose", "judge", is_busy=is_busy, id="judge")
    return section(
        f"start model with {added}" if added else "start model",
        f'<p><span id="verdict" class="chip {level}">{name}</span></p>',
        huge_error(rung.error),
        _held_error(rung),
        f"<p>{escape(sentence)}</p>{where(rung.comparison)}{channels(rung.comparison)}",
        f'<p class="acts">{undo} {again}</p>',
        kind="card verdict",
    )


def _held_error(rung: Rung) -> str:
    if rung.held_error is None:
        return ""
    return (
        f"<p>On episodes {escape(rung.held_back)}, which the fit has not seen: "
        f'<b id="held-error">{rung.held_error:.2f}</b> times the noise.</p>'
    )


def _ladder(session: Session, *, is_busy: bool) -> str:
    rungs = [
        {
            "effect": "fit again" if one.is_refit else one.effect,
            "error": one.error,
            "heldout_error": one.held_error,
        }
        for one in session.path
    ]
    held = (
        "; orange, dashed: on the episodes held back" if any(one.held_error for one in session.path) else ""
    )
    buttons = " ".join(
        button(
            f"{escape(_rung_name(session, i))} <small>{one.error:.2f}</small>",
            "look_at",
            is_busy=is_busy,
            id=f"rung-{i}",
            data_place=i,
            aria_pressed=str(i == session.current).lower(),
        )
        for i, one in enumerate(session.rungs)
    )
    return section(
        "ladder of errors",
        ladder(rungs),
        f'<p class="soft">Green, dashed: the noise, the floor of every error{held}.</p>',
        f'<div class="rungs">{buttons}</div>',
    )


def _rung_name(session: Session, place: int) -> str:
    rung = session.rungs[place]
    name = "fit again" if rung.is_refit else short_name(rung.effect)
    return f"{place}: {name}" + (f" on {rung.parent}" if rung.parent is not None else "")


def _beside(session: Session, place: int | None) -> Beside | None:
    if place is None:
        rung = session.rung
        place = rung.parent if rung is not None else None
    if place is None or not 0 <= place < len(session.rungs):
        return None
    rung, other = session.rung, session.rungs[place]
    answer = other.comparison
    if rung is None or other.held_back != rung.held_back:
        return None  # judged on other episodes
    return None if answer is None else (f"model {_rung_name(session, place)}", answer)


def _beside_card(
    session: Session, rung: Rung, shown: Beside | None, beside: int | None, *, is_busy: bool
) -> str:
    choices = '<option value="before">the one before</option>' + "".join(
        f"<option{attributes(value=i, selected=i == beside)}>{escape(_rung_name(session, i))}</option>"
        for i, one in enumerate(session.rungs)
        if one is not rung and one.comparison is not None
    )
    asked = {"id": "beside-place", "data_do": "compare_with"}
    place = choice("beside this one, dashed:", "place", choices, is_busy=is_busy, **asked)
    file = entry("or a model file", "name", is_busy=is_busy, id="beside-file", placeholder="model.toml")
    return section(
        "two models",
        f'<div class="inline">{place}</div>',
        form("compare_with_file", "compare", file, is_busy=is_busy),
        _two_models(rung.comparison, shown) if shown is not None and rung.comparison is not None else "",
        id="beside",
    )


def _two_models(mine: Answer, shown: Beside) -> str:
    name, other = shown
    rows: list[tuple[object, ...]] = [
        (channel.replace("_", " "), f"{one['ratio']:.2f}", _ratio(other["channels"].get(channel)))
        for channel, one in mine["channels"].items()
    ]
    rows.append(
        tuple(Markup(f"<b>{each}</b>") for each in ("all", f"{mine['error']:.2f}", f"{other['error']:.2f}"))
    )
    return table(("error / noise", "this model", name), rows, numbers=(1, 2), kind="narrow")


def _ratio(channel: Answer | None) -> str:
    return "–" if channel is None else f"{channel['ratio']:.2f}"


def _held_back_card(rung: Rung, *, is_busy: bool) -> str:
    now = f"held back now: {escape(rung.held_back)}" if rung.held_back else "now all episodes are fitted"
    given = {"id": "hold-back", "placeholder": "e.g. 2,5..7", "size": 10, "value": rung.held_back}
    return section(
        "hold episodes back",
        form(
            "hold_back", "fit again", entry("episodes", "episodes", is_busy=is_busy, **given), is_busy=is_busy
        ),
        '<p class="soft">The fit leaves them out, and its error on them shows whether the model predicts '
        f"what it has not seen; {now}.</p>",
    )


def _held_out(rung: Rung) -> str:
    if rung.held_out is None:
        return ""
    answer = rung.held_out["curves"].items()
    figures = [f"<figure>{over_time(name, curves)}</figure>" for name, curves in answer]
    return section(f"episodes {rung.held_back}, which the fit has not seen", *figures)


def _experiment(rung: Rung, *, is_busy: bool) -> str:
    rivals = {"id": "candidates", "value": ",".join(_rivals(rung)), "placeholder": "adhesion,guide_friction"}
    asked = form(
        "plan",
        "find an experiment",
        entry("distinguish", "candidates", is_busy=is_busy, **rivals),
        entry("in at most [s]", "duration", is_busy=is_busy, id="duration", size=4, value=60),
        is_busy=is_busy,
    )
    said = ""
    if rung.experiment is not None:
        said = f"<p>{escape(rung.experiment['advice'])}</p>"
        if rung.experiment.get("protocol"):
            said += '<p><a id="motion" href="/motion" download>export the motion (TOML, SI units)</a></p>'
    return section("the next experiment", asked, said)


def _law(rung: Rung, *, is_busy: bool) -> str:
    """Return a card that drafts a law, where no effect explains what is left, and shows it."""
    if rung.draft is None and (rung.diagnosis is None or rung.diagnosis["verdict"] != "unexplained"):
        return ""
    asks = button("draft a law", "draft", is_busy=is_busy, id="draft")
    answer = rung.draft
    if answer is None:
        return section("a law for what is left", f'<p class="acts">{asks}</p>')
    if answer["law"] is None:
        return section("a law for what is left", f"<p>none: {escape(answer['reason'])}</p>")
    error = answer["error"]
    given = {"class_": "main", "id": "add-law", "data_effect": answer["file"]}
    others = [f"as good: {law}" for law in answer["rivals"]]
    return section(
        "a law for what is left",
        f"<p><b>{escape(answer['law'])}</b></p>",
        f"<p>error {error['before']:.2f} → {error['after']:.2f} times the noise; in the {answer['place']}. "
        "A draft is a shape that fits, not physics; what would refute it: "
        f"{escape(answer['experiment'])}</p>",
        listed(others) if others else "",
        legend(("ink-soft", "measured less model"), ("blue", "what the law adds, with its 95 % interval")),
        f"<figure>{over_law(answer['curve'])}</figure>",
        f'<p class="acts">{button("add this law", "add", is_busy=is_busy, **given)}</p>',
        id="law",
    )


def _rivals(rung: Rung) -> list[str]:
    if rung.draft is not None and rung.draft["file"]:
        return [rung.draft["file"], rung.draft["rival"] or "nothing"]
    answer = rung.diagnosis
    if answer is None:
        return []
    if answer["experiment"]:
        return list(answer["experiment"]["between"])
    return [one["name"] for one in answer["effects"][:2]]


def _channel(name: str, error: Answer | None, answer: Answer, other: str, beside: Answer | None) -> str:
    said = f": {error['ratio']:.2f} times the noise" if error is not None else ""
    variables = "".join(
        f"<figure>{over_variable(name, variable, one)}</figure>"
        for variable, one in answer["variables"].items()
    )
    lines = [("measured area measured", "measured, with 95 % of the noise"), ("blue", "model")]
    more = ""
    if variables:
        rms, mean = ("blue", "rms (1 is noise)"), ("orange dash", "mean: measured less model")
        more = f'<h3>residual over what may matter</h3>{legend(rms, mean)}<div class="grid">{variables}</div>'
    return section(
        f"{name.replace('_', ' ')}{said}",
        legend(*lines, *([("orange dash", other)] if beside is not None else [])),
        f"<figure>{over_time(name, answer, beside)}</figure>",
        f"<figure>{residual_over_time(name, answer)}</figure>",
        f"{over_phases(answer['phases'])}{more}",
        kind="card channel",
    )


def _candidate(
    one: Answer, most: float, *, named: bool, has_buttons: bool, is_busy: bool
) -> tuple[object, ...]:
    name = one["name"]
    label = escape(name.replace("_", " "))
    given = {"class_": "main" if named else "", "id": f"add-{name}", "data_effect": name}
    adds = button("add", "add", is_busy=is_busy, **given) if has_buttons else ""
    fails = escape(", ".join(one["failed"])) or '<span class="ok">passes all tests</span>'
    gains = (f"{one['evidence_gain']:.0f}", f"{one['heldout_gain']:.0f}")
    size = Markup(bar(one["heldout_gain"] / most))
    title = Markup(f"<b>{label}</b>" if named else label)
    return (title, *gains, size, f"{one['error_after']:.2f}", Markup(fails), Markup(adds))


def _undecided(answer: Answer) -> str:
    said = [
        f"cannot be distinguished by this recording: {', '.join(group)}"
        for group in answer["indistinguishable"]
    ]
    if answer["unexplained"]:
        said.append(answer["unexplained"]["note"])
    suggestions = (answer["experiment"] or {}).get("suggestions", {})
    said += [f"to distinguish {name}: {text}" for name, text in suggestions.items()]
    said += answer["doubts"]
    return listed([one.replace("_", " ") for one in said])


def _use(rung: Rung, node: str, *, is_busy: bool) -> str:
    name = entry("save as", "name", is_busy=is_busy, id="save-name", value="model.toml")
    goes_on = entry("let a running node go on with it", "node", is_busy=is_busy, id="node-name", value=node)
    return section(
        "use this model",
        form("write_model", "save", name, is_busy=is_busy),
        form("use_in_node", "write into the node", goes_on, is_busy=is_busy),
        f'<p class="soft">It is kept as <code>{escape(shlex.quote(rung.model))}</code> in the folder of this '
        "check.</p>",
    )


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
