"""``vegrip calibrate --drive``: a drive is stepped on a stiff object, and its map is written as measured."""

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from vegrip.cli._outputs import claim_file
from vegrip.cli._terminal import answer, printer, progress
from vegrip.clock import Clock, WallClock
from vegrip.config import toml_value
from vegrip.errors import UsageError
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.connect.drive_response import DriveResponse, Found
    from vegrip.connect.drive_sweep import SweepPlan
    from vegrip.transport.hands.bench import Source
    from vegrip.transport.maps.map_text import Setting


def calibrate_drive(
    path: Path,
    allowed: float | None,
    *,
    is_agreed: bool,
    force: bool,
    as_json: bool,
    clock: Clock | None = None,
) -> None:
    """Measure the drive of the launch file ``path`` up to ``allowed`` [N]; ``clock`` is that of the run."""
    from vegrip.connect.drive_response import respond
    from vegrip.connect.drive_sweep import bench_of, opened, plan_sweep
    from vegrip.connect.measured_drive import measured_map, measured_settings

    bench, stated = bench_of(path)
    source = bench.drive
    assert source is not None  # noqa: S101 (asked by bench_of)
    if allowed is not None and not 0.0 < allowed <= stated:
        raise UsageError(
            f"--normal-force is {allowed:g} N; {path} allows more than 0 and at most {stated:g} N"
        )
    most = stated if allowed is None else allowed
    if math.isinf(most):
        raise UsageError(
            "state the largest force that object, pads and gripper bear, as --normal-force 60 [N]"
        )
    plan = plan_sweep(source.plan.hand.drive, most)
    target = _target(path, source, force=force)
    measured_map(source, [])  # a map that cannot be written is refused before anything moves
    if not is_agreed:
        _ask(source, plan)
    clock = clock or WallClock()
    with progress("drive") as report, opened(bench, clock) as rig:
        run = rig.run(plan, report)
    found = respond(run)
    settings = measured_settings(source, found)
    write_whole(target, measured_map(source, settings))
    result = {
        **found.as_dict(),
        "settings": {".".join(key): value for key, value in settings},
        "written": str(target),
    }
    answer(result, lambda: _print(found, settings, source, target, path), as_json=as_json)


def _target(launch: Path, source: "Source", *, force: bool) -> Path:
    """Return the file to write: the map itself with --force, else a copy beside the launch file."""
    from vegrip.transport.maps.map_text import FOLDER

    is_own = FOLDER not in source.path.absolute().parents
    if is_own and force:
        return source.path
    target = launch.parent / f"{source.path.stem}-measured.toml"
    claim_file(target, force=force)
    return target


def _ask(source: "Source", plan: "SweepPlan") -> None:
    if not sys.stdin.isatty():
        raise UsageError("the jaws will move, and there is no terminal to ask in; add --yes")
    typer.echo(
        f"{source.where} is made ready, by which its jaws may move through their whole stroke; then it "
        f"closes on the object, is set to {plan.levels[0]:g} to {plan.levels[-1]:g} N, never more, for "
        f"about {plan.seconds:.0f} s, and opens. Hold a stiff object between the pads, "
        "fingers out; Ctrl-C opens.",
        err=True,
    )
    typer.confirm("begin", abort=True, err=True)


def _print(
    found: "DriveResponse", settings: "list[Setting]", source: "Source", target: Path, launch: Path
) -> None:
    console = printer()
    low, high = found.range
    console.print(f"{source.where}, from {low:g} to {high:g} N, as the pads feel it:", style="bold")
    console.print(
        f"- gain {_of(found.gain, 3)}, offset {_of(found.offset, 2)} N; the line is wrong by at most "
        f"{found.curved:.2f} N"
    )
    console.print(f"- delay {1e3 * found.delay.value:.0f} ± {1e3 * found.delay.std:.0f} ms to half of a step")
    if found.loosens:
        console.print(f"- hysteresis {_of(found.hysteresis, 2)} N between up and down")
        console.print(f"- {_of_steps(found)}")
    else:
        console.print("- a smaller force loosens no grip that stands; [drive] keeps its hysteresis and steps")
    for path, value in settings:
        console.print(f"  {'.'.join(path)} = {toml_value(value)}", soft_wrap=True)
    use = "" if target == source.path else f'; to grip by it write drive = "{target.name}" into {launch}'
    console.print(f"written: {target}{use}", soft_wrap=True)


def _of_steps(found: "DriveResponse") -> str:
    if not math.isnan(found.resolution.value):
        return f"steps of {_of(found.resolution, 2)} N"
    if not math.isnan(found.finer):
        return f"steps finer than {found.finer:.2f} N, what was tried or can be felt; [drive] keeps its own"
    return "no step was seen in the fine settings: they are coarser; [drive] keeps its own"


def _of(found: "Found", digits: int) -> str:
    return f"{found.value:.{digits}f} ± {found.std:.{digits}f}"
