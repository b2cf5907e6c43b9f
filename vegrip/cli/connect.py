"""``vegrip connect``: from the database of a hand of another make, and its traffic, to a map that runs."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, claim_file
from vegrip.cli._terminal import complain, show, table
from vegrip.cli.node import parsed
from vegrip.clock import NS
from vegrip.errors import ConfigError, InputError, UsageError
from vegrip.whole_file import write_whole

if TYPE_CHECKING:
    from vegrip.connect.proposal import Proposal
    from vegrip.connect.questions import Window
    from vegrip.connect.traffic import Now, Traffic, Values
    from vegrip.transport.mapped.plan import Plan
    from vegrip.transport.maps.map_text import Setting

DATABASE = Annotated[
    Path | None, typer.Argument(help="Their .dbc, .kcd, .sym, .arxml, .eds or .dcf; or a map, to check it.")
]
LIST = Annotated[bool, typer.Option("--list", help="Show the products whose maps are in the box.")]
HAND = Annotated[str, typer.Option(help="A product of --list: write its map.")]
ADDRESS = Annotated[str, typer.Option(help="--hand: where it is, HOST:PORT or a tty.")]
SENSOR = Annotated[
    list[str] | None, typer.Option(help="A bench: PRODUCT@PORT or FILE[@PORT] that feels, one for each port.")
]
DRIVE = Annotated[str, typer.Option(help="A bench: PRODUCT@PORT or FILE[@PORT] that presses.")]
HEAVIEST = Annotated[float, typer.Option(min=0.0, help="A bench: its heaviest object [kg].")]
OUT = Annotated[Path | None, typer.Option("-o", "--output", help="Map (TOML) to write.")]
LOG = Annotated[Path | None, typer.Option(help="Log of their traffic: .asc, .blf, .trc, .mf4, or candump's.")]
CHANNEL = Annotated[
    str, typer.Option(help="CAN channel that the hand is on, live or in a log of several, e.g. can0.")
]
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
ACCEPT = Annotated[
    bool, typer.Option("--accept-losses", help="Go on where a tenth of the frames or values cannot be used.")
]
ASK = Annotated[bool, typer.Option("--ask/--no-ask", help="Live: ask for rest, press, shear and twist.")]

SHORT = {
    "normal_force": "normal",
    "tangential_force_x": "tangential",
    "tangential_force_y": "tangential",
    "torque_z": "torque",
}


UNREADABLE = ("counter", "checksum", "invalid")
"""Frames that the codec refuses whole."""


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
    accept: ACCEPT = False,
    address: ADDRESS = "",
    sensor: SENSOR = None,
    drive: DRIVE = "",
    heaviest: HEAVIEST = 0.0,
) -> None:
    """Map a hand of another make: propose which signals are force, position and command, and write a file.

    The map comes from names, units and ranges; traffic (a log, or live) adds rates, checksums, noise and
    plausibility; one press, shear and twist find signs, zeros and which signal is which.

    Example: vegrip sample foreign.dbc && vegrip sample foreign.blf && vegrip connect foreign.dbc -o hand.toml
    --log foreign.blf --rest 0..2 --press 2..5 --shear 5..8 --twist 8..10 --channel can0 && vegrip launch
    hand --check

    A product of --list needs no database: vegrip connect --hand bota-sensone -o tip.toml

    Pads and a gripper, each at its port: vegrip connect --sensor contactile-papillarray@/dev/ttyACM0 --sensor
    contactile-papillarray@/dev/ttyACM1 --drive robotiq-2f85@/dev/ttyUSB0 -o bench.toml --no-ask
    """
    if sensor or drive:
        from vegrip.cli._bench import connect_bench

        given = [each for text in settings or [] for each in _settings(text)]
        yes = {"ask": ask, "force": force, "as_json": as_json}
        connect_bench(sensor or [], drive, output, fingers, heaviest, given, **yes)
        return
    from vegrip.cli._listening import traffic_of_hand
    from vegrip.connect.traffic import MappedNow, SignalsNow
    from vegrip.connect.writer import Known, draw_up
    from vegrip.transport.mapped import plan as plans

    if (database is not None) + lists + bool(hand) != 1:
        what = f"{database}: " if database is not None else ""
        raise UsageError(f"{what}give a database or a map, --list, or --hand NAME, and one of them")
    if lists:
        _show_products(as_json=as_json)
        return
    said = [each for text in settings or [] for each in _settings(text)]
    _refuse(database, output, log, force=force)
    if database is None:
        _connect_product(hand, output, said, address, channel, as_json=as_json)
        return
    windows = _windows(rest=rest, press=press, shear=shear, twist=twist)
    said_of_bus = {"interface": interface, "channel": channel, "fd": fd, "bitrate": bitrate}
    transport: dict[str, Any] = {"kind": "can", **said_of_bus} if channel else {}
    if database.suffix.lower() == ".toml":
        plan = plans.open_plan(database)
        now: Now | None = None if as_json else MappedNow(plan)
        of_map = str(plan.hand.transport.get("channel", ""))
        wanted = {message.identifier for message in plan.database.messages.values()}
        traffic = traffic_of_hand(
            log, transport, windows, seconds, now, ask=False, channel=channel or of_map, wanted=wanted
        )
        _report(plan, "", None, traffic, accepted=accept, as_json=as_json)
        return
    node_ids = _pairs(nodes)
    if not node_ids and database.suffix.lower() in (".eds", ".dcf"):
        raise UsageError(f"{database}: say which node is which finger: --nodes thumb=32,index=33")
    found = plans.read_frames(database, node_ids)
    now = None if as_json else SignalsNow(found)
    wanted = {message.identifier for message in found.messages.values()}
    is_asked = ask and not as_json
    traffic = traffic_of_hand(
        log, transport, windows, seconds, now, ask=is_asked, channel=channel, wanted=wanted
    )
    _check_windows(windows, traffic)
    names = [name.strip() for name in fingers.split(",") if name.strip()]
    known = Known(database, found, traffic, windows, names, node_ids, said, settings or [], transport)
    proposal, plan, text = draw_up(known, output or Path("hand.toml"))
    _report(plan, text, output, traffic, proposal, accepted=accept, as_json=as_json)


def _connect_product(
    name: str,
    output: Path | None,
    said: "list[Setting]",
    address: str,
    channel: str,
    *,
    as_json: bool,
) -> None:
    from vegrip.connect.writer import checked
    from vegrip.transport.maps.map_text import changed_text
    from vegrip.transport.maps.products import about, map_of

    text = map_of(name).read_text(encoding="utf-8")
    is_on_can = about(name)["carrier"].startswith("can")
    if address and is_on_can:
        raise UsageError(f"{name} is on a CAN bus; give --channel")
    if channel and not is_on_can:
        raise UsageError(f"{name} is no CAN device; give --address")
    given = {"address": address, "channel": channel}
    where = [(["transport", key], value) for key, value in given.items() if value]
    text = changed_text(text, where + said)
    unknown, plan = "", None
    try:
        plan, _ = checked(text, output or Path(f"{name}.toml"), [])
    except ConfigError as error:
        if "is not known" not in str(error):
            raise
        unknown = str(error)
    if output is not None:
        _write(output, text)
    _report(plan, text, output, None, unknown=unknown, as_json=as_json)


def _show_products(*, as_json: bool) -> None:
    from vegrip.transport.maps.products import about, names

    found = [about(name) for name in names()]
    if as_json:
        typer.echo(json.dumps(found))
        return
    content = table("hand", "carrier", "channels", "commands", "to measure", "checked against", "tried on")
    for one in found:
        content.add_row(
            one["hand"],
            one["carrier"],
            ", ".join(dict.fromkeys(SHORT.get(each, each) for each in one["channels"])),
            one["commands"] or "-",
            f"{len(one['to_measure'])} values" if one["to_measure"] else "-",
            one["checked_against"].partition(" at ")[0] or "its source alone",
            ", ".join(one["tried_on"]) or "-",
        )
    show(content)


def _refuse(database: Path | None, output: Path | None, log: Path | None, *, force: bool) -> None:
    for path in (database, log):
        if path is not None and not path.is_file():
            raise InputError(
                f"{path}: {'is a folder; give a file' if path.is_dir() else 'there is no such file'}"
            )
    if output is None:
        return
    if database is not None and database.suffix.lower() == ".toml":
        raise UsageError(f"{database} is a map already and is only checked; leave out -o")
    claim_file(output, force=force)


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


def _check_windows(windows: "dict[str, Window]", traffic: "Traffic | None") -> None:
    for name, (first, last) in windows.items():
        if traffic is not None and traffic.frames and first >= traffic.duration:
            raise InputError(
                f"--{name} {first:g}..{last:g} lies after the end of the traffic, which lasts "
                f"{traffic.duration:.1f} s"
            )


def _write(path: Path, text: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
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


def _settings(text: str) -> "list[Setting]":
    """Return the key and its value; of a table that names a signal, each of its keys, the signal first."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise UsageError(f"--set is {text!r}; write KEY=VALUE, as in fingers.thumb.normal_force.sign=-1")
    path, found = [part.strip() for part in key.split(".")], parsed(value.strip())
    if not isinstance(found, dict) or "signal" not in found:
        return [(path, found)]
    return [([*path, each], found[each]) for each in ("signal", *(found.keys() - {"signal"}))]


def _report(
    plan: "Plan | None",
    text: str,
    output: Path | None,
    traffic: "Traffic | None",
    proposal: "Proposal | None" = None,
    *,
    unknown: str = "",
    accepted: bool = False,
    as_json: bool,
) -> None:
    from vegrip.connect.traffic import values_of
    from vegrip.identification.recording import report
    from vegrip.transport.mapped.price import price

    values = values_of(plan, traffic) if plan is not None and traffic is not None else None
    if values is not None and not values.states:
        refused = ", ".join(f"{count} refused for {name}" for name, count in values.rejected.items())
        raise ConfigError(
            f"the map makes no state of this traffic ({refused or 'no message of it came'}); "
            + (
                "see trigger of [fingers], and counter and checksum of [messages]"
                if proposal is None
                else "say another --set fingers.NAME.trigger=MESSAGE, or --set messages.NAME.counter=false"
            )
        )
    learned, doubts, implausible = _found(proposal, values)
    prices = price(plan) if plan is not None else [unknown]
    absent = values.absent(plan) if values is not None and plan is not None and proposal is None else {}
    lost = [*_losses(traffic, values, proposal), *absent]
    _complain_of(lost, traffic, accepted=accepted)
    if proposal is not None and output is not None:
        _write(output, text)
    if as_json:
        result = {
            "map": str(output) if output is not None else None,
            "ready": plan is not None,
            "fingers": {f.name: sorted(f.measured) for f in plan.fingers} if plan is not None else {},
            "values": values.as_dict() if values is not None else None,
            "learned": learned,
            "open": doubts,
            "implausible": implausible,
            "lost": lost,
            "rows": report.account([traffic.report] if traffic is not None else []),
            "price": prices,
        }
        typer.echo(json.dumps(result))
    else:
        if output is None and text:
            typer.echo(text)
        if values is not None and plan is not None:
            _show(values, plan)
        by_heading = {"found: ": learned, "measure: " if unknown else "price: ": prices, "open:  ": doubts}
        for head, sentences in by_heading.items():
            for sentence in sentences:
                typer.echo(f"{head}{sentence}")
        for sentence in implausible:
            complain(sentence)
        if output is not None:
            then = _next(output, plan) + (" --check" if plan is not None and proposal is None else "")
            typer.echo(f"written: {output}; next: {then}")
    is_too_much = any(report.REFUSED_SHARE <= share < 1.0 for share in absent.values())
    is_too_much = is_too_much or (proposal is not None and bool(proposal.too_much))
    if is_refused := is_too_much and not accepted:
        complain(f"a tenth or more of the traffic is not used; {report.ACCEPT} takes the map as it is")
    if implausible or is_refused:
        raise typer.Exit(InputError.exit_code)


def _found(proposal: "Proposal | None", values: "Values | None") -> tuple[list[str], list[str], list[str]]:
    """Return what was learned, what is open, and what cannot be."""
    wrong = values.implausible(is_by_options=proposal is not None) if values is not None else []
    if proposal is None:
        return [], [], wrong
    return proposal.learned, proposal.doubts, [*proposal.implausible, *wrong]


def _losses(traffic: "Traffic | None", values: "Values | None", proposal: "Proposal | None") -> list[str]:
    """Return what of the traffic is lost; what the codec refused is added to its report."""
    import numpy as np

    from vegrip.identification.recording.report import Kind, gaps_of

    lost = [] if proposal is None else [*proposal.lost, *proposal.too_much]
    if traffic is None:
        return lost
    report = traffic.report
    if not report.rows_read:  # live
        report.rows_read = report.rows_kept = sum(map(len, traffic.frames.values()))
    for name, count in values.rejected.items() if values is not None else ():
        if name in UNREADABLE:
            report.add(Kind.REFUSED, name, count=count)
            report.rows_kept -= count
    for finger, states in values.states.items() if values is not None else ():
        t = np.array([(state.stamp - traffic.start) / NS for state in states])
        report.note_gaps(t, gaps_of(t), f" of {finger}")
    return [*lost, *report.warnings()]


def _complain_of(lost: list[str], traffic: "Traffic | None", *, accepted: bool) -> None:
    for sentence in lost:
        complain(sentence)
    if traffic is not None:
        traffic.report.refuse("the traffic", accepted=accepted)


def _next(output: Path, plan: "Plan | None") -> str:
    if plan is None:
        return f"vegrip connect {output}, when it is known"
    if not plan.hand.transport:
        return f'transport.map = "{output}" in a launch file, or give --channel'
    return f"vegrip launch {output.stem if output.suffix == '.toml' else output}"


def _show(values: "Values", plan: "Plan") -> None:
    from vegrip.transport.maps.units import SI

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
