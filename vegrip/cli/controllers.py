"""``vegrip controllers``: grip controllers against the least possible force, on the same disturbances."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs
from vegrip.cli._terminal import answer, progress, show, table
from vegrip.errors import UsageError, suggestion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vegrip.trials.fronts import PlantMake, QualityTrial, Surroundings

BOTH = "both"

GRASP = Annotated[
    str,
    typer.Option(
        "--grasp", help="hand: five fingers, the default; pinch: two, the default with --plant mujoco."
    ),
]
SEEDS = Annotated[int, typer.Option("--seeds", "-n", min=1, help="How many scenarios.")]
FIRST = Annotated[int, typer.Option("--first-seed", min=0, help="Of the scenarios.")]
DURATION = Annotated[float, typer.Option("--duration", help="Of each scenario, in s; more than 2.")]
ONLY = Annotated[
    list[str] | None, typer.Option("--only", help="This controller; may be repeated. All when not given.")
]
SWEEP = Annotated[bool, typer.Option("--sweep", help="Each controller over its knob, not at one point.")]
BANDWIDTH = Annotated[
    float | None,
    typer.Option("--drive-bandwidth", help="Of the drives, in Hz; their rate limit goes in proportion."),
]
SCALE = Annotated[float, typer.Option("--friction-scale", help="Times the friction of every surface.")]
THRESHOLD = Annotated[
    float | None,
    typer.Option("--slip-threshold", help="Slip is felt from here on, in m/s; 1e-4 when not given."),
]
DELAY = Annotated[
    float | None, typer.Option("--slip-delay", help="Felt slip is late by this, in s; 0.02 when not given.")
]
CHANNEL = Annotated[
    str, typer.Option("--slip-channel", help="Of every finger: sound, dead, stuck, noisy or absent.")
]
NO_CHANNEL = Annotated[bool, typer.Option("--no-slip-channel", help="The same as --slip-channel absent.")]
WORLD = Annotated[
    str,
    typer.Option(
        "--world",
        help="old: constant friction, drawn evenly; published: friction that falls with the load, and gains"
        " of the tangential forces, as measured by others; or both.",
    ),
]
PLANT = Annotated[
    str, typer.Option("--plant", help="ours, or mujoco: a gripper of two pads in MuJoCo, for the pinch.")
]
PLANTS = ("ours", "mujoco")
JOBS = Annotated[int, typer.Option("--jobs", "-j", min=1, help="Processes.")]
PICTURE = Annotated[Path | None, typer.Option("-o", "--output", help="Picture of the fronts.")]


def controllers(
    grasp: GRASP = "",
    seeds: SEEDS = 10,
    first_seed: FIRST = 0,
    duration: DURATION = 10.0,
    only: ONLY = None,
    sweep: SWEEP = False,
    drive_bandwidth: BANDWIDTH = None,
    friction_scale: SCALE = 1.0,
    slip_threshold: THRESHOLD = None,
    slip_delay: DELAY = None,
    slip_channel: CHANNEL = "sound",
    no_slip_channel: NO_CHANNEL = False,
    world: WORLD = BOTH,
    plant: PLANT = "ours",
    jobs: JOBS = 1,
    output: PICTURE = None,
    force: FORCE = False,
    as_json: JSON = False,
) -> None:
    """Measure how hard each controller grips over the least force that would hold, and how often it slips.

    Every controller meets the same simulated hands, objects and disturbances. The least possible force is
    that of a controller that knows the true friction and contact at every instant. In the old world friction
    is constant; in the published one it falls with the load, as measured by others. With --plant mujoco
    the world is one that is not ours, and the creep of the simulator itself is shown beside.

    Example: vegrip controllers --grasp pinch --seeds 2 --only vegrip --only constant

    Fifty scenarios of all controllers take about two minutes in each world; with --sweep, ten.
    """
    from vegrip.trials import fronts

    grasp = grasp or ("pinch" if plant == "mujoco" else "hand")
    names, worlds, hands = _known(grasp, only or []), _worlds(world), _plant(plant, grasp)
    if no_slip_channel and slip_channel != "sound":
        raise UsageError(f"give --slip-channel {slip_channel} or --no-slip-channel, not both")
    channel = "absent" if no_slip_channel else slip_channel
    around = _surroundings(drive_bandwidth, friction_scale, slip_threshold, slip_delay, channel)
    if not 2.0 < duration <= 600.0:
        raise UsageError(f"--duration is {duration:g} s; give more than 2 s and at most 600 s")
    knobs = fronts.knobs_of(grasp, names, sweep=sweep)
    with Outputs(force=force) as outputs:
        outputs.picture(output)
        seen = range(first_seed, first_seed + seeds)
        summaries = {}
        for here in worlds:
            trials = fronts.trials_of(knobs, seen, duration, grasp, around, world=here, plant=hands)
            summaries[here] = fronts.summaries_of(_run(trials, jobs, here), grasp)
        outputs.write(output, lambda path: fronts.draw_fronts(summaries, grasp, path))
        said: dict[str, Any] = {
            "grasp": grasp,
            "seeds": seeds,
            "duration": duration,
            "slip_channel": channel,
            "plant": plant,
        }
        if plant == "mujoco":
            from vegrip.bridges.mujoco_plant import simulator_creep

            said["creep"] = simulator_creep()
        figures = {"controllers": summaries[worlds[0]], "worlds": summaries}
        answer(said | figures, lambda: _print(summaries, drive_bandwidth is not None), as_json=as_json)
        if not as_json:
            _print_creep(said.get("creep", []))


def _run(trials: "Sequence[QualityTrial]", jobs: int, world: str) -> "dict[str, dict[float, dict[str, Any]]]":
    from vegrip.trials import fronts

    every = max(1, len(trials) // 20)
    with progress("controllers") as report:
        return fronts.run_fronts(
            trials,
            jobs,
            lambda done: (
                None if done % every else report(f"{done} of {len(trials)} scenarios, {world} world")
            ),
        )


def _plant(name: str, grasp: str) -> "PlantMake":
    from vegrip.trials.fronts import OURS, PlantMake

    if name not in PLANTS:
        raise UsageError(f"there is no plant {name!r}; {suggestion(name, PLANTS)}")
    if name == "ours":
        return OURS
    if grasp != "pinch":
        raise UsageError(f"the gripper of MuJoCo has two fingers; leave --grasp {grasp} out")
    from vegrip.bridges import require

    require("mujoco", "--plant mujoco", "mujoco")
    from vegrip.bridges.mujoco_plant import MujocoHand, elliptic_least_force

    return PlantMake(MujocoHand, elliptic_least_force)


def _print_creep(creep: list[dict[str, float]]) -> None:
    for row in creep:
        setting = f"impratio {row['impratio']:g}, noslip_iterations {row['noslip_iterations']:g}"
        typer.echo(
            f"creep of MuJoCo itself, held by a constant force, {setting}: {1e3 * row['creep']:.2g} mm/s"
        )


def _worlds(world: str) -> tuple[str, ...]:
    from vegrip.trials.closed_loop import WORLDS

    if world not in (*WORLDS, BOTH):
        raise UsageError(f"there is no world {world!r}; {suggestion(world, (*WORLDS, BOTH))}")
    return WORLDS if world == BOTH else (world,)


def _known(grasp: str, only: list[str]) -> list[str]:
    from vegrip.trials.candidates import KNOBS

    if grasp not in KNOBS:
        raise UsageError(f"there is no grasp {grasp!r}; {suggestion(grasp, KNOBS)}")
    for name in only:
        if name not in KNOBS[grasp]:
            raise UsageError(f"there is no controller {name!r}; {suggestion(name, KNOBS[grasp])}")
    return list(dict.fromkeys(only)) or list(KNOBS[grasp])


def _surroundings(
    bandwidth: float | None, scale: float, threshold: float | None, delay: float | None, channel: str
) -> "Surroundings":
    from vegrip.trials.fronts import SLIP_CHANNELS, USUAL_SENSOR, Surroundings

    if channel not in SLIP_CHANNELS:
        raise UsageError(f"there is no slip channel {channel!r}; {suggestion(channel, SLIP_CHANNELS)}")
    threshold = USUAL_SENSOR.slip_threshold if threshold is None else threshold
    delay = USUAL_SENSOR.slip_delay if delay is None else delay
    bounds = {
        "--drive-bandwidth": (bandwidth if bandwidth is not None else 12.0, 0.1, 100.0, "Hz"),
        "--friction-scale": (scale, 0.05, 10.0, ""),
        "--slip-threshold": (threshold, 0.0, 1.0, "m/s"),
        "--slip-delay": (delay, 0.0, 0.1, "s"),
    }
    for name, (value, low, high, unit) in bounds.items():
        if not low <= value <= high:
            raise UsageError(
                f"{name} is {value:g} {unit}; give {low:g} to {high:g} {unit}".replace("  ", " ")
            )
    return Surroundings(
        math.nan if bandwidth is None else bandwidth, scale, threshold, delay, slip_channel=channel
    )


def _print(worlds: dict[str, dict[str, Any]], shows_lags: bool) -> None:
    shown = len(worlds) > 1
    columns = table(
        *["world"] * shown, "controller", "knob", "slips", "drops", "slips per trial, 95 %", "force [N]",
        "over least", "micro-slip [um]", "margin, 5 %", "below 0.02 [s]",
    )  # fmt: skip
    for world, summaries in worlds.items():
        for name, one in summaries.items():
            for point in one["front"]:
                star = " *" if point["knob"] == one["knob"] and len(one["front"]) > 1 else ""
                columns.add_row(*[world] * shown, name + star, *_figures(point))
    show(columns)
    some = next(iter(worlds.values()))
    classes = next(iter(some.values()))["by_class"]
    forces = table(*["world"] * shown, "force over least (slips)", *classes)
    friction = table(*["world"] * shown, "friction inside its 95 %", "in all", *classes, "std of ln mu")
    for world, summaries in worlds.items():
        for name, one in summaries.items():
            of_class, head = one["by_class"].values(), [*[world] * shown, name]
            forces.add_row(
                *head, *(_or_dash(f"{by['force_over_least']:.2f} ({by['slips']})") for by in of_class)
            )
            inside = [_or_dash(f"{100.0 * by['friction_inside']:.0f} %") for by in (one, *of_class)]
            friction.add_row(*head, *inside, _or_dash(f"{one['friction_std']:.2f}"))
    show(forces)
    show(friction)
    if shows_lags:
        for world, summaries in worlds.items():
            _print_lags(summaries, f" in the {world} world" * shown)


def _figures(point: dict[str, Any]) -> tuple[str, ...]:
    low, high = point["slip_probability_bounds"]
    return (
        f"{point['knob']:g}", str(point["slips"]), str(point["drops"]), f"{low:.2f} to {high:.2f}",
        f"{point['mean_force']:.2f}", f"{point['force_over_least']:.2f}",
        f"{1e6 * point['largest_micro_slip']:.0f}", f"{point['margin_q05']:.2f}",
        f"{point['time_below_002']:.3f}",
    )  # fmt: skip


def _or_dash(figure: str) -> str:
    """Return a figure, and a dash for one of what did not occur."""
    return "-" if figure.startswith("nan") else figure


def _print_lags(summaries: dict[str, Any], where: str) -> None:
    from vegrip.grip.drive_log import describe_lag
    from vegrip.trials.candidates import parameters

    for name, one in summaries.items():
        if math.isfinite(one["drive_lag"]):
            grip = parameters(name, one["knob"]).grip
            typer.echo(f"drives of {name}{where}: {describe_lag(one['drive_lag'], grip)}")
