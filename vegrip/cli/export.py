"""``vegrip export``: the estimator for firmware and what it learned there, a model for MuJoCo."""

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON, group
from vegrip.cli._outputs import FORCE, claim_file, claim_folder
from vegrip.cli._terminal import answer, complain, print_json, printer
from vegrip.config import build, read_toml
from vegrip.errors import InputError, UsageError
from vegrip.whole_file import reading, write_whole, writing

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vegrip.export import Exported, Request
    from vegrip.identification.recording.report import LoadReport

app = group(
    "Write the estimator for firmware, or a model for other programs; read what firmware has learned.\n\n"
    "Example: vegrip sample press.toml && vegrip export c press.toml -o firmware"
)
CONTROL = ("grip", "limits", "fail_safe", "watchdog")
"""Tables of a finger; those of an estimator are taken as well."""
Model = Annotated[Path, typer.Argument(help="Model file.")]


@app.command("c")
def c_(
    model: Model,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write to.")],
    entry: Annotated[
        str, typer.Option(help="What is exported: estimator; finger: all from frame to frame.")
    ] = "estimator",
    precision: Annotated[
        str, typer.Option(help="Of all numbers: double; float, for processors without double.")
    ] = "double",
    prefix: Annotated[str, typer.Option(help="Beginning of every name in C.")] = "vg",
    fingers: Annotated[
        str, typer.Option(help="Of a finger's hand, in the order of their numbers, as in its launch file.")
    ] = "thumb,index,middle,ring,little",
    settings: Annotated[
        Path | None,
        typer.Option(
            help="TOML file with tables as in launch files: [noise], [estimator] and [friction]; of a finger "
            "also [grip], [limits], [fail_safe] and [watchdog]."
        ),
    ] = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Write C99 of the model's estimator, or of the whole finger, with self-test, examples and a report.

    Example: vegrip sample press.toml && vegrip export c press.toml -o firmware
    """
    from vegrip.export import Request, write_export
    from vegrip.export.precision import ENTRIES, PRECISIONS
    from vegrip.model import read_model

    _check(entry, ENTRIES, "--entry")
    _check(precision, tuple(PRECISIONS), "--precision")
    request = Request(
        read_model(model),
        **_settings(settings, () if entry == "estimator" else CONTROL),
        prefix=prefix,
        precision=precision,
        entry=entry,
        fingers=tuple(name.strip() for name in fingers.split(",")),
    )
    claim_folder(output, force=force)
    with writing(output):
        exported = write_export(request, output)
    answer(_as_dict(exported, precision), lambda: _show(request, exported, output), as_json=as_json)


@app.command("mujoco")
def mujoco_(
    model: Model,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="MJCF file to write, for <include>.")
    ] = None,
    mass: Annotated[
        float,
        typer.Option(help="Effective mass, in kg: 1 / (1/fingertip + 1/object); the force goes with it."),
    ] = 0.03,
    hold: Annotated[float, typer.Option(help="The force after this hold is fitted, in s.")] = 1.0,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Write MuJoCo's solref, solimp and friction nearest to MODEL, and in numbers what they cannot represent.

    Example: vegrip sample press.toml && vegrip export mujoco press.toml -o fingertip.xml
    """
    from vegrip.bridges.mujoco_contact import nearest_contact
    from vegrip.model import read_model

    for name, value, high in (("--mass", mass, 1e3), ("--hold", hold, 1e4)):
        if not 1e-6 <= value <= high:
            raise UsageError(f"{name} is {value:g}; give 1e-6 to {high:g}")
    if output is not None:
        claim_file(output, force=force)
    nearest = nearest_contact(read_model(model), mass, hold)
    if output is not None:
        with writing(output):
            write_whole(output, str(nearest))

    def say() -> None:
        for line in nearest.misfit.sentences() if output else [str(nearest)]:
            typer.echo(line)
        if output is not None:
            typer.echo(f"{output}: written")

    answer(nearest.to_json(), say, as_json=as_json)


@app.command("mcap")
def mcap_(
    recording: Annotated[Path, typer.Argument(help="Recording or session.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="MCAP file to write.")],
    verdict: Annotated[
        list[Path] | None, typer.Option(help="What vegrip diagnose -o wrote, to be an event; repeatable.")
    ] = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Write a recording as MCAP of ROS 2 types: WrenchStamped, vegrip_msgs, slips and verdicts as a log.

    Example: vegrip sample press && vegrip export mcap press -o press.mcap
    """
    from vegrip.bridges.ros2_mcap import write_ros2_mcap
    from vegrip.identification.recording.report import account

    claim_file(output, force=force)
    verdicts = [_verdict(one) for one in verdict or []]
    with writing(output):
        count, reports = write_ros2_mcap(recording, output, verdicts)
    _warn(recording, reports)
    answer(
        {"file": str(output), "messages": count, "rows": account(reports)},
        lambda: typer.echo(f"{output}: {count} messages"),
        as_json=as_json,
    )


def _verdict(path: Path) -> tuple[str, str, str]:
    """Return what ``diagnosis.json``, or the folder with it, says: level of a log, recording, sentence."""
    file = path / "diagnosis.json" if path.is_dir() else path
    with reading(file):
        try:
            found = json.loads(file.read_bytes())
            verdict, named, close = found["verdict"], found["named"], found["indistinguishable"]
            said = {
                "adequate": "the model lacks nothing that shows",
                "named": f"the model lacks {', '.join(named)}",
                "ambiguous": f"the model lacks one of {', '.join(close[0] if close else ['?'])}",
                "unexplained": "the model lacks what no effect of the catalogue explains",
            }
            level = "info" if verdict == "adequate" else "warning"
            return level, str(found["recording"]), f"diagnosis, {verdict}: {said[verdict]}"
        except (ValueError, LookupError, TypeError) as error:
            raise InputError(f"{file}: is no diagnosis.json of `vegrip diagnose` ({error})") from None


@app.command("lerobot")
def lerobot_(
    recording: Annotated[Path, typer.Argument(help="Recording or session.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the data set.")],
    fps: Annotated[
        int, typer.Option(min=0, max=10_000, help="Frames a second; 0 = as many as there are rows.")
    ] = 0,
    task: Annotated[str, typer.Option(help="What is done, in words.")] = "hold an object",
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Write a recording as a data set of LeRobot: wrench, margin and its bound, friction of every finger.

    Example: vegrip sample press && vegrip export lerobot press -o touch
    """
    from vegrip.identification.recording.lerobot import SET_LAYOUT, write_lerobot
    from vegrip.identification.recording.report import account

    claim_folder(output, force=force)
    written = write_lerobot(recording, output, fps=fps, task=task)
    _warn(recording, written.reports)
    for finger, count in written.gaps.items():
        complain(f"{recording}: {count} frames lie in gaps of {finger}, from which nothing came: NaN there")
    info = written.info
    counts = {name: info[name] for name in ("total_episodes", "total_frames", "fps")}
    figures = {"folder": str(output), "layout": SET_LAYOUT, **counts, "features": sorted(info["features"])}
    figures |= {"rows": account(written.reports), "rows_between": written.between, "gap_frames": written.gaps}
    words = (
        f"{output}: {counts['total_frames']} frames, {counts['total_episodes']} episodes, layout {SET_LAYOUT}"
    )
    words += f"; {written.between} rows lie between frames and are in none" if written.between else ""
    answer(figures, lambda: typer.echo(words), as_json=as_json)


def _warn(recording: Path, reports: "Iterable[LoadReport]") -> None:
    """Say what of a recording could not be read."""
    for report in reports:
        for sentence in report.warnings():
            complain(f"{recording}: {sentence}")


@app.command("learned")
def learned(
    model: Model,
    numbers: Annotated[
        Path, typer.Argument(help="What PREFIX_save() wrote: raw little-endian doubles, or a number a line.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Model file to write.")],
    settings: Annotated[Path | None, typer.Option(help="The TOML file given to the export.")] = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Put what firmware has learned about a contact into a model file; NUMBERS are from the export of MODEL.

    Example: vegrip sample press.toml && vegrip export c press.toml -o firmware &&
    vegrip export learned press.toml firmware/examples/finger.txt -o learned.toml
    """
    from vegrip.export.saved import learned_model, read_numbers
    from vegrip.model import read_model, write_model
    from vegrip.parameters import absolute

    claim_file(output, force=force)
    chosen = _settings(settings, CONTROL)  # the file may have been that of a finger
    chosen.pop("control", None)
    found = learned_model(read_model(model), read_numbers(numbers), **chosen)
    write_model(found, output)
    values = {
        symbol: {"value": one.value, "std": absolute(found.parameters[symbol][1], one.value, one.std)}
        for symbol, one in found.values.items()
    }
    if as_json:
        print_json({"file": str(output), "parameters": values})
        return
    for symbol, one in values.items():
        typer.echo(f"{symbol:24} {one['value']:.6g} +- {one['std']:.2g}")
    typer.echo(f"{output}: written")


def _check(value: str, known: tuple[str, ...], option: str) -> None:
    if value not in known:
        raise UsageError(f"{option} {value!r} is not possible; there is {', '.join(known)}")


def _settings(path: Path | None, control: tuple[str, ...]) -> dict[str, Any]:
    from vegrip.estimator import EstimatorSettings, SensorNoise
    from vegrip.grip.settings import ControlSettings

    if path is None:
        return {}
    table = read_toml(path)
    tables = ["noise", "estimator", "friction", *control]
    unknown = sorted(set(table) - set(tables))
    if unknown:
        known = ", ".join(f"[{name}]" for name in tables)
        raise InputError(f"{path}: there is no table [{unknown[0]}] here; there are {known}")
    chosen = {name: table[name] for name in ("friction", *control) if name in table}
    return {
        "control": build(ControlSettings, chosen, str(path)),
        "noise": build(SensorNoise, table.get("noise", {}), f"{path} [noise]"),
        "settings": build(EstimatorSettings, table.get("estimator", {}), f"{path} [estimator]"),
    }


def _as_dict(exported: "Exported", precision: str) -> dict[str, Any]:
    from vegrip.export.precision import PRECISIONS

    measured = exported.measured
    host, run = measured.host, measured.host_run
    return {
        "files": [str(path) for path in exported.files],
        "text_bytes": host.flash if host else None,
        "ram_bytes": exported.ram,
        "stack_bytes": max(host.stack.values(), default=None) if host else None,
        "largest_difference": run.largest if run else None,
        "frames": run.frames if run else None,
        "passed": run.passed if run else None,
        "compiler": host.compiler if host else None,
        PRECISIONS[precision].processor["core"]: {
            "text_bytes": measured.cortex.flash if measured.cortex else None,
            "stack_bytes": max(measured.cortex.stack.values(), default=None) if measured.cortex else None,
            "run": dataclasses.asdict(measured.cortex_run) if measured.cortex_run else None,
        },
        "not_measured": list(measured.missing),
    }


def _show(request: "Request", exported: "Exported", folder: Path) -> None:
    console, measured = printer(), exported.measured
    for path in exported.files:
        console.print(str(path))
    console.print(
        f"\na finger takes {exported.ram} bytes of memory; sizes and agreement are in {folder}/REPORT.md"
    )
    for run in (measured.host_run, measured.cortex_run):
        if run is not None:
            verdict = f"PASS {run.frames} frames" if run.passed else "FAIL"
            console.print(f"{run.machine}: {verdict}, {run.equal} of {run.numbers} numbers equal to the bit")
    for what in measured.missing:
        console.print(f"not measured: {what} is not installed")
    header = f"{folder}/{request.prefix}_{request.entry}.h"
    console.print(f"build and test it yourself: make -C {folder}; begin with {header}")
