"""``vegrip calibrate --weight``: the gain of the tangential channels from weights that are lifted."""

import shlex
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from vegrip.cli._terminal import answer, complain, printer
from vegrip.cli._written_settings import write_settings, written_settings
from vegrip.clock import NS
from vegrip.config import read_toml, toml_value
from vegrip.errors import InputError, UsageError

if TYPE_CHECKING:
    from vegrip.identification.lifted_weight import Hold
    from vegrip.identification.recording import Recording
    from vegrip.identification.recording.report import LoadReport
    from vegrip.identification.tangential_gain import TangentialGain

SIDEWAYS = (
    "each finger's tangential force is taken as its share of the weight: the pads face sideways, and do not "
    "push against each other along the surface"
)
IN_AIR = "zeros are those of open fingers"
AT_FIRST = "no finger is open: zeros are those of the first rows, in which nothing is carried yet"


def weigh(
    places: Sequence[Path],
    weights: Sequence[str],
    node: str,
    seconds: float,
    hand: Path | None,
    launch: Path | None,
    *,
    as_json: bool,
) -> None:
    """Report the gains from the lifts in ``places``, or from what ``node`` feels now, and write them."""
    from vegrip.identification.recording.units import parse_mass
    from vegrip.identification.tangential_gain import tangential_gain

    masses = [parse_mass(text, "--weight") for text in weights]
    if launch is not None:
        written_settings(launch, "sensors")  # a file that cannot be read is refused before a weight is lifted
    if node:
        lifts = [_from_node(node, places, masses, seconds)]
    else:
        lifts = [(place.name, _fingers_in(place, hand)) for place in places]
    if not lifts:
        raise UsageError("name the recording of the lift, or a running node: --node grasp_force")
    if len(masses) not in (1, len(lifts)):
        raise UsageError(
            f"recordings are {len(lifts)} and weights {len(masses)}; give one --weight, or one for each"
        )
    names, holds = _holds(lifts, masses if len(masses) > 1 else masses * len(lifts))
    found = tangential_gain(names, holds)
    if launch is not None:
        settings = found.settings
        if "fingers" not in settings and any("fingers" in one for one in written_settings(launch, "sensors")):
            settings["fingers"] = {}  # what is there counts no longer
        write_settings(
            launch, "sensors", settings, f"measured by vegrip calibrate --weight {shlex.join(weights)}"
        )
    assumed = [SIDEWAYS, IN_AIR if all(hold.is_zeroed_in_air for hold in holds) else AT_FIRST]
    answer(_as_dict(found, assumed, launch), lambda: _print(found, assumed, launch), as_json=as_json)


def _holds(
    lifts: "Sequence[tuple[str, Mapping[str, Recording]]]", masses: Sequence[float]
) -> "tuple[list[str], list[Hold]]":
    from vegrip.identification.lifted_weight import find_holds

    names, holds = list(lifts[0][1]), list["Hold"]()
    for (what, fingers), mass in zip(lifts, masses, strict=True):
        if set(fingers) != set(names):
            raise InputError(f"{what} has {', '.join(fingers)}, and {lifts[0][0]} has {', '.join(names)}")
        first = holds[-1].lift + 1 if holds else 0
        holds += find_holds({name: fingers[name] for name in names}, mass, what, first)
    return names, holds


def _from_node(
    node: str, places: Sequence[Path], masses: Sequence[float], seconds: float
) -> "tuple[str, Mapping[str, Recording]]":
    from vegrip.cli.record import record_from_node
    from vegrip.identification.recording.session import read_fingers

    if len(places) > 1 or len(masses) > 1:
        raise UsageError("with --node one weight is lifted, and one folder keeps its recording")
    with tempfile.TemporaryDirectory(prefix="vegrip-calibrate-") as scratch:
        target = places[0] if places else Path(scratch) / "lift"
        typer.echo(
            f"for {seconds:g} s: open the fingers, grip the weight, lift it, hold it still for three seconds",
            err=True,
        )
        record_from_node(node, target, seconds)
        return node, read_fingers(target, announce=False)


def _fingers_in(place: Path, hand: Path | None) -> "Mapping[str, Recording]":
    """Return the recordings of a session, an MCAP file or a CAN log, by finger."""
    from vegrip.identification.recording.log_names import LOGS_OR_CANDUMP
    from vegrip.identification.recording.mcap import read_mcap
    from vegrip.identification.recording.session import read_fingers

    suffix = place.suffix.lower()
    if place.is_dir():
        return read_fingers(place, announce=False)
    if not place.is_file():
        raise InputError(f"{place}: there is no such recording")
    if suffix == ".mcap":
        with tempfile.TemporaryDirectory(prefix="vegrip-calibrate-") as scratch:
            return {each.fingertip.name: each for each in read_mcap(place, Path(scratch) / "lift").values()}
    if suffix not in LOGS_OR_CANDUMP:
        raise InputError(
            f"{place}: is no folder of fingers, MCAP file or CAN log; vegrip import takes tables"
        )
    return _of_own_layout(place) if hand is None else _of_a_map(place, hand)


def _of_own_layout(log: Path) -> "Mapping[str, Recording]":
    from vegrip.identification.recording.can_log import read_can_log
    from vegrip.messages import USUAL_FINGERS

    remedy = "vegrip import --channel {0}, and give the folder that it makes"
    found = read_can_log(log, USUAL_FINGERS, remedy=remedy)
    for finger, recording in found.items():
        _report_losses(f"{log}: {finger}", recording.report)
    return found


def _report_losses(where: str, report: "LoadReport") -> None:
    for sentence in report.warnings():
        complain(f"{where}: {sentence}")
    report.refuse(where, accepted=True)  # what is ambiguous


def _of_a_map(log: Path, hand: Path) -> "Mapping[str, Recording]":
    import dataclasses

    from vegrip.connect.traffic import traffic_of, values_of
    from vegrip.identification.recording.can_frames import read_log
    from vegrip.transport.mapped.plan import open_plan

    plan = open_plan(_map_of(hand))
    channel = str(plan.hand.transport.get("channel", ""))
    own = {message.identifier for message in plan.database.messages.values()}
    remedy = 'channel = "{0}" in [transport] of the map'
    read = read_log(log, extended=True, channel=channel, wanted=own, remedy=remedy)
    values = values_of(plan, traffic_of(read.frames))
    _report_losses(str(log), read.report)
    for sentence in values.absent(plan):
        complain(f"{log}: {sentence}")
    if not values.states:
        raise InputError(f"{log}: {hand} makes no state of its frames; is it the map of this hand?")
    start = min(states[0].stamp for states in values.states.values())
    found = {}
    for name, states in values.states.items():
        recording = values.recording(name)
        found[name] = dataclasses.replace(recording, t=recording.t + (states[0].stamp - start) / NS)
    return found


def _map_of(file: Path) -> Path:
    """Return the map that ``file`` is, or that it names as a launch file."""
    from vegrip.runtime.launch_file import find_launch_file, read_launch_file

    if isinstance(read_toml(file).get("fingers"), Mapping):
        return file
    maps = [
        node.transport["map"]
        for node in read_launch_file(find_launch_file(str(file)))
        if "map" in node.transport
    ]
    if not maps:
        raise InputError(f"{file}: is no map, and names none")
    return Path(maps[0])


def _as_dict(found: "TangentialGain", assumed: list[str], launch: Path | None) -> dict[str, Any]:
    return {
        "gain": found.common.value,
        "std": found.common.std,
        "fingers": {name: {"gain": each.value, "std": each.std} for name, each in found.fingers.items()},
        "each_finger_known": found.are_separated,
        "weights": [
            {"mass": one.mass, "gain": one.gain.value, "std": one.gain.std, "lifts": one.lifts}
            for one in found.weights
        ],
        "lifts": found.lifts,
        "seconds": found.seconds,
        "depends_on_load": found.load_dependence > 0.0,
        "assumed": assumed,
        "settings": found.settings,
        "written": None if launch is None else str(launch),
    }


def _print(found: "TangentialGain", assumed: list[str], launch: Path | None) -> None:
    console = printer()
    lifts = f"{found.lifts} lift{'s' if found.lifts > 1 else ''}"
    console.print(
        f"tangential forces read {found.common.meaning}: gain {found.common} of the sum of "
        f"{', '.join(found.fingers)} ({lifts}, still for {found.seconds:.1f} s)",
        style="bold",
    )
    for name, gain in found.fingers.items():
        console.print(f"{name}: {gain}, {gain.meaning}")
    if not found.are_separated:
        console.print(
            "the shares do not distinguish the fingers, so all get the gain of the sum, with a std for "
            "their differences; lift with other shares too, best with one finger alone"
        )
    if found.load_dependence:
        gains = ", ".join(f"{one.gain} at {one.mass:g} kg" for one in found.weights)
        console.print(
            f"the gain depends on the load: {gains} differ by more than their errors; the std covers both"
        )
    for sentence in assumed:
        console.print(f"- {sentence}")
    values = ", ".join(f"sensors.{key} = {toml_value(value)}" for key, value in found.settings.items())
    where = f"written into {launch}" if launch is not None else "to grip by it add --launch FILE"
    console.print(f"{where}: {values}", soft_wrap=True)
