"""``vegrip calibrate``: a new fingertip, step by step to its model."""

import shlex
import sys
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._drive import calibrate_drive
from vegrip.cli._options import JSON, OPENS, PORT
from vegrip.cli._outputs import FORCE
from vegrip.cli._terminal import announce_page, answer, printer, progress
from vegrip.cli._weight import weigh
from vegrip.cli._written_settings import write_settings
from vegrip.display.text import figures
from vegrip.errors import InputError, UsageError, VegripError
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vegrip.identification.calibration.plan import Known
    from vegrip.identification.calibration.session import Calibration, Ended, Standing
    from vegrip.identification.experiment.design_space import RigLimits

MAX_ROUNDS = 2  # an end may find effects that ask for further trials
FOLDERS = Annotated[
    list[Path] | None,
    typer.Argument(
        help="Keeps everything; made when absent, gone on with when there. With --weight: recordings of "
        "lifts, or with --node the folder that keeps one."
    ),
]
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
        help="Launch file, or map, to write into: with --end how slip is felt, so that learning is on; with "
        "--weight the gain."
    ),
]
WEIGHT = Annotated[
    list[str] | None,
    typer.Option("--weight", help="Measure tangential gains: of a lifted weight, e.g. 0.5 [kg] or '500 g'."),
]
SECONDS = Annotated[
    float, typer.Option(min=2.0, max=600.0, help="With --weight and --node: how long is recorded [s].")
]
HAND = Annotated[
    Path | None, typer.Option("--map", help="With --weight: map of the hand of a CAN log, or launch file.")
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
DRIVE = Annotated[
    Path | None,
    typer.Option(
        "--drive",
        metavar="BENCH.toml",
        help="Measure the drive of a launch file on a stiff object, up to --normal-force.",
    ),
]
YES = Annotated[bool, typer.Option("--yes", help="With --drive: do not ask before the jaws move.")]
WEB = Annotated[bool, typer.Option("--web", help="Guide on a page in the browser.")]


def calibrate(
    folders: FOLDERS = None,
    radius: RADIUS = "",
    take: TAKE = None,
    kind: KIND = "",
    node: NODE = "",
    finger: FINGER = "index",
    virtual: VIRTUAL = None,
    drop: DROP = 0,
    end: END = False,
    launch: LAUNCH = None,
    weight: WEIGHT = None,
    seconds: SECONDS = 15.0,
    hand: HAND = None,
    limits: LIMITS = None,
    depth: DEPTH = None,
    normal_force: MOST_FORCE = None,
    speed: SPEED = None,
    tangential_force: PULL = None,
    torque: TORQUE = None,
    ask: ASK = True,
    web: WEB = False,
    drive: DRIVE = None,
    yes: YES = False,
    force: FORCE = False,
    port: PORT = 8522,
    opens: OPENS = False,
    as_json: JSON = False,
) -> None:
    """Guide a new fingertip through press, hold, slide and twist to a model with errors.

    It says which trial is next from what is not yet known, writes its motion for a rig and its words for
    a person, checks what was recorded, and says what to record again. At the end it looks for effects that
    the model lacks and writes model, errors and a report into FOLDER. Started again it goes on.

    Example: vegrip calibrate tip --radius '9 mm'

    --weight measures with a lifted weight by how much tangential forces read wrong: open the fingers,
    lift it, and hold it still for three seconds, live (--node) or in a recording.

    Example of it: vegrip sample lift && vegrip calibrate lift --weight 0.5

    --drive steps a gripper up and down on a stiff object, and writes gain, steps, delay and hysteresis
    into a copy of its map, with --force into the map itself. It needs --normal-force, or limits.max_force
    in the launch file.
    """
    others: dict[str, object] = {
        "--radius": radius,
        "--take": take,
        "--kind": kind,
        "--drop": drop,
        "--end": end,
    }
    others |= {"--limits": limits, "--web": web, "--virtual": virtual is not None}
    if drive is not None:
        rest = {**others, "--weight": weight, "--map": hand, "--node": node, "--launch": launch}
        rest |= {"a folder": folders, "--depth": depth, "--speed": speed}
        rest |= {"--tangential-force": tangential_force, "--torque": torque}
        _refuse(rest, "does not go with --drive")
        calibrate_drive(drive, normal_force, is_agreed=yes, force=force, as_json=as_json)
        return
    _refuse({"--yes": yes, "--force": force}, "belongs to --drive")
    if weight or hand is not None:
        does = "does not go with" if weight else "belongs to"
        _refuse(others if weight else {"--map": hand}, f"{does} --weight")
        weigh(folders or [], weight or [], node, seconds, hand, launch, as_json=as_json)
        return
    folder = _only(folders or [])
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
    if launch is not None:
        _require_launch(launch, is_end=end or asks or virtual is not None)
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
        result = _as_dict(calibration, standing, ended)
        answer(result, lambda: _print(calibration, standing, ended), as_json=as_json)
    if virtual is not None and ended is not None and not as_json:
        _print_truth(virtual, ended.known)
    if ended is not None:
        _use_slip(ended, launch, folder, say=not as_json)


def _refuse(options: dict[str, object], why: str) -> None:
    for name, value in options.items():
        if value:
            raise UsageError(f"{name} {why}")


def _require_launch(launch: Path, *, is_end: bool) -> None:
    if not is_end:
        raise UsageError("--launch belongs to the end of a calibration; add --end")
    if not launch.is_file():
        raise InputError(f"{launch}: there is no such launch file")


def _only(folders: list[Path]) -> Path:
    if len(folders) != 1:
        given = f"{len(folders)} are given" if folders else "none is given"
        raise UsageError(f"name the folder of the calibration, as in: vegrip calibrate tip ({given})")
    return folders[0]


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
                result = "; ".join(done.problems) or "good"
                typer.echo(f"{len(calibration.trials)}. {trial.kind}: {trial.protocol.name}: {result}")
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
        write_settings(launch, "friction", settings, f"measured by vegrip calibrate {folder}: {slip.bracket}")
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
    result = [
        f"{one.symbol} {true[one.symbol]:.4g} ({one.errors_off(true[one.symbol]):+.1f} std)"
        for one in known
        if one.symbol in true
    ]
    typer.echo(f"the fingertip's own values, and how far off they were found: {', '.join(result)}")


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
