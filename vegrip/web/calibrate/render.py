"""The calibration page as HTML, from what ``vegrip calibrate --json`` prints. Pure."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from vegrip.web.axes import Axes, extent
from vegrip.web.figures import bar
from vegrip.web.markup import (
    Markup,
    attributes,
    button,
    choice,
    entry,
    form,
    huge_error,
    section,
    spread,
    table,
    unit_name,
)

Told = Mapping[str, Any]
MOTION_SIZE = (640, 210)  # [px]
TRIAL_KINDS = ("press", "hold", "slide", "twist")


def standing(told: Told | None) -> tuple[str, str]:
    """Return level and name of where a calibration stands."""
    if told is None:
        return "unknown", "not begun"
    if told["ended"] is not None:
        return ("ok" if told["ended"]["verdict"] in ("adequate", "named") else "warn"), "model written"
    if told["next"] is None:
        return "ok", "nothing more to record"
    return "warn", f"next: {told['next']['kind']}"


def body(told: Told | None, *, node: str, is_busy: bool) -> str:
    if told is None:
        return _begin(is_busy=is_busy)
    return "".join(
        (
            _path(told),
            '<div class="overview">',
            _ended(told) if told["ended"] is not None else _next(told, node, is_busy=is_busy),
            _known(told),
            "</div>",
            _trials(told, is_busy=is_busy),
            _finish(told, is_busy=is_busy),
        )
    )


def _begin(*, is_busy: bool) -> str:
    radius = entry("radius", "radius", is_busy=is_busy, id="radius", value="9 mm", size=8)
    force = entry("greatest normal force [N]", "force", is_busy=is_busy, id="force", value=5, size=5)
    seed = entry("on a virtual fingertip, number", "seed", is_busy=is_busy, id="seed", value=3, size=4)
    return section(
        "a new fingertip",
        form("begin", "begin", radius, force, is_busy=is_busy, kind="main"),
        "<p>Four kinds of trials lead to a model: press, hold, slide, twist. A rig does them from a file of "
        "motion, a person by the words; each is recorded and taken here.</p>",
    ) + section("or see it done", form("practise", "do all trials", seed, is_busy=is_busy))


def _path(told: Told) -> str:
    good = {one["kind"] for one in told["trials"] if one["good"]}
    tried = {one["kind"] for one in told["trials"]}
    coming = told["next"]["kind"] if told["next"] is not None else ""
    cells = []
    for kind in TRIAL_KINDS:
        level, said = (
            ("ok", "done") if kind in good else ("bad", "again") if kind in tried else ("unknown", "")
        )
        if kind in told["left_out"]:
            level, said = "unknown", told["left_out"][kind]
        elif kind == coming:
            level, said = ("warn", "next, once more" if kind in good else "next")
        cells.append(f'<li class="{level}"><b>{kind}</b> <span>{escape(said)}</span></li>')
    return f'<ol class="steps">{"".join(cells)}</ol>'


def _next(told: Told, node: str, *, is_busy: bool) -> str:
    trial = told["next"]
    if trial is None:
        lead = f'<p class="lead">{escape(told["why"])}</p>'
        return section("what is next", lead, "<p>End the calibration below.</p>")
    words = "".join(f"<li>{escape(one)}</li>" for one in trial["words"])
    return section(
        f"next: {trial['kind']}",
        f'<p class="lead">{escape(trial["name"])}, {trial["duration"]:.0f} s</p>',
        f'<p class="soft">{escape(told["why"])}</p><figure>{draw_motion(trial["motion"])}</figure>',
        f"<ol>{words}</ol>",
        '<p><a id="motion" href="/motion" download>the motion for a rig (TOML, SI units)</a></p>',
        _taking(trial["kind"], is_busy=is_busy),
        _recording(node, is_busy=is_busy),
    )


def draw_motion(motion: Mapping[str, Sequence[Any]]) -> str:
    """Draw the motion of a trial.

    Args:
        motion: ``t`` [s], ``depth`` [m], and ``moves``: begin and end [s] and name of each pull and twist.

    """
    t = list(motion["t"])
    depth = [1e3 * value for value in motion["depth"]]
    axes = Axes(extent(t, room=0.0), extent(depth), "time without the pauses [s]", "depth [mm]", MOTION_SIZE)
    for begin, end, name in motion["moves"]:
        colour = "orange" if name == "pull" else "violet"
        axes.line((begin, end), (max(depth), max(depth)), colour, **{"stroke-width": 6, "opacity": 0.7})
    axes.line(t, depth, "blue")
    said = {"pull": "orange: pull along the surface", "twist": "violet: twist"}
    names = dict.fromkeys(name for _, _, name in motion["moves"])
    legend = "; ".join(said[name] for name in names)
    return axes.svg("motion of the trial") + (f'<p class="soft">{legend}</p>' if legend else "")


def _taking(asked: str, *, is_busy: bool) -> str:
    kinds = "".join(f"<option{attributes(selected=kind == asked)}>{kind}</option>" for kind in TRIAL_KINDS)
    folder = entry("its recording", "recording", is_busy=is_busy, id="trial-recording", placeholder="folder")
    kind = choice("of a", "kind", kinds, is_busy=is_busy, id="kind")
    return form("take", "take", folder, kind, is_busy=is_busy, kind="main")


def _recording(node: str, *, is_busy: bool) -> str:
    given = {"id": "node", "value": node or "grasp_force", "size": 14}
    source = entry("or record it now from node", "node", is_busy=is_busy, **given)
    finger = entry("finger", "finger", is_busy=is_busy, value="index", size=7)
    return form("record", "record", source, finger, is_busy=is_busy)


def _ended(told: Told) -> str:
    ended = told["ended"]
    added = ", ".join(one.replace("_", " ") for one in ended["added"])
    more = ""
    if told["next"] is not None:
        more = f"<p>{escape(told['why'])}: a further {escape(told['next']['kind'])} would show it.</p>"
    return section(
        "the model",
        huge_error(ended["error"]),
        f"<p>the paper's model{escape(f' with {added}' if added else '')}: "
        f'<b id="verdict">{escape(ended["verdict"])}</b></p>',
        f"<p>Written: <code>{escape(told['model'])}</code>, <code>{escape(told['report'])}</code></p>{more}",
        f"<p>{button('go on with further trials', 'look', is_busy=False)}</p>",
    )


def _known(told: Told) -> str:
    known = told["ended"]["parameters"] if told["ended"] is not None else told["parameters"]
    if not known:
        return section("what is known", "<p>Nothing yet.</p>")
    rows = [
        (
            symbol,
            f"{one['value']:.4g}",
            unit_name(one["unit"]),
            spread(one, "std"),
            spread(one, "goal"),
            Markup(bar(min(one["goal"] / one["std"], 1.0) if one["std"] else 1.0, is_bad=not one["known"])),
            Markup('<span class="ok">known</span>' if one["known"] else '<span class="bad">not yet</span>'),
        )
        for symbol, one in known.items()
    ]
    misfit = f'<p class="warn">{escape(told["misfit"])}</p>' if told["misfit"] else ""
    head = ("", "value", "unit", "std", "target", "", "")
    return section("what is known", table(head, rows, numbers=(1, 3, 4)), misfit)


def _trials(told: Told, *, is_busy: bool) -> str:
    if not told["trials"]:
        return ""
    rows = [
        (
            i,
            one["kind"],
            one["name"],
            Markup(_problems(one["problems"])),
            Markup(button("drop", "drop", is_busy=is_busy, data_number=i)),
        )
        for i, one in enumerate(told["trials"], 1)
    ]
    head = ("no.", "kind", "motion", "what it lacks", "")
    return section("trials", table(head, rows, numbers=(0,), identifier="trials"))


def _problems(problems: Sequence[str]) -> Markup:
    if not problems:
        return Markup('<span class="ok">good</span>')
    return Markup(f'<span class="bad">record again: {escape("; ".join(problems))}</span>')


def _finish(told: Told, *, is_busy: bool) -> str:
    if not told["trials"] or told["ended"] is not None:
        return ""
    main = "main" if told["next"] is None else ""
    return section(
        "the end",
        "<p>Looks for effects that the model lacks, and writes model and report.</p>",
        f"<p>{button('end the calibration', 'end', is_busy=is_busy, class_=main, id='end')}</p>",
    )
