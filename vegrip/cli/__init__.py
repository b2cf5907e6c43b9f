"""The command line ``vegrip``: a table of commands, and one place that turns errors into sentences.

Each command is a function in its own module, imported only when that command is called, so that
``vegrip --help`` does not pay for the compiler. Exit codes: 0 did what was asked, 2 usage, 3 bad input,
4 device; the message goes to standard error, never a traceback.
"""

import importlib
import sys
from collections.abc import Callable
from typing import Any

import typer
from rich.console import Console
from rich.table import Table

from vegrip.errors import VegripError

COMMANDS: dict[str, tuple[str, str]] = {
    # name: (module:function or module:app, one line of help)
    "demo": ("vegrip.cli.demo:demo", "Run the main job: virtual hand, virtual bus, node, live table."),
    "launch": ("vegrip.cli.launch:launch", "Start the nodes of a launch file and watch over them."),
    "node": ("vegrip.cli.node:node", "Run one node in this process."),
    "monitor": ("vegrip.cli.monitor:monitor", "Watch slip margins live."),
    "record": ("vegrip.cli.record:record", "Record the bus to a folder."),
    "replay": ("vegrip.cli.replay:replay", "Play a recording on the bus."),
    "import": ("vegrip.cli.import_:import_", "Turn any CSV into a recording, with a column map."),
    "simulate": ("vegrip.cli.simulate:simulate", "Make a recording as a model would give it."),
    "fit": ("vegrip.cli.fit:fit", "Fit the contact model to a recording."),
    "compare": ("vegrip.cli.compare:compare", "Compare a model with a recording, and see where it fails."),
    "new-effect": (
        "vegrip.cli.new_effect:new_effect",
        "Write a package that adds an effect of your own.",
    ),
    "test-effect": (
        "vegrip.cli.effect_laws:effect_laws",
        "Test whether an effect of your own holds to the laws of every effect.",
    ),
    "diagnose": ("vegrip.cli.diagnose:diagnose", "Say which physical effects the model lacks."),
    "add": ("vegrip.cli.add:add", "Put an effect into a model and fit again."),
    "refine": ("vegrip.cli.refine:refine", "Add effects until the next one does not pay."),
    "experiment": (
        "vegrip.cli.experiment:experiment",
        "Find the experiment that tells candidates apart.",
    ),
    "fleet": ("vegrip.cli.fleet:fleet", "Diagnose a folder of many recordings, on all cores."),
    "trial": ("vegrip.cli.trial:trial", "Hide effects in simulated recordings, and count what is named."),
    "paper": ("vegrip.cli.paper:paper", "Print the paper's tables and draw its figures."),
    "bench": ("vegrip.cli.bench:bench", "Measure the speed ratios on this machine."),
    "doctor": ("vegrip.cli.doctor:doctor", "Check this machine and say how to mend what is wrong."),
    "bus-load": ("vegrip.cli.bus_load:bus_load", "Tell whether hands, rates and layout fit a CAN bus."),
    "topic": ("vegrip.cli.topic:app", "Look at topics: list, echo, hz."),
    "param": ("vegrip.cli.param:app", "Read and set parameters of running nodes."),
    "keys": ("vegrip.cli.keys:app", "Make and pass on keys for networks beyond this machine."),
    "lifecycle": ("vegrip.cli.lifecycle:app", "Read and change the state of running nodes."),
}


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    arguments = sys.argv[1:] if arguments is None else arguments
    name, rest = (arguments[0], arguments[1:]) if arguments else ("--help", [])
    if name in ("-h", "--help"):
        _print_help()
        return 0
    if name not in COMMANDS:
        _complain(f"there is no command {name!r}; there are {', '.join(COMMANDS)}")
        return 2
    return _run(name, rest)


def entry() -> None:
    """Entry point of the installed script."""
    sys.exit(main())


def _run(name: str, arguments: list[str]) -> int:
    module, attribute = COMMANDS[name][0].split(":")
    try:
        app = _as_app(getattr(importlib.import_module(module), attribute))
        app(arguments, prog_name=f"vegrip {name}")
    except VegripError as error:
        _complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        return 130
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else 0
    return 0


def _as_app(command: typer.Typer | Callable[..., Any]) -> typer.Typer:
    if isinstance(command, typer.Typer):
        return command
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(command)
    return app


def _complain(sentence: str) -> None:
    Console(stderr=True, highlight=False).print(
        f"vegrip: {sentence}", style="red", soft_wrap=True, markup=False
    )


def _print_help() -> None:
    console = Console()
    console.print("[bold]vegrip[/bold]: contact estimation and grip control for soft fingertips\n")
    table = Table(box=None, show_header=False, padding=(0, 2))
    for name, (_, text) in COMMANDS.items():
        table.add_row(f"vegrip {name}", text)
    console.print(table)
    console.print("\nEach command has --help with an example. Try [bold]vegrip demo[/bold].")
