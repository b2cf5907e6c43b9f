"""``vegrip calibrate``: a new fingertip, step by step to its model."""

import re
import shlex
import sys
from collections.abc import Mapping
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON, OPENS, PORT
from vegrip.cli._terminal import announce_page, answer, figures, printer, progress
from vegrip.config import parse_toml, toml_value
from vegrip.errors import InputError, UsageError, VegripError
from vegrip.whole_file import write_whole, writing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vegrip.identification.calibration.plan import Known
    from vegrip.identification.calibration.session import Calibration, Ended, Standing
    from vegrip.identification.experiment.design_space import RigLimits

FRICTION_PLACES = (
    ("[node.parameters.friction]", ""),
    ("[node.parameters]", "friction."),
    ("", "parameters.friction."),
)
"""Headers within the [[node]], and what stands before a key of ``friction`` below them."""
MAX_ROUNDS = 2  # an end may find effects that ask for further trials
FOLDER = Annotated[Path, typer.Argument(help="Keeps everything; made when absent, gone on with when there.")]
RADIUS = Annotated[str, typer.Option("--radius", help="Of the fingertip, e.g. '9 mm'; asked for at first.")]
TAKE = Annotated[
    Path | None, typer.Option("--take", metavar="RECORDING", help="The recording of the trial asked for.")
]
KIND = Annotated[str, typer.Option("--kind", help="Of what is taken: press, hold, slide or twist.")]
NODE = Annotated[str, typer.Option("--node", help="Record the next trial from this running node.")]
FINGER = Annotated[str, typer.Option(help="Of the node.")]
VIRTUAL = Annotated[
    int | None, typer.Option("--virtual", metavar="SEED", min=0, help="Do all trials on a virtual fingertip.")
]
DROP = Annotated[int, typer.Option("--drop", metavar="N", min=0, help="Forget trial N.")]
END = Annotated[bool, typer.Option("--end", help="Look for missing effects, write model and report.")]
LAUNCH = Annotated[
    Path | None,
    typer.Option(
        help="With --end: launch file, or map, to write how slip is felt into: learning is then on."
    ),
]
LIMITS = Annotated[
    Path | None, typer.Option("--limits", metavar="TOML", help="depth, force, speed, ... of the rig in SI.")
]
DEPTH = Annotated[float | None, typer.Option("--depth", help="Greatest indentation [m]; else 12 % of R.")]
MOST_FORCE = Annotated[
    float | None, typer.Option("--normal-force", help="Greatest normal force [N]; else 5.")
]
SPEED = Annotated[float | None, typer.Option("--speed", help="Fastest motion along the normal [m/s].")]
PULL = Annotated[float | None, typer.Option("--tangential-force", help="Greatest pull [N]; 0: cannot pull.")]
TORQUE = Annotated[float | None, typer.Option("--torque", help="Greatest torque [N m]; 0: cannot twist.")]
ASK = Annotated[bool, typer.Option("--ask/--no-ask", help="Ask in the terminal for what is next.")]
WEB = Annotated[bool, typer.Option("--web", help="Guide on a page in the browser.")]


def calibrate(
    folder: FOLDER,
    radius: RADIUS = "",
    take: TAKE = None,
    kind: KIND = "",
    node: NODE = "",
    finger: FINGER = "index",
    virtual: VIRTUAL = None,
    drop: DROP = 0,
    end: END = False,
    launch: LAUNCH = None,
    limits: LIMITS = None,
    depth: DEPTH = None,
    normal_force: MOST_FORCE = None,
    speed: SPEED = None,
    tangential_force: PULL = None,
    torque: TORQUE = None,
    ask: ASK = True,
    web: WEB = False,
    port: PORT = 8522,
    opens: OPENS = False,
    as_json: JSON = False,
) -> None:
    """Guide a new fingertip through press, hold, slide and twist to a model with errors.

    It says which trial is next from what is not yet known, writes its motion for a rig and its words for
    a person, checks what was recorded, and says what to record again. At the end it looks for effects that
    the model lacks and writes model, errors and a report into FOLDER. Started again it goes on.

    Example: vegrip calibrate tip --radius '9 mm'
    """
    own = {
        "depth": depth,
        "force": normal_force,
        "speed": speed,
        "tangential_force": tangential_force,
        "torque": torque,
    }
    if web:
        _serve(folder, radius, own, limits, node, port, opens=opens)
        return
    asks = ask and sys.stdin.isatty() and not (as_json or take or drop or end or virtual is not None)
    if launch is not None and not (end or asks or virtual is not None):
        raise UsageError("--launch belongs to the end of a calibration; add --end")
    if launch is not None and not launch.is_file():
        raise InputError(f"{launch}: there is no such launch file")
    calibration = _opened(folder, radius, limits, own, virtual)
    if drop:
        calibration.drop(drop)
    if take is not None:
        _take(calibration, take, kind, say=not as_json)
    elif node and not asks:
        _record(calibration, node, finger, kind, say=not as_json)
    standing = _judged(calibration)
    if asks:
        end, standing = _guide(calibration, standing, node, finger)
    ended = _ended(calibration) if end else None
    if virtual is not None:
        standing, ended = _practised(calibration, standing, virtual, say=not as_json)
    if as_json or not asks or ended is not None:
        told = _as_dict(calibration, standing, ended)
        answer(told, lambda: _print(calibration, standing, ended), as_json=as_json)
    if virtual is not None and ended is not None and not as_json:
        _print_truth(virtual, ended.known)
    if ended is not None:
        _use_slip(ended, launch, folder, say=not as_json)


def _opened(
    folder: Path, radius: str, limits: Path | None, own: dict[str, float | None], virtual: int | None
) -> "Calibration":
    from vegrip.cli.experiment import rig_limits
    from vegrip.identification.calibration import session
    from vegrip.identification.calibration.trials import practice_tip
    from vegrip.identification.recording.units import parse_length

    found = session.load(folder)
    given: RigLimits = rig_limits(limits, own)
    metres = parse_length(radius, "--radius") if radius else None
    if virtual is not None:
        stated, metres = metres, practice_tip(virtual).radius
        if stated is not None and not isclose(stated, metres, rel_tol=1e-3):
            raise UsageError(
                f"the virtual fingertip {virtual} has a radius of {metres:.4g} m; leave --radius out"
            )
    if found is not None:
        if metres is not None and metres != found.radius:
            raise UsageError(f"{folder} is the calibration of a fingertip of radius {found.radius:g} m")
        found.limits = session.other_limits(found.limits, given)
        return found
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: is no calibration; give another folder")
    if metres is None:
        raise UsageError("state the radius of the fingertip: --radius '9 mm'")
    made = session.Calibration(folder, metres, session.usual_limits(given, metres))
    session.save(made)
    return made


def _judged(calibration: "Calibration") -> "Standing":
    from vegrip.identification.calibration.session import NEXT, judge, save
    from vegrip.identification.simulate import write_protocol

    with progress("calibrate") as report:
        standing = judge(calibration, report)
    save(calibration)
    motion = calibration.folder / NEXT
    motion.unlink(missing_ok=True)
    if standing.next.trial is not None:
        write_protocol(standing.next.trial.protocol, motion, "\n".join(standing.next.trial.words))
    return standing


def _take(calibration: "Calibration", path: Path, kind: str, *, say: bool) -> None:
    from vegrip.identification.calibration.session import save
    from vegrip.identification.recording import read_recording

    done = calibration.take(read_recording(path), kind)
    save(calibration)
    if say:
        typer.echo(f"taken: {done.kind} ({done.name})")
        for problem in done.problems:
            typer.echo(f"record again: {problem}")


def _record(calibration: "Calibration", node: str, finger: str, kind: str, *, say: bool) -> None:
    import tempfile

    from vegrip.cli.record import record_from_node
    from vegrip.identification.calibration.session import judge
    from vegrip.identification.recording.session import read_fingers

    trial = judge(calibration).next.trial
    seconds = 30.0 if trial is None else trial.protocol.duration + 5.0
    with tempfile.TemporaryDirectory(prefix="vegrip-calibrate-") as scratch:
        target = Path(scratch) / "trial"
        record_from_node(node, target, seconds)
        fingers = read_fingers(target, announce=False)
        if finger not in fingers:
            raise UsageError(f"{node} has no finger {finger!r}; it has {', '.join(fingers)}")
        _take(calibration, target / finger, kind, say=say)


def _practised(
    calibration: "Calibration", standing: "Standing", seed: int, *, say: bool
) -> "tuple[Standing, Ended]":
    from vegrip.identification.calibration.session import MOST_TRIALS
    from vegrip.identification.calibration.trials import practice_tip, practise

    tip, ended = practice_tip(seed), None
    for _ in range(MAX_ROUNDS):
        while standing.next.trial is not None and len(calibration.trials) < MOST_TRIALS:
            trial = standing.next.trial
            done = calibration.take(practise(trial, tip, seed + len(calibration.trials)))
            if say:
                told = "; ".join(done.problems) or "good"
                typer.echo(f"{len(calibration.trials)}. {trial.kind}: {trial.protocol.name}: {told}")
            standing, ended = _judged(calibration), None
        if ended is None:
            ended = _ended(calibration)
            standing = _judged(calibration)
    assert ended is not None  # noqa: S101
    return standing, ended


def _guide(
    calibration: "Calibration", standing: "Standing", node: str, finger: str
) -> "tuple[bool, Standing]":
    while True:
        _print(calibration, standing, None)
        if standing.next.trial is None:
            typer.echo("Nothing more is to be recorded.")
            return bool(calibration.trials), standing
        how = f"Enter = record {node} now, or " if node else ""
        typer.echo(f"{how}the folder of its recording, drop N, end, or quit: ", nl=False)
        answer = sys.stdin.readline()
        word = answer.strip()
        if not answer or word == "quit":
            return False, standing
        if word == "end":
            return True, standing
        try:
            if word.startswith("drop "):
                calibration.drop(int(word[5:]) if word[5:].isdecimal() else 0)
            elif word:
                _take(calibration, Path(word), "", say=True)
            elif node:
                _record(calibration, node, finger, "", say=True)
            standing = _judged(calibration)
        except VegripError as error:  # said, and asked again: what was recorded is kept
            typer.echo(f"vegrip: {error}")


def _ended(calibration: "Calibration") -> "Ended":
    from vegrip.identification.calibration.session import REPORT, finish
    from vegrip.web.report.model_report import model_report

    command = f"vegrip calibrate {shlex.quote(str(calibration.folder))} --end"
    with progress("calibrate") as report:
        ended = finish(calibration, command, report)
    write_whole(calibration.folder / REPORT, model_report(ended.account))
    return ended


def _as_dict(calibration: "Calibration", standing: "Standing", ended: "Ended | None") -> dict[str, Any]:
    from vegrip.identification.calibration.session import MODEL, NEXT, REPORT

    trial = standing.next.trial
    return {
        "folder": str(calibration.folder),
        "radius": calibration.radius,
        "trials": [
            {"kind": one.kind, "name": one.name, "good": one.is_good, "problems": one.problems}
            for one in calibration.trials
        ],
        "parameters": {one.symbol: one.as_dict() for one in standing.known},
        "error": None if standing.fit is None else standing.fit.error,
        "next": None if trial is None else trial.as_dict(),
        "why": standing.next.why,
        "left_out": dict(standing.next.left_out),
        "misfit": standing.misfit,
        "again": calibration.again,
        "motion": None if trial is None else str(calibration.folder / NEXT),
        "ended": None if ended is None else ended.as_dict(),
        "model": None if ended is None else str(calibration.folder / MODEL),
        "report": None if ended is None else str(calibration.folder / REPORT),
    }


def _print(calibration: "Calibration", standing: "Standing", ended: "Ended | None") -> None:
    from vegrip.identification.calibration.session import MODEL, NEXT, REPORT

    console = printer()
    known = ended.known if ended is not None else standing.known
    if known:
        _print_known(known)
    for sentence in calibration.again:
        console.print(f"record again: {sentence}")
    for one, why in standing.next.left_out.items():
        console.print(f"left out: {one}: {why}")
    if ended is not None:
        effects = f" with {', '.join(ended.added)}" if ended.added else ""
        console.print(f"the paper's model{effects}: {ended.error:.2f} times the noise, {ended.verdict}")
        for group in ended.account["diagnosis"]["indistinguishable"]:
            console.print(f"not separated by what was recorded: {', '.join(group)}")
        console.print(f"written: {calibration.folder / MODEL}, {calibration.folder / REPORT}", soft_wrap=True)
        return
    if standing.misfit:
        console.print(standing.misfit)
    console.print(standing.next.why, style="bold")
    trial = standing.next.trial
    if trial is None:
        console.print(f"end it with: vegrip calibrate {calibration.folder} --end", soft_wrap=True)
        return
    console.print(f"next: {trial.kind}: {trial.protocol.name} ({trial.protocol.duration:.0f} s)")
    for sentence in trial.words:
        console.print(f"- {sentence}")
    console.print(f"the motion for a rig: {calibration.folder / NEXT}", soft_wrap=True)
    console.print(
        f"then: vegrip calibrate {calibration.folder} --take RECORDING", soft_wrap=True, markup=False
    )


def _use_slip(ended: "Ended", launch: Path | None, folder: Path, *, say: bool) -> None:
    from vegrip.grip.friction_settings import FrictionSettings

    slip, settings = ended.slip, ended.slip.settings
    if launch is not None and not settings:
        raise InputError(f"nothing is written into {launch}: {slip.lacking}")
    if launch is not None:
        write_friction(launch, settings, f"measured by vegrip calibrate {folder}: {slip.bracket}")
    if not say:
        return
    if not settings:
        typer.echo(f"friction is not learned: {slip.lacking}")
        return
    typer.echo(f"slip is felt {slip.bracket}, {1e3 * slip.delay:.0f} ms late ({slip.slides} slides)")
    if why := FrictionSettings(slip_threshold=slip.threshold, slip_delay=slip.delay).why_too_coarse:
        typer.echo(f"so friction is learned, but not probed: {why}")
    values = ", ".join(f"friction.{key} = {str(value).lower()}" for key, value in settings.items())
    where = f"written into {launch}" if launch is not None else "to learn friction by it add --launch FILE"
    typer.echo(f"{where}: {values}")


def _print_known(known: Any) -> None:
    head = ("parameter", "value", "std", "wanted", "unit", "effect", "")
    table = figures(*head, left=("parameter", "unit", "effect", ""))
    for one in known:
        sizes = [f"{100 * v:.3g} %" if one.is_log else f"{v:.2g}" for v in (one.std, one.goal)]
        said = "known" if one.is_known else "not yet known"
        table.add_row(one.symbol, f"{one.value:.4g}", *sizes, one.unit, one.effect, said)
    printer().print(table)


def _print_truth(seed: int, known: "Sequence[Known]") -> None:
    from vegrip.identification.calibration.trials import practice_tip, true_values

    true = true_values(practice_tip(seed))
    told = [
        f"{one.symbol} {true[one.symbol]:.4g} ({one.errors_off(true[one.symbol]):+.1f} std)"
        for one in known
        if one.symbol in true
    ]
    typer.echo(f"the fingertip's own values, and how far off they were found: {', '.join(told)}")


def _serve(
    folder: Path,
    radius: str,
    own: dict[str, float | None],
    limits: Path | None,
    node: str,
    port: int,
    *,
    opens: bool,
) -> None:
    from vegrip.web import require_web

    require_web()
    from vegrip.web.calibrate.controller import run

    if radius or (folder / "calibration.json").is_file():
        _opened(folder, radius, limits, own, None)  # what cannot be is refused before a page opens

    run(folder, node, port, announce_page("calibration page"), opens=opens)


def write_friction(path: Path, settings: Mapping[str, Any], by: str) -> None:
    """Write ``settings`` as ``friction`` of the grip controller of a launch file, or of a map."""
    from vegrip.transport.mapped.writer import changed_text

    try:
        text = path.read_text(encoding="utf-8")
        table = parse_toml(text)
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path} cannot be read as a launch file: {error}") from None
    lines = {key: toml_value(value) for key, value in settings.items()}
    if "node" in table:
        text = _in_launch(text, lines, by)
    else:
        text = changed_text(text, [(["friction", key], value) for key, value in settings.items()])
    if not _is_in(text, settings):
        wanted = ", ".join(f"parameters.friction.{key} = {value}" for key, value in lines.items())
        raise InputError(
            f'{path}: has no node with program = "grasp_force" that can be added to; write into yours: '
            f"{wanted}"
        )
    with writing(path):
        write_whole(path, text)


def _is_in(text: str, settings: Mapping[str, Any]) -> bool:
    try:
        table = parse_toml(text)
    except (ValueError, RecursionError):  # parameters in braces, or said twice
        return False
    given = [one.get("parameters", {}).get("friction", {}) for one in table.get("node", [])]
    return any(settings.items() <= one.items() for one in (*given, table.get("friction", {})))


def _in_launch(text: str, values: Mapping[str, str], by: str) -> str:
    lines = text.split("\n")
    program = next(
        (n for n, one in enumerate(lines) if re.match(r"""\s*program\s*=\s*["']grasp_force["']""", one)), None
    )
    if program is None:
        return text
    later = (n for n in range(program, len(lines)) if lines[n].lstrip().startswith("[["))
    end = next(later, len(lines))
    for header, prefix in FRICTION_PLACES:
        at = next(
            (n for n in range(program, end) if header and lines[n].split("#")[0].strip() == header), None
        )
        if at is None and header:
            continue
        begin = program if at is None else at
        keys = "|".join(re.escape(prefix + key) for key in values)
        kept = [one for one in lines[begin + 1 : end] if not re.match(rf"\s*({keys})\s*=", one)]
        new = [f"{prefix}{key} = {value} # {by}" for key, value in values.items()]
        return "\n".join([*lines[: begin + 1], *new, *kept, *lines[end:]])
    return text
