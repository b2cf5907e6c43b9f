"""Runs ``vegrip calibrate`` for the page, and keeps what it answered."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from html import escape
from pathlib import Path
from typing import Any

from starlette.routing import Route

from vegrip.errors import UsageError
from vegrip.web import markup
from vegrip.web.axes import Axes, extent
from vegrip.web.figures import bar
from vegrip.web.job_page import Actions, JobPage, job_routes
from vegrip.web.server import serve

Answer = Mapping[str, Any]
MOTION_SIZE = (640, 210)  # [px]
TRIAL_KINDS = ("press", "hold", "slide", "twist")


def standing(answer: Answer | None) -> tuple[str, str]:
    """Return level and name of where a calibration stands."""
    if answer is None:
        return "unknown", "not begun"
    if answer["ended"] is not None:
        return ("ok" if answer["ended"]["verdict"] in ("adequate", "named") else "warn"), "model written"
    if answer["next"] is None:
        return "ok", "nothing more to record"
    return "warn", f"next: {answer['next']['kind']}"


def body(answer: Answer | None, *, node: str, is_busy: bool) -> str:
    if answer is None:
        return _begin(is_busy=is_busy)
    return "".join(
        (
            _path(answer),
            '<div class="overview">',
            _ended(answer) if answer["ended"] is not None else _next(answer, node, is_busy=is_busy),
            _known(answer),
            "</div>",
            _trials(answer, is_busy=is_busy),
            _finish(answer, is_busy=is_busy),
        )
    )


def _begin(*, is_busy: bool) -> str:
    radius = markup.entry("radius", "radius", is_busy=is_busy, id="radius", value="9 mm", size=8)
    force = markup.entry("greatest normal force [N]", "force", is_busy=is_busy, id="force", value=5, size=5)
    seed = markup.entry("on a virtual fingertip, number", "seed", is_busy=is_busy, id="seed", value=3, size=4)
    return markup.section(
        "a new fingertip",
        markup.form("begin", "begin", radius, force, is_busy=is_busy, kind="main"),
        "<p>Four kinds of trials lead to a model: press, hold, slide, twist. A rig does them from a file of "
        "motion, a person by the words; each is recorded and taken here.</p>",
    ) + markup.section("or see it done", markup.form("practise", "do all trials", seed, is_busy=is_busy))


def _path(answer: Answer) -> str:
    good = {one["kind"] for one in answer["trials"] if one["good"]}
    tried = {one["kind"] for one in answer["trials"]}
    coming = answer["next"]["kind"] if answer["next"] is not None else ""
    cells = []
    for kind in TRIAL_KINDS:
        level, said = (
            ("ok", "done") if kind in good else ("bad", "again") if kind in tried else ("unknown", "")
        )
        if kind in answer["left_out"]:
            level, said = "unknown", answer["left_out"][kind]
        elif kind == coming:
            level, said = ("warn", "next, once more" if kind in good else "next")
        cells.append(f'<li class="{level}"><b>{kind}</b> <span>{escape(said)}</span></li>')
    return f'<ol class="steps">{"".join(cells)}</ol>'


def _next(answer: Answer, node: str, *, is_busy: bool) -> str:
    trial = answer["next"]
    if trial is None:
        lead = f'<p class="lead">{escape(answer["why"])}</p>'
        return markup.section("what is next", lead, "<p>End the calibration below.</p>")
    words = "".join(f"<li>{escape(one)}</li>" for one in trial["words"])
    return markup.section(
        f"next: {trial['kind']}",
        f'<p class="lead">{escape(trial["name"])}, {trial["duration"]:.0f} s</p>',
        f'<p class="soft">{escape(answer["why"])}</p><figure>{draw_motion(trial["motion"])}</figure>',
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
    kinds = "".join(
        f"<option{markup.attributes(selected=kind == asked)}>{kind}</option>" for kind in TRIAL_KINDS
    )
    folder = markup.entry(
        "its recording", "recording", is_busy=is_busy, id="trial-recording", placeholder="folder"
    )
    kind = markup.choice("of a", "kind", kinds, is_busy=is_busy, id="kind")
    return markup.form("take", "take", folder, kind, is_busy=is_busy, kind="main")


def _recording(node: str, *, is_busy: bool) -> str:
    given = {"id": "node", "value": node or "grasp_force", "size": 14}
    source = markup.entry("or record it now from node", "node", is_busy=is_busy, **given)
    finger = markup.entry("finger", "finger", is_busy=is_busy, value="index", size=7)
    return markup.form("record", "record", source, finger, is_busy=is_busy)


def _ended(answer: Answer) -> str:
    ended = answer["ended"]
    added = ", ".join(one.replace("_", " ") for one in ended["added"])
    more = ""
    if answer["next"] is not None:
        more = f"<p>{escape(answer['why'])}: a further {escape(answer['next']['kind'])} would show it.</p>"
    return markup.section(
        "the model",
        markup.huge_error(ended["error"]),
        f"<p>the paper's model{escape(f' with {added}' if added else '')}: "
        f'<b id="verdict">{escape(ended["verdict"])}</b></p>',
        f"<p>Written: <code>{escape(answer['model'])}</code>, <code>{escape(answer['report'])}</code></p>",
        more,
        f"<p>{markup.button('go on with further trials', 'look', is_busy=False)}</p>",
    )


def _known(answer: Answer) -> str:
    known = answer["ended"]["parameters"] if answer["ended"] is not None else answer["parameters"]
    if not known:
        return markup.section("what is known", "<p>Nothing yet.</p>")
    rows = [
        (
            symbol,
            f"{one['value']:.4g}",
            markup.unit_name(one["unit"]),
            markup.spread(one, "std"),
            markup.spread(one, "goal"),
            markup.Markup(
                bar(min(one["goal"] / one["std"], 1.0) if one["std"] else 1.0, is_bad=not one["known"])
            ),
            markup.Markup(
                '<span class="ok">known</span>' if one["known"] else '<span class="bad">not yet</span>'
            ),
        )
        for symbol, one in known.items()
    ]
    misfit = f'<p class="warn">{escape(answer["misfit"])}</p>' if answer["misfit"] else ""
    head = ("", "value", "unit", "std", "target", "", "")
    return markup.section("what is known", markup.table(head, rows, numbers=(1, 3, 4)), misfit)


def _trials(answer: Answer, *, is_busy: bool) -> str:
    if not answer["trials"]:
        return ""
    rows = [
        (
            i,
            one["kind"],
            one["name"],
            markup.Markup(_problems(one["problems"])),
            markup.Markup(markup.button("drop", "drop", is_busy=is_busy, data_number=i)),
        )
        for i, one in enumerate(answer["trials"], 1)
    ]
    head = ("no.", "kind", "motion", "what it lacks", "")
    return markup.section("trials", markup.table(head, rows, numbers=(0,), identifier="trials"))


def _problems(problems: Sequence[str]) -> markup.Markup:
    if not problems:
        return markup.Markup('<span class="ok">good</span>')
    return markup.Markup(f'<span class="bad">record again: {escape("; ".join(problems))}</span>')


def _finish(answer: Answer, *, is_busy: bool) -> str:
    if not answer["trials"] or answer["ended"] is not None:
        return ""
    main = "main" if answer["next"] is None else ""
    return markup.section(
        "the end",
        "<p>Looks for effects that the model lacks, and writes model and report.</p>",
        f"<p>{markup.button('end the calibration', 'end', is_busy=is_busy, class_=main, id='end')}</p>",
    )


class Calibrator(JobPage):
    """The state of a calibration and the command that is going on; any thread may call it.

    Args:
        folder: of the calibration.
        node: that trials are recorded from; empty: none is proposed.

    """

    kept = "what was recorded"

    def __init__(self, folder: Path, node: str = "") -> None:
        super().__init__()
        self.folder, self.node = folder, node
        self.answer: dict[str, Any] | None = None

    @property
    def has_begun(self) -> bool:
        return (self.folder / "calibration.json").is_file()

    def refresh(self) -> None:
        if self.has_begun:
            self._start("judging what there is")

    def begin(self, radius: str, force: str = "") -> None:
        """Begin with a fingertip."""
        if not radius.strip():
            raise UsageError("state the radius of the fingertip, e.g. 9 mm")
        limit = ["--normal-force", force.strip()] if force.strip() else []
        self._start("planning the first trial", "--radius", radius.strip(), *limit)

    def take(self, recording: str, kind: str = "") -> None:
        """Take the recording of a trial."""
        if not recording.strip():
            raise UsageError("give the folder of the recording")
        chosen = ["--kind", kind] if kind else []
        self._start("looking at the recording", "--take", recording.strip(), *chosen)

    def record(self, node: str, finger: str) -> None:
        """Record the next trial from a running node."""
        if not node.strip():
            raise UsageError("name the running node, e.g. grasp_force")
        self.node = node.strip()
        self._start("recording", "--node", self.node, "--finger", finger.strip() or "index", "--no-ask")

    def practise(self, seed: int) -> None:
        self._start("a virtual fingertip is measured", "--virtual", str(seed))

    def drop(self, number: int) -> None:
        self._start("without that trial", "--drop", str(number))

    def end(self) -> None:
        self._start("looking for what the model lacks", "--end")

    def motion(self) -> Path | None:
        found = (self.answer or {}).get("motion")
        return Path(found) if found and Path(found).is_file() else None

    def shown(self) -> dict[str, Any]:
        level, name = standing(self.answer)
        html = body(self.answer, node=self.node, is_busy=self.job is not None)
        return {"name": self.folder.resolve().name, "level": level, "verdict": name, "body": html}

    def _start(self, what: str, *options: str) -> None:
        with self._lock:
            self._be_free()
            self.error = ""
            self._run(what, ["calibrate", str(self.folder), *options], self._store)

    def _store(self, answer: dict[str, Any]) -> None:
        self.answer = answer

    def _fail(self, answer: dict[str, Any] | None) -> None:
        if answer is None:  # it did nothing: what is shown is what leads here
            self.commands = self.commands[:-1]


def routes(calibrator: Calibrator) -> list[Route]:
    actions: Actions = {
        "begin": lambda answer: calibrator.begin(str(answer["radius"]), str(answer["force"])),
        "take": lambda answer: calibrator.take(str(answer["recording"]), str(answer.get("kind", ""))),
        "record": lambda answer: calibrator.record(str(answer["node"]), str(answer["finger"])),
        "practise": lambda answer: calibrator.practise(int(answer["seed"])),
        "drop": lambda answer: calibrator.drop(int(answer["number"])),
        "end": lambda _: calibrator.end(),
        "look": lambda _: calibrator.refresh(),
        "stop": lambda _: calibrator.stop(),
    }
    return job_routes("calibrate", "trial", calibrator, actions)


def run(folder: Path, node: str, port: int, announce: Callable[[str], None], *, opens: bool = False) -> None:
    """Guide a calibration on a page."""
    with closing(Calibrator(folder, node)) as calibrator:
        calibrator.refresh()
        serve(routes(calibrator), port, announce, opens=opens)
