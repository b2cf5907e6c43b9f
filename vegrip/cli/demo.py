"""``vegrip demo``: the main job, end to end, without hardware."""

import os
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from vegrip.cli._outputs import FORCE, claim_recording
from vegrip.errors import UsageError
from vegrip.host.realtime import switched


def demo(
    duration: Annotated[float, typer.Option(min=3.0, max=3600.0, help="length in s")] = 30.0,
    seed: Annotated[int, typer.Option(min=0, help="which object and disturbances")] = 0,
    grasp: Annotated[
        str,
        typer.Option(
            help="hand: all fingers; pinch: thumb and index; auto: hand from four cores on;"
            " not with --as or --bench"
        ),
    ] = "auto",
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="folder of the recording (default recordings/demo-TIME)"),
    ] = None,
    force: FORCE = False,
    headless: Annotated[bool, typer.Option("--headless", help="no live table")] = False,
    json: Annotated[bool, typer.Option("--json", help="one JSON object on standard output")] = False,
    realtime: Annotated[
        bool, typer.Option(help="real-time priority and locked memory, where they are permitted")
    ] = True,
    web: Annotated[
        bool | None,
        typer.Option(
            "--web/--no-web", help="besides as a page in the browser; not with --headless or --json"
        ),
    ] = None,
    plot: Annotated[
        bool | None,
        typer.Option(
            "--plot/--no-plot", help="compare with two other controllers and draw; not with --bench"
        ),
    ] = None,
    product: Annotated[
        str, typer.Option("--as", help="speak as a product of vegrip connect --list, or as a map says")
    ] = "",
    bench: Annotated[
        str, typer.Option(help="two sensors and a gripper of --list: papillarray+robotiq, wrist=bota+robotiq")
    ] = "",
) -> None:
    """Run a virtual hand, a virtual CAN bus and the grasp force node, and watch.

    Soft fingertips hold an object of unknown friction while it is pushed, twisted, shaken and made wet.
    The live page's address is printed; the page opens where there is a display.
    Afterwards the same scenario is run with a constant grip and with a Coulomb cone, and drawn
    against the least force that would have held.

    Example: vegrip demo --duration 20

    With --as the hand is the virtual device of a product, on its carrier, with its rate and resolution:
    vegrip demo --as tesollo-dg5f

    With --bench pads and gripper are devices of their own: vegrip demo --bench papillarray+robotiq
    """
    from vegrip.demo.bench import open_bench_product
    from vegrip.demo.command import run_demo
    from vegrip.demo.product import open_product
    from vegrip.identification.recording.session import replaced
    from vegrip.trials.closed_loop import GRASPS, Scenario, fitting_grasp

    if grasp not in ("auto", *GRASPS):
        raise UsageError(f"there is no grasp {grasp!r}; there are auto, {', '.join(GRASPS)}")
    if bench and product:
        raise UsageError("--bench and --as both say what the hand is; leave one out")
    if (bench or product) and grasp != "auto":
        raise UsageError(
            f"--grasp {grasp}: --as and --bench have the fingers of their maps; leave --grasp out"
        )
    if bench and plot:
        raise UsageError("--plot: other controllers know nothing of the drive of --bench; leave --plot out")
    if web and (headless or json):
        raise UsageError("--web: with --headless or --json there is no page; leave one of them out")
    if grasp == "auto":
        grasp = fitting_grasp(len(os.sched_getaffinity(0)))
    folder = output if output is not None else Path("recordings") / time.strftime("demo-%Y%m%d-%H%M%S")
    claim_recording(folder, force=force)
    shown: dict[str, Any] = {
        "live": not headless,
        "json": json,
        "plot": not bench if plot is None else plot,
        "web": not (headless or json) if web is None else web,
    }
    with switched(on=realtime), replaced(folder):
        if bench:
            parts = open_bench_product(bench, folder)
            interrupted = run_demo(parts.scenario(seed, duration), folder, product=parts, **shown)
        elif product:
            device = open_product(product, folder)
            interrupted = run_demo(device.scenario(seed, duration), folder, product=device, **shown)
        else:
            interrupted = run_demo(Scenario(seed, duration, grasp, relaxes_slowly=False), folder, **shown)
    if interrupted:
        raise typer.Exit(130)
