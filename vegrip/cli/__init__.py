"""The command line ``vegrip``: a table of commands, and one place that turns errors into sentences.

Each command is a function in its own module, imported only when that command is called, so that
``vegrip --help`` does not pay for the compiler. Exit codes: 0 did what was asked, 2 usage, 3 bad input,
4 device, or a result that was lost; the message goes to standard error, never a traceback.
"""

import errno
import importlib
import os
import re
import sys
from collections.abc import Callable
from typing import Any

import typer
from rich.markup import escape

from vegrip.cli._terminal import complain
from vegrip.errors import DeviceError, VegripError, is_missing_from_installation, suggestion
from vegrip.host.descriptors import COMMAND_NEEDS, is_out_of_descriptors, require_descriptors

SINGLE_BREAK = re.compile(r"(?<!\n)\n *(?!\n)")  # inside a paragraph
HELP = {"help_option_names": ["-h", "--help"]}


def literal(app: typer.Typer) -> Any:
    """Return the command of ``app``, its help taken as it stands: ``[m]`` is a unit, no markup."""
    command = typer.main.get_command(app)
    _make_literal(command)
    command.context_settings = {**command.context_settings, **HELP}
    return command


def _make_literal(command: Any) -> None:
    command.help = escape(SINGLE_BREAK.sub(" ", command.help or ""))
    if command.short_help:
        command.short_help = escape(command.short_help)
    for parameter in command.params:
        if getattr(parameter, "help", None):
            parameter.help = escape(parameter.help)
    for sub in getattr(command, "commands", {}).values():
        _make_literal(sub)


def explained(error: typer.TyperException, program: str) -> str:
    """Return the mistake in one sentence, with what to do."""
    context = getattr(error, "ctx", None)
    path = context.command_path if context is not None else program
    sentence = _sentence(error, context)
    return f"{sentence}{'' if sentence.endswith('?') else ';'} see {path} -h"


def _sentence(error: typer.TyperException, context: Any) -> str:
    parameter, kind = getattr(error, "param", None), type(error).__name__
    if kind == "NoSuchOption" and context is not None:
        given = getattr(error, "option_name", "")
        known = [option for each in context.command.params for option in each.opts if option[:2] == "--"]
        return f"there is no option {given}; {suggestion(given, known)}"
    if parameter is None:
        return _plain(error.format_message())
    name = "/".join(parameter.opts) if parameter.param_type_name == "option" else parameter.name.upper()
    meaning = f" ({parameter.help})".replace("\\[", "[").replace(".)", ")") if parameter.help else ""
    if kind == "MissingParameter":
        return f"{name} is missing{meaning}"
    return f"{name} {_given(error)}{_plain(error.message)}{meaning}"


def _given(error: BaseException) -> str:
    errors = getattr(error.__cause__, "errors", None)
    if errors is None:
        return ""
    return f"is {errors()[0].get('input')!r}: it "


def _plain(message: str) -> str:
    message = message.strip().rstrip(".")
    for start in ("Input ", "Value error, "):
        message = message.removeprefix(start)
    message = message.replace("should be", "must be").replace(". Did", "; did")
    return message[:1].lower() + message[1:]


GROUPS = {  # heading -> command -> one line of help
    "Start": {
        "demo": "Run the main job: virtual hand, virtual bus, node, live table.",
        "sample": "Write a sample recording, model or log here.",
        "doctor": "Check this machine and say how to fix what is wrong; list what your sensors give.",
    },
    "On a hand": {
        "connect": "Map a hand of another make: from its DBC or EDS and its traffic to a file that runs.",
        "launch": "Start and supervise the nodes of a launch file.",
        "node": "Run one node in this process.",
        "monitor": "Watch slip margins live.",
        "topic": "Look at topics: list, echo, hz.",
        "bridge": "Show running hands to others: foxglove (also PlotJuggler), ros2, mcap.",
        "param": "Read and set parameters of running nodes.",
        "lifecycle": "Read and change the state of running nodes.",
        "grasp": "Close around an object, and say whether it is held.",
        "release": "Release what is held, slowly.",
        "zero": "Have the sensors of a hand take their own zeros.",
        "bus-load": "Compute whether hands, rates and layout fit a CAN bus.",
        "keys": "Make and exchange keys for networks beyond this machine.",
    },
    "Recordings": {
        "record": "Record the bus to a folder.",
        "replay": "Play a recording on the bus, or run the node over it.",
        "import": "Turn a table, CAN log, MCAP, rosbag, LeRobot set, HDF5 or npz into a recording.",
        "simulate": "Simulate a recording with a model.",
    },
    "The contact model": {
        "fit": "Fit the contact model to a recording.",
        "compare": "Compare a model with a recording, and see where it fails.",
        "check": "See in the browser what a model lacks, and add it.",
        "diagnose": "Find which physical effects the model lacks.",
        "add": "Put an effect into a model and fit again.",
        "draft": "Draft a law where no effect of the catalogue explains the misfit.",
        "refine": "Add effects until the next one does not pay.",
        "changed": "Say what changed of a fingertip between two recordings.",
        "report": "Write a recording, a run or a check as one file of HTML.",
        "experiment": "Find the experiment that separates candidate effects.",
        "calibrate": "Guide a new fingertip through its trials to a model with errors.",
        "export": "Write for others: c and learned (firmware), mujoco, mcap, lerobot.",
        "fleet": "Diagnose a folder of many recordings, on all cores.",
        "new-effect": "Write a package that adds an effect of your own.",
        "test-effect": "Test whether an effect of your own holds to the laws of every effect.",
    },
    "Evidence": {
        "paper": "Print the paper's tables and draw its figures.",
        "controllers": "Measure grip force over the least that would hold, and slips, of every controller.",
        "trial": "Make blind recordings with the truth apart, or score answers to them.",
        "bench": "Measure the speed ratios on this machine; in a checkout.",
    },
}
COMMANDS = {name: text for group in GROUPS.values() for name, text in group.items()}
PLACES = {
    "topic": "topic:app",
    "bridge": "bridge:app",
    "param": "param:app",
    "lifecycle": "lifecycle:app",
    "zero": "lifecycle:zero",
    "release": "grasp:release",
    "keys": "keys:app",
    "import": "import_:import_",
    "add": "fit:add",
    "refine": "fit:refine",
    "compare": "fit:compare",
    "export": "export:app",
    "new-effect": "own_effect:new_effect",
    "test-effect": "own_effect:effect_laws",
}
"""Module in this folder and name in it of a command, where both are not its own name."""

INTERRUPTED = 130  # exit code
NOTHING = "nothing is written"
STOPPED = {  # what an interrupted command keeps, some with an option; the others are ended that way
    **dict.fromkeys(
        (
            "import",
            "simulate",
            "fit",
            "compare",
            "diagnose",
            "add",
            "draft",
            "refine",
            "changed",
            "report",
            "experiment",
        ),
        NOTHING,
    ),
    **dict.fromkeys(("controllers", "bench"), NOTHING),
    "replay": "what was sent is sent",
    "export": "what is in the folder of -o is not complete",
    "trial": "recordings that were made stay, and there is no truth of them",
    "paper": "pictures that were drawn stay",
    "fleet": "recordings that were examined are kept, and the same command goes on with the others",
    "calibrate": "trials that were taken are kept, and the same command goes on with the others",
    **dict.fromkeys(("calibrate --drive", "calibrate --weight"), NOTHING),
}

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)

COMPLETION = ("--install-completion", "--show-completion")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    arguments = sys.argv[1:] if arguments is None else arguments
    name, rest = (arguments[0], arguments[1:]) if arguments else ("--help", [])
    if name in ("-h", "--help"):
        _print_help()
        return 0
    if name == "--version":
        from importlib.metadata import version

        typer.echo(f"vegrip {version('vegrip')}")
        return 0
    if name in COMPLETION:
        return run(whole(), arguments, "vegrip")
    if name not in COMMANDS:
        complain(f"there is no command {name!r}; {suggestion(name, COMMANDS)}")
        return 2
    return _run_command(name, rest)


class _LeanCan:
    """Finder that keeps asammdf, and with it pandas, out of ``import can``.

    They are half of the time in which a node starts, and 80 MB; nothing but a log in MDF 4 is read by them.
    """

    @staticmethod
    def find_spec(name: str, _path: Any = None, _target: Any = None) -> None:
        reader = sys.modules.get("can.io.mf4")
        if name == "asammdf" and reader is not None and not hasattr(reader, "MF4Reader"):  # at its imports
            raise ModuleNotFoundError(name=name)


def entry() -> None:
    sys.meta_path.insert(0, _LeanCan)
    if "_VEGRIP_COMPLETE" in os.environ:  # the shell asks what may come next
        whole()(prog_name="vegrip")
    sys.exit(main())


def load(name: str) -> typer.Typer:
    return _as_app(_found(name))


def _found(name: str) -> Any:
    own = name.replace("-", "_")
    module, attribute = PLACES.get(name, f"{own}:{own}").split(":")
    return getattr(importlib.import_module(f"vegrip.cli.{module}"), attribute)


def whole() -> typer.Typer:
    """Return all commands as one app, as shell completion wants it."""
    app = typer.Typer(add_completion=True, pretty_exceptions_enable=False)
    for name, text in COMMANDS.items():
        command = _found(name)
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name, help=text)
        else:
            app.command(name, help=text)(command)
    return app


def _run_command(name: str, arguments: list[str]) -> int:
    try:
        require_descriptors(COMMAND_NEEDS)
        app = load(name)
    except VegripError as error:
        complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:  # while it is imported
        return INTERRUPTED
    is_group = len(app.registered_commands) > 1
    arguments = arguments or ["--help"] if is_group else arguments
    return run(app, arguments, f"vegrip {name}", _kept(name, arguments))


def _kept(name: str, arguments: list[str]) -> str:
    """Return what a command keeps when it is interrupted."""
    with_option = (f"{name} {each.partition('=')[0]}" for each in arguments)
    return next((STOPPED[each] for each in with_option if each in STOPPED), STOPPED.get(name, ""))


def run(
    app: typer.Typer | Callable[..., Any], arguments: list[str], program: str, keeps_when_stopped: str = ""
) -> int:
    """Run a command and return its exit code; an error is one sentence."""
    app = _as_app(app)
    try:
        code = literal(app)(arguments, prog_name=program, standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except BrokenPipeError:  # `vegrip ... | head`: the reader has ended
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else 0
    except Exception as error:
        sentence, code = _sentence_and_code(error, program)
        if not sentence:
            raise
        complain(sentence)
    if code == INTERRUPTED and keeps_when_stopped:  # typer returns it, too
        complain(f"stopped; {keeps_when_stopped}")
    return code if isinstance(code, int) else 0


def _sentence_and_code(error: Exception, program: str) -> tuple[str, int]:
    """Return what to say of ``error`` and the exit code; nothing of one that is a mistake of ours."""
    if isinstance(error, VegripError):
        return str(error), error.exit_code
    if isinstance(error, typer.TyperException):
        return explained(error, program), error.exit_code
    if is_out_of_descriptors(error):
        said = "too many files and sockets are open; raise the limit, e.g. `ulimit -n 4096`"
        return said, DeviceError.exit_code
    if isinstance(error, OSError) and error.errno in FULL:
        return f"the result is not written ({error.strerror})", DeviceError.exit_code
    if is_missing_from_installation(error):
        return (
            f"{error.filename}: this file of vegrip is missing; install vegrip again",
            DeviceError.exit_code,
        )
    return "", 1


def _as_app(command: typer.Typer | Callable[..., Any]) -> typer.Typer:
    if isinstance(command, typer.Typer):
        return command
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(command)
    return app


def _print_help() -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(markup=False, highlight=False)
    console.print("vegrip: contact estimation and grip control for soft fingertips")
    table = Table(box=None, show_header=False, padding=(0, 2))
    for heading, commands in GROUPS.items():
        table.add_row("")
        table.add_row(heading, style="bold")
        for name, text in commands.items():
            table.add_row(f"  vegrip {name}", text)
    console.print(table)
    console.print("\nEach command has -h with an example. Try: vegrip demo")
    console.print("Also: vegrip --version, vegrip --install-completion (of this shell), --show-completion")
