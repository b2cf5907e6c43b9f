"""``vegrip connect``: from the database of a hand of another make, and its traffic, to a map that runs."""

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE
from vegrip.cli._terminal import complain, printer, show, table
from vegrip.cli.node import parsed
from vegrip.errors import ConfigError, InputError, UsageError
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from rich.table import Table

    from vegrip.transport.mapped.database import Database
    from vegrip.transport.mapped.drafts import Setting
    from vegrip.transport.mapped.plan import Plan
    from vegrip.transport.mapped.proposal import Proposal
    from vegrip.transport.mapped.questions import Findings, Window
    from vegrip.transport.mapped.traffic import Now, Traffic

DATABASE = Annotated[
    Path | None, typer.Argument(help="Their .dbc, .kcd, .sym, .arxml or .eds; or a map, to check it.")
]
LIST = Annotated[bool, typer.Option("--list", help="Show the products whose maps are in the box.")]
HAND = Annotated[str, typer.Option(help="A product of --list: write its map.")]
ADDRESS = Annotated[str, typer.Option(help="--hand: where it is, HOST:PORT or a tty.")]
OUT = Annotated[Path | None, typer.Option("-o", "--output", help="Map (TOML) to write.")]
LOG = Annotated[Path | None, typer.Option(help="Log of their traffic: .asc, .blf, or .log of candump.")]
CHANNEL = Annotated[str, typer.Option(help="Live: CAN channel that the hand is on, e.g. can0.")]
INTERFACE = Annotated[str, typer.Option(help="Live: python-can interface.")]
BITRATE = Annotated[int, typer.Option(help="Live: nominal bit rate [bit/s].")]
FD = Annotated[bool, typer.Option("--fd", help="Live: the bus carries CAN FD.")]
FINGERS = Annotated[
    str, typer.Option(help="Their fingers, by commas, in the order of the hand's numbers or letters.")
]
NODES = Annotated[str, typer.Option(help="EDS: node-IDs of the fingers, e.g. thumb=32,index=33.")]
REST = Annotated[str, typer.Option(help="A..B [s] of the traffic in which no finger touches anything.")]
PRESS = Annotated[str, typer.Option(help="A..B [s] in which fingertips are pressed along their normal.")]
SHEAR = Annotated[str, typer.Option(help="A..B [s] in which fingertips are pulled along their +x.")]
TWIST = Annotated[str, typer.Option(help="A..B [s] of a counter-clockwise twist about the outward normal.")]
SECONDS = Annotated[
    float, typer.Option(help="Live: how long to listen for each question [s].", min=0.2, max=600.0)
]
SETTINGS = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="KEY=VALUE of the map, e.g. fingers.thumb.normal_force.sign=-1; fingers.* is all."
    ),
]
ASK = Annotated[bool, typer.Option("--ask/--no-ask", help="Live: ask for rest, press, shear and twist.")]

PICTURE_PERIOD_S = 0.1  # [s] between two pictures of live values
QUESTIONS = {
    "rest": "leave all fingers in the air",
    "press": "press each fingertip on something along its normal, and let go",
    "shear": "pull each fingertip along its +x while it touches",
    "twist": "turn what it touches counter-clockwise about its outward normal",
}


def connect(
    database: DATABASE = None,
    output: OUT = None,
    log: LOG = None,
    channel: CHANNEL = "",
    interface: INTERFACE = "socketcan",
    bitrate: BITRATE = 1_000_000,
    fd: FD = False,
    fingers: FINGERS = "",
    nodes: NODES = "",
    rest: REST = "",
    press: PRESS = "",
    shear: SHEAR = "",
    twist: TWIST = "",
    seconds: SECONDS = 5.0,
    settings: SETTINGS = None,
    ask: ASK = True,
    force: FORCE = False,
    as_json: JSON = False,
    lists: LIST = False,
    hand: HAND = "",
    address: ADDRESS = "",
) -> None:
    """Map a hand of another make: propose which signals are force, position and command, and write a file.

    The map comes from names, units and ranges; traffic (a log, or live) adds rates, checksums, noise and
    plausibility; one press, shear and twist find signs, zeros and which signal is which.

    Example: vegrip sample foreign.dbc && vegrip sample foreign.blf && vegrip connect foreign.dbc -o hand.toml
    --log foreign.blf --rest 0..2 --press 2..5 --shear 5..8 --twist 8..10 --channel can0 && vegrip launch
    hand --check

    A product of --list needs no database: vegrip connect --hand bota-sensone -o tip.toml
    """
    from vegrip.transport.mapped.drafts import for_each_finger
    from vegrip.transport.mapped.plan import open_plan
    from vegrip.transport.mapped.traffic import MappedNow, SignalsNow, traces

    said = [each for text in settings or [] for each in _settings(text)]
    if lists or hand:
        from vegrip.cli import _products

        if database is not None:
            raise UsageError(f"{database}: give a database, or --list, or --hand, not two of them")
        if lists:
            _products.show_all(as_json=as_json)
        else:
            _products.write(hand, output, said, address, channel, force=force, as_json=as_json)
        return
    if database is None:
        raise UsageError("give a database or a map, --list, or --hand NAME")
    _refuse(database, output, log, force=force)
    windows = _windows(rest=rest, press=press, shear=shear, twist=twist)
    said_of_bus = {"interface": interface, "channel": channel, "fd": fd, "bitrate": bitrate}
    transport: dict[str, Any] = {"kind": "can", **said_of_bus} if channel else {}
    if database.suffix.lower() == ".toml":
        plan = open_plan(database)
        traffic = _traffic(log, transport, windows, seconds, MappedNow(plan), ask=False, shows=not as_json)
        _print_result(plan, traffic, None, None, None, "", as_json=as_json)
        return
    known = _database(database, _pairs(nodes))
    asks = ask and not as_json
    traffic = _traffic(log, transport, windows, seconds, SignalsNow(known), ask=asks, shows=not as_json)
    heard = traces(traffic, known) if traffic is not None else {}
    if traffic is not None:
        _check_windows(windows, traffic)
    names = tuple(name.strip() for name in fingers.split(",") if name.strip())
    proposal, findings = _proposed(
        database, output, known, heard, traffic, names, _pairs(nodes), windows, said
    )
    text = _text(proposal, transport, database, settings or [])
    target, said = output or Path("hand.toml"), for_each_finger(said, proposal.fingers)
    plan, text = _checked(text, target, said)
    if (
        findings is not None
        and traffic is not None
        and _learns_friction(proposal, findings, plan, traffic, said)
    ):
        plan, text = _checked(_text(proposal, transport, database, settings or []), target, said)
    if findings is not None and traffic is not None:
        findings.implausible += _short(traffic, known)
    if output is not None:
        _write(output, text)
    _print_result(plan, traffic, proposal, findings, output, text, as_json=as_json)


def _refuse(database: Path, output: Path | None, log: Path | None, *, force: bool) -> None:
    if not database.is_file():
        raise InputError(f"{database}: there is no such file")
    if output is not None and output.exists() and not force:
        raise InputError(f"{output}: is there already; give another name, or --force to replace it")
    if output is not None and not output.parent.is_dir():
        raise InputError(f"{output.parent}: there is no such folder")
    if log is not None and not log.is_file():
        raise InputError(f"{log}: there is no such file")
    if database.suffix.lower() == ".toml" and output is not None:
        raise UsageError(f"{database} is a map already and is only checked; leave out -o")


def _windows(**given: str) -> "dict[str, Window]":
    found = {}
    for name, text in given.items():
        if not text:
            continue
        first, dots, last = text.partition("..")
        try:
            window = float(first), float(last)
        except ValueError:
            window = 1.0, 0.0
        if not dots or not 0.0 <= window[0] < window[1]:
            raise UsageError(f"--{name} is {text!r}; give two times in seconds, as in 2..5")
        found[name] = window
    return found


def _check_windows(windows: "dict[str, Window]", traffic: "Traffic") -> None:
    for name, (first, last) in windows.items():
        if traffic.frames and first >= traffic.duration:
            raise InputError(
                f"--{name} {first:g}..{last:g} lies after the end of the traffic, which lasts "
                f"{traffic.duration:.1f} s"
            )


def _short(traffic: "Traffic", database: "Database") -> list[str]:
    return [
        f"{count} frames of {name} are shorter than the {database.messages[name].length} bytes that "
        f"{database.name} says, and were left out; ask for the database of this version of the hand"
        for name, count in traffic.short.items()
    ]


def _write(path: Path, text: str) -> None:
    try:
        write_whole(path, text)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from None


def _pairs(text: str) -> dict[str, int]:
    found = {}
    for part in (part.strip() for part in text.split(",") if part.strip()):
        name, _, number = part.partition("=")
        if not number.strip().isdecimal():
            raise UsageError(f"--nodes has {part!r}; write it as thumb=32,index=33")
        found[name.strip()] = int(number)
    return found


def _database(path: Path, nodes: dict[str, int]) -> Any:
    from vegrip.transport.mapped.canopen_nodes import read_eds
    from vegrip.transport.mapped.database import read_dbc

    return read_eds(path, nodes) if path.suffix.lower() == ".eds" else read_dbc(path)


def _traffic(
    log: Path | None,
    transport: dict[str, Any],
    windows: "dict[str, Window]",
    seconds: float,
    now: "Now",
    *,
    ask: bool,
    shows: bool,
) -> "Traffic | None":
    from vegrip.identification.recording.can_log import frames_of
    from vegrip.transport.mapped.traffic import traffic_of

    if log is not None:
        return traffic_of(frames_of(log, extended=True))
    if not transport:
        return None
    asks = ask and sys.stdin.isatty() and not windows
    return _listen(transport, windows, seconds, now if shows and sys.stdout.isatty() else None, ask=asks)


def _listen(
    transport: dict[str, Any],
    windows: "dict[str, Window]",
    seconds: float,
    now: "Now | None",
    *,
    ask: bool,
) -> "Traffic":
    """Collect live traffic, as long as the windows last or for each question; show it in a terminal."""
    from vegrip.clock import NS
    from vegrip.config import build
    from vegrip.transport.can_port import open_port
    from vegrip.transport.mapped.traffic import Traffic
    from vegrip.transport.open import CanSettings, open_bus

    from collections import Counter  # isort: skip

    bus, _, timing = open_bus(build(CanSettings, transport, "--channel"))
    port = open_port(bus, Counter(), timing, extended=True)
    traffic = Traffic()

    def take(until: float) -> None:
        with _showing(now) as draw:
            while (left := until - time.monotonic()) > 0.0:
                frame = port.receive(min(left, 0.1))
                if frame is not None:
                    traffic.add(frame)
                    if now is not None:
                        now.update(frame)
                draw()

    try:
        if not ask:
            take(time.monotonic() + max([seconds, *(end for _, end in windows.values())]))
            return traffic
        for name, what in QUESTIONS.items():
            typer.echo(f"{name}: for {seconds:g} s {what}. Press Enter to begin.", nl=False)
            sys.stdin.readline()
            begin = (time.monotonic_ns() - traffic.start) / NS if traffic.frames else 0.0
            take(time.monotonic() + seconds)
            windows[name] = begin, begin + seconds
    finally:
        bus.shutdown()
    return traffic


def _proposed(
    database: Path,
    output: Path | None,
    known: Any,
    heard: Any,
    traffic: "Traffic | None",
    names: tuple[str, ...],
    nodes: Mapping[str, int],
    windows: "dict[str, Window]",
    said: "list[Setting]",
) -> "tuple[Proposal, Findings | None]":
    from vegrip.transport.mapped.proposal import leave_out_unknown_units, name_unused, propose
    from vegrip.transport.mapped.questions import learn

    proposal = propose(known, heard, traffic, names, nodes, said)
    folder = (output or Path("hand.toml")).absolute().parent
    proposal.database = os.path.relpath(database.absolute(), folder)
    findings = learn(proposal, heard, windows, known, said) if traffic is not None else None
    leave_out_unknown_units(proposal)
    name_unused(proposal, known, heard)
    return proposal, findings


def _learns_friction(
    proposal: "Proposal", findings: "Findings", plan: "Plan", traffic: "Traffic", said: "list[Setting]"
) -> bool:
    """Find how fine and how late slip is felt, switch learning on by it; return whether anything is new."""
    from dataclasses import replace

    from vegrip.identification.slip_channel import slides_of, slip_channel
    from vegrip.transport.mapped.traffic import values_of

    if not any("slip" in finger.measured for finger in plan.fingers):
        return False
    values = values_of(plan, traffic)
    found = slip_channel([each for name in values.states for each in slides_of(values.recording(name))])
    if "slip_threshold" in (stated := {path[1]: v for path, v in said if path[0] == "friction" and path[1:]}):
        found = replace(found, threshold=float(stated["slip_threshold"]))
    if "slip_delay" in stated:
        found = replace(found, delay=float(stated["slip_delay"]))
    proposal.friction = found.settings
    if found.settings:
        findings.learned.append(
            f"slip is felt from {1e3 * found.threshold:.2g} mm/s on and {1e3 * found.delay:.0f} ms late "
            f"({found.slides} slides), so friction is learned"
        )
    if found.lacking:
        proposal.doubts.append(
            f"friction is not learned: {found.lacking}; or state what is known of the sensor: "
            "--set friction.slip_threshold=1e-4 --set friction.slip_delay=0.02"
        )
    return True


def _text(proposal: "Proposal", transport: dict[str, Any], database: Path, settings: list[str]) -> str:
    from vegrip.transport.mapped.writer import map_text

    about = [f"The hand of {database.name}, as vegrip connect proposes it. docs/connect.md has all keys."]
    about += [f"Changed by --set {each}" for each in settings]
    return map_text(proposal, transport, about)


def _checked(text: str, path: Path, settings: "list[Setting]") -> "tuple[Plan, str]":
    """Read the text back as a node will; ``--set`` goes over it."""
    from vegrip.config import parse_toml
    from vegrip.transport.mapped.codec import MappedCodec
    from vegrip.transport.mapped.plan import make_plan, read_database
    from vegrip.transport.mapped.schema import parse_map
    from vegrip.transport.mapped.writer import changed_text

    text = changed_text(text, settings)
    hand = parse_map(parse_toml(text), path)
    plan = make_plan(hand, read_database(hand), tuple(hand.fingers))
    MappedCodec(plan)  # compiles, and finds what only then shows
    return plan, text


def _settings(text: str) -> "list[Setting]":
    """Return the key and its value; of a table that names a signal, each of its keys, the signal first."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise UsageError(f"--set is {text!r}; write KEY=VALUE, as in fingers.thumb.normal_force.sign=-1")
    path, found = [part.strip() for part in key.split(".")], parsed(value.strip())
    if not isinstance(found, dict) or "signal" not in found:
        return [(path, found)]
    return [([*path, each], found[each]) for each in ("signal", *(found.keys() - {"signal"}))]


def _print_result(
    plan: "Plan",
    traffic: "Traffic | None",
    proposal: "Proposal | None",
    findings: "Findings | None",
    output: Path | None,
    text: str,
    *,
    as_json: bool,
) -> None:
    from vegrip.transport.mapped.price import price
    from vegrip.transport.mapped.traffic import values_of

    values = values_of(plan, traffic) if traffic is not None else None
    if values is not None and not values.states:
        raise ConfigError(
            "the map makes no state of this traffic "
            f"({_counts(values.rejected) or 'no message of it came'}); "
            "look at the trigger, and at counter and checksum of [messages]"
        )
    doubts = [*(proposal.doubts if proposal is not None else [])]
    doubts += findings.open if findings is not None else []
    learned = findings.learned if findings is not None else []
    implausible = [*(findings.implausible if findings is not None else [])]
    implausible += values.implausible() if values is not None else []
    if as_json:
        told = {
            "map": str(output) if output is not None else None,
            "fingers": {f.name: sorted(f.measured) for f in plan.fingers},
            "values": values.as_dict() if values is not None else None,
            "learned": learned,
            "open": doubts,
            "implausible": implausible,
            "price": price(plan),
        }
        typer.echo(json.dumps(told))
        _end(implausible)
        return
    if output is None and text:
        typer.echo(text)
    if values is not None:
        _show(values, plan)
    for sentence in learned:
        typer.echo(f"found: {sentence}")
    for sentence in price(plan):
        typer.echo(f"price: {sentence}")
    for sentence in doubts:
        typer.echo(f"open:  {sentence}")
    for sentence in implausible:
        complain(sentence)
    if output is not None:
        launch = f"vegrip launch {output.stem if output.suffix == '.toml' else output}"
        where = (
            launch
            if plan.hand.transport
            else f'transport.map = "{output}" in a launch file, or give --channel'
        )
        typer.echo(f"written: {output}; next: {where}")
    _end(implausible)


def _end(implausible: list[str]) -> None:
    if implausible:
        raise typer.Exit(InputError.exit_code)


def _counts(rejected: Mapping[str, int]) -> str:
    return ", ".join(f"{count} refused for {name}" for name, count in rejected.items())


def _show(values: Any, plan: "Plan") -> None:
    from vegrip.transport.mapped.units import SI

    content = table("finger", "channel", "from", "unit", "least", "last", "largest", "states/s")
    for finger in plan.fingers:
        for name in sorted(finger.measured):
            one = values.of(finger.name, name)
            source = plan.hand.fingers[finger.name].channels.get(name)
            origin = ", ".join(source.names[:2]) if source is not None else "taxels"
            row = [f"{each:.4g}" for each in (one.least, one.last, one.largest)]
            content.add_row(
                finger.name, name, origin or "stated", SI[name], *row, f"{values.rate(finger.name):.4g}"
            )
    show(content)
    for name, count in values.rejected.items():
        typer.echo(f"refused: {name} ({count} x)")


@contextmanager
def _showing(now: "Now | None") -> Iterator[Callable[[], None]]:
    """Show ``now`` as long as the block lasts; what is given draws it again when it is time."""
    if now is None:
        yield lambda: None
        return
    from rich.live import Live

    drawn = 0.0
    with Live(_drawn(now), console=printer(), auto_refresh=False, transient=True) as live:

        def draw() -> None:
            nonlocal drawn
            if time.monotonic() - drawn >= PICTURE_PERIOD_S:
                drawn = time.monotonic()
                live.update(_drawn(now), refresh=True)

        yield draw


def _drawn(now: "Now") -> "Table":
    content = table("from", "what", "now", "unit")
    for source, name, value, unit in now.rows():
        content.add_row(source, name, "-" if math.isnan(value) else f"{value:.4g}", unit)
    return content
