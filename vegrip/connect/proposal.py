"""A first map of a hand from its database and, where there is some, its traffic; and what it leaves open."""

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from vegrip.connect.drafts import Draft, FingerDraft, apply_settings, is_complete, is_of_unknown_unit
from vegrip.connect.find_protection import find_protection
from vegrip.connect.guess import Guess, all_signals, guesses, quantity_of, words_of
from vegrip.connect.traffic import Trace, Traffic, rate_of
from vegrip.errors import InputError
from vegrip.identification.recording.report import LEAST_REFUSED, REFUSED_SHARE, WARNED_SHARE
from vegrip.messages import USUAL_FINGERS
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.map_text import Setting
from vegrip.transport.maps.schema import MAPPED_CHANNELS
from vegrip.transport.maps.units import SI, is_force

FEW_TAXELS: Final = 4
"""Forces of no known axis that make an array."""

MAX_AGE_PERIODS: Final = 3.0  # periods of the slowest message after which its values are missing
ENABLE: Final = {"enable", "en", "enabled", "valid", "active", "on", "run"}
INCREMENT: Final = {"delta", "inc", "increment", "adj", "adjust", "adjustment", "d"}


@dataclass(slots=True)
class Proposal:
    """A map before it is written, and sentences: lessons of the traffic, contradictions, questions."""

    database: str
    fingers: dict[str, FingerDraft]
    messages: dict[str, Draft] = field(default_factory=dict)
    rate: float = 0.0
    learned: list[str] = field(default_factory=list)
    implausible: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)  # what is open, and the option that answers it
    nodes: Mapping[str, int] = field(default_factory=dict)
    friction: Mapping[str, Any] = field(default_factory=dict)
    lost: list[str] = field(default_factory=list)  # of the traffic, more than 1 %
    too_much: list[str] = field(default_factory=list)  # of the traffic, a tenth or more

    @property
    def keys(self) -> dict[str, Mapping[str, Any]]:
        """The keys of each signal's channel that the user gave."""
        return {
            name: {key: value for key, value in draft.keys.items() if draft.is_set_by_user(key)}
            for finger in self.fingers.values()
            for draft in finger.channels.values()
            for name in draft.names
        }

    def lose(self, count: int, whole: int, sentence: str) -> None:
        """Note that ``count`` of ``whole`` values or frames are lost."""
        share = count / whole if whole else 0.0
        is_too_much = share >= REFUSED_SHARE and count >= LEAST_REFUSED
        (self.too_much if is_too_much else self.lost if share > WARNED_SHARE else self.learned).append(
            sentence
        )


def propose(
    database: Database,
    received: Mapping[str, Trace],
    traffic: Traffic | None,
    names: Sequence[str] = (),  # of the fingers, in the order of the hand's numbers
    nodes: Mapping[str, int] | None = None,
    settings: Sequence[Setting] = (),
) -> Proposal:
    """Return the map that names, units and traffic suggest; ``settings`` of the user go over every guess."""
    found, silent = guesses(database, tuple(names) or USUAL_FINGERS), list[str]()
    if any(not database.messages[one.message].asked for one in found if one.channel in MAPPED_CHANNELS):
        found = [one for one in found if not database.messages[one.message].asked]
    if traffic is not None:
        if not received:
            raise InputError(_nothing_received(database, traffic))
        spoken = {name.partition(".")[0] for name in received}
        measured = [one for one in found if one.channel in MAPPED_CHANNELS and one.finger]
        with_traffic = {one.finger for one in measured if one.message in spoken}
        silent = sorted({one.message for one in measured if one.finger not in with_traffic}, key=_natural)
        ordered = {one.message for one in found if one.channel == "command"}
        found = [one for one in found if one.message in spoken or one.message in ordered]
        found = [one for one in found if one.message in spoken or one.channel not in MAPPED_CHANNELS]
    fingers = _by_finger(found, tuple(names))
    drafts = {name: _finger(own, database) for name, own in fingers.items()}
    guessed = all_signals(database, tuple(names) or USUAL_FINGERS)
    for name, draft in drafts.items():
        places = {one.finger for one in fingers[name]} - {""}
        own = {one.own: one.name for one in guessed if one.finger in places}
        draft.alike = {one.name: own[one.own] for one in guessed if one.own in own}
    apply_settings(drafts, settings)
    _take_units(drafts, database)
    drafts = {name: draft for name, draft in drafts.items() if draft.channels or draft.taxels is not None}
    if not drafts:
        raise InputError(
            f"{database.name}: no signal looks like the force or position of a fingertip; "
            "say which it is: --set fingers.thumb.normal_force.signal=MESSAGE.SIGNAL"
        )
    proposal = Proposal(database.name, drafts, nodes=nodes or {})
    said = {path[1] for path, _ in settings if path[0] == "messages" and path[2:3] == ["checksum"]}
    proposal.messages, doubts = find_protection(database, signals_of(proposal), found, traffic, said)
    proposal.doubts += doubts
    if traffic is not None:
        _time(proposal, database, traffic, received)
    _doubt(proposal, fingers)
    _doubt_names(proposal, database, tuple(names), silent)
    proposal.doubts += [f"left out: {why}" for why in database.left_out.values()]
    return proposal


def _take_units(drafts: Mapping[str, FingerDraft], database: Database) -> None:
    for finger in drafts.values():
        for draft in (*finger.channels.values(), *([finger.command] if finger.command else [])):
            message, _, signal = draft.signal.partition(".")
            found = database.messages.get(message)
            if found is not None and signal in found.signals and "unit" not in draft.keys:
                draft.keys["unit"] = found.signals[signal].unit
                draft.notes["unit"] = "as the database says"


def _nothing_received(database: Database, traffic: Traffic) -> str:
    if not traffic.frames:
        return (
            "no frame came; look at channel and bit rate, and whether the hand is switched on; of a log, "
            "whether it is one (.asc, .blf, .trc, .mf4, .mdf, or .log of candump)"
        )
    known = [
        f"{why}, and {len(traffic.frames[identifier])} frames of 0x{identifier & 0x1FFFFFFF:X} came"
        for identifier, why in database.left_out.items()
        if identifier in traffic.frames
    ]
    if known:
        return f"{database.name}: {'; '.join(known)}"
    names = {message.identifier: message.name for message in database.messages.values()}
    short = [
        f"{len(frames)} frames of {names[identifier]} came, which hold none of its signals: they have "
        f"{max(len(frame.data) for frame in frames)} bytes at most"
        for identifier, frames in traffic.frames.items()
        if identifier in names
    ]
    if short:
        return f"{database.name}: {'; '.join(short)}"
    seen = ", ".join(f"0x{identifier & 0x1FFFFFFF:X}" for identifier in sorted(traffic.frames)[:6])
    return (
        f"no message of {database.name} came, but {sum(map(len, traffic.frames.values()))} frames of {seen}: "
        "this is another database, or another hand"
    )


def _by_finger(found: list[Guess], names: tuple[str, ...]) -> dict[str, list[Guess]]:
    numbers = sorted({int(one.finger[1:]) for one in found if one.finger.startswith("#")})
    order = names or USUAL_FINGERS
    first = 0 if 0 in numbers else 1
    of_number = {n: order[n - first] if 0 <= n - first < len(order) else f"finger{n}" for n in numbers}
    fingers: dict[str, list[Guess]] = {}
    alone = order[0] if names else "thumb"
    named_fingers = {
        _named(one.finger, of_number) for one in found if one.finger and one.channel in MAPPED_CHANNELS
    }
    for one in found:
        name = _named(one.finger, of_number)
        for each in (
            [name]
            if name
            else sorted(named_fingers)
            if one.channel == "command" and named_fingers
            else []
            if named_fingers
            else [alone]
        ):
            fingers.setdefault(each, []).append(one)
    ordered = sorted(fingers, key=lambda name: (order.index(name) if name in order else 99, name))
    wanted = [name for name in ordered if not names or name in names]
    return {name: fingers[name] for name in wanted}


def _named(finger: str, of_number: Mapping[int, str]) -> str:
    return of_number[int(finger[1:])] if finger.startswith("#") else finger


def _finger(found: list[Guess], database: Database) -> FingerDraft:
    draft = FingerDraft()
    taken: set[str] = set()
    for one in found:
        if (
            one.channel in MAPPED_CHANNELS
            and one.channel not in ("torque_x", "torque_y")
            and one.channel not in draft.channels
        ):
            draft.channels[one.channel] = _channel(one, database)
            taken.add(one.name)
    draft.others = [
        one for one in found if one.name not in taken and (one.channel == "force" or "force" in one.channel)
    ]
    forces = [one for one in draft.others if one.channel == "force"]
    if "normal_force" not in draft.channels and len(forces) >= FEW_TAXELS:
        names = [one.name for one in sorted(forces, key=lambda one: _natural(one.name))]
        unit = database.signal(forces[0].name).unit
        draft.taxels = Draft(
            {"normal": names, "unit": unit}, {"normal": "forces of no axis in one array, summed"}
        )
        draft.others = []
    elif "normal_force" not in draft.channels and forces:
        draft.channels["normal_force"] = _channel(forces[0], database)
    # two shears of no named axis are x and y in their order, until a shear shows
    second = next((one for one in draft.others if one.channel == "tangential_force_x"), None)
    if second is not None and "tangential_force_y" not in draft.channels:
        draft.channels["tangential_force_y"] = _channel(second, database)
        draft.others.remove(second)
    command = next((one for one in found if one.channel == "command"), None)
    if command is not None:
        draft.command = _command(command, database)
    return draft


def _natural(name: str) -> list[tuple[int, str]]:
    return [(int(word), "") if word.isdecimal() else (-1, word) for word in words_of(name)]


def _channel(one: Guess, database: Database) -> Draft:
    unit = database.signal(one.name).unit
    draft = Draft({"signal": one.name, "unit": unit}, {"signal": one.why})
    draft.notes["unit"] = "as the database says" if unit else "the database has none: taken as SI"
    if invalid := database.signal(one.name).invalid:
        draft.keys["invalid"] = list(invalid)
        choices = database.signal(one.name).choices
        draft.notes["invalid"] = f"not measured: {', '.join(choices[raw] for raw in invalid)}"
    return draft


def _command(one: Guess, database: Database) -> Draft:
    message = database.messages[one.message]
    signal = message.signals[one.signal]
    quantity = quantity_of(signal.unit)
    kind = {"length": "position", "angle": "position", "current": "current"}.get(quantity, "force")
    if kind == "force" and set(words_of(one.signal)) & INCREMENT:
        kind = "increment"
    keys: dict[str, Any] = {"signal": one.name, "kind": kind, "unit": signal.unit}
    enable = {name: 1 for name in message.signals if set(words_of(name)) & ENABLE}
    if enable:
        keys["set"] = enable
    notes = {"signal": one.why, "kind": f"by its unit, {signal.unit or 'none'}"}
    return Draft(keys, {**notes, "set": "the names say that it must be on"} if enable else notes)


def signals_of(proposal: Proposal) -> list[str]:
    """Return the signals that the map reads and writes."""
    return [
        name
        for finger in proposal.fingers.values()
        for name in (*finger.signals, *(finger.command.names if finger.command is not None else ()))
    ]


def _time(proposal: Proposal, database: Database, traffic: Traffic, received: Mapping[str, Trace]) -> None:
    rates: list[float] = []
    for finger in proposal.fingers.values():
        signals = [name for name in finger.signals if name in received]
        if not signals:
            continue
        own = {name: rate_of(received[name]) for name in signals}
        main = finger.channels.get("normal_force") or finger.channels.get("displacement")
        lead = next((name for name in (main.names if main is not None else ()) if name in own), signals[0])
        rates.append(own[lead])
        messages = {name.partition(".")[0] for name in signals}
        if len(messages) > 1:
            cycle = {name.partition(".")[0] for name, rate in own.items() if rate > 0.8 * own[lead]}
            last = _last_of(sorted(cycle), lead.partition(".")[0], database, traffic)
            finger.trigger = _trigger(last, lead, signals, database)
        slowest = min((rate for rate in own.values() if rate), default=0.0)
        finger.max_age = round(MAX_AGE_PERIODS / slowest, 4) if slowest else 0.0
    proposal.rate = round(min(rates), 1) if rates and min(rates) > 0.0 else 0.0


def _trigger(message: str, lead: str, signals: Sequence[str], database: Database) -> str:
    own = sorted(
        (name for name in signals if name.partition(".")[0] == message), key=lambda name: name != lead
    )
    return own[0] if database.signal(own[0]).selected_by else message


def _last_of(names: list[str], lead: str, database: Database, traffic: Traffic) -> str:
    """Return the message that comes last in a cycle: the one before the longest pause."""
    stamps = sorted(
        (frame.stamp, name)
        for name in names
        for frame in traffic.frames.get(database.messages[name].identifier, [])
    )
    pauses: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    for (stamp, name), (after, _) in itertools.pairwise(stamps):
        pauses[name] += after - stamp
        counts[name] += 1
    mean = {name: pauses[name] / counts[name] for name in counts}
    return max(mean, key=lambda name: mean[name]) if mean else lead


def _doubt(proposal: Proposal, fingers: Mapping[str, list[Guess]]) -> None:
    for name, finger in proposal.fingers.items():
        where = f"fingers.{name}"
        kinds = {one.channel: one for one in reversed(fingers.get(name, []))}
        if "displacement" not in finger.channels and "joint" in kinds:
            proposal.doubts.append(
                f"{kinds['joint'].name} is an angle; to make an indentation of it, give the lever: "
                f'--set {where}.displacement=\'{{ signal = "{kinds["joint"].name}", gain = "40 mm/rad" }}\''
            )
        if "normal_force" not in finger.channels and finger.taxels is None and "current" in kinds:
            proposal.doubts.append(
                f"{kinds['current'].name} is a current; as a poor force give its gain and noise: --set "
                f'{where}.normal_force=\'{{ signal = "{kinds["current"].name}", gain = "2.5 '
                "N/A\", noise = 0.3 }'"
            )
        if finger.command is not None:
            _doubt_command(proposal, finger.command, where)


def _doubt_names(
    proposal: Proposal, database: Database, names: tuple[str, ...], silent: Sequence[str]
) -> None:
    left = [name for name in names if name not in proposal.fingers]
    if silent:
        proposal.doubts.append(
            f"{', '.join(left) or 'a further finger'}: no frame of {', '.join(silent)} came, so it is left "
            "out; look whether it is connected and switched on, and give a log in which it speaks"
        )
    elif left:
        proposal.doubts.append(
            f"{', '.join(left)}: no name, letter or number shows a further finger in {database.name}; "
            f"if there is one, say its force: --set fingers.{left[0]}.normal_force.signal=MESSAGE.SIGNAL"
        )
    numbers = {one.finger for one in guesses(database, USUAL_FINGERS) if one.channel in MAPPED_CHANNELS}
    numbers = {number for number in numbers if number.startswith("#")}
    if 0 < len(names) < len(numbers):
        proposal.doubts.append(
            f"the hand has {len(numbers)} fingers and {len(names)} names: give --fingers a name for each, or "
            "the others stay out"
        )


def _doubt_command(proposal: Proposal, command: Draft, where: str) -> None:
    kind = command.keys.get("kind", "force")
    needed = {"position": ("stiffness", "2 N/mm"), "current": ("gain", "0.4 A/N")}.get(kind)
    if needed is not None and not is_complete(command):
        proposal.doubts.append(
            f"{command.signal} takes a {kind}, so nothing is commanded until you say the "
            f"{needed[0]}: --set '{where}.command.{needed[0]}={needed[1]}'"
            + (f" and --set {where}.command.feedback=MESSAGE.SIGNAL" if needed[0] == "stiffness" else "")
        )


ONE_IS_WORTH: Final = {"N": "0.25 N", "N*m": "2 mN*m", "m": "0.01 mm", "degC": "0.1 degC", "m/s": "1 mm/s"}
"""Examples of what one count may be."""

ASKED: Final = ("normal_force", "tangential_force_x", "tangential_force_y", "displacement", "torque_z")
MOST_NAMED: Final = 8  # signals of no known use, counted without those alike


def leave_out_unknown_units(proposal: Proposal) -> None:
    """Take out of ``proposal`` what its unit does not show in SI; say the option that keeps it."""
    options: dict[str, str] = {}  # -> what it is for
    forces = False
    for finger in proposal.fingers.values():
        for channel in [name for name, draft in finger.channels.items() if is_of_unknown_unit(name, draft)]:
            draft = finger.channels.pop(channel)
            forces = forces or channel == "normal_force"
            worth = f"{ONE_IS_WORTH[SI[channel]]}/{_unit(draft)}"
            options.setdefault(
                f"--set 'fingers.*.{channel}.gain={worth}'", f"{_in_unit(draft)} for {channel}"
            )
        if finger.trigger not in {*finger.signals, *(name.partition(".")[0] for name in finger.signals)}:
            finger.trigger = ""
        command = finger.command
        if command is not None and _is_open(command):
            finger.command = None
            option = f"--set 'fingers.*.command.gain=4 {_unit(command)}/N'"
            options.setdefault(option, f"{_in_unit(command)}, which takes the command,")
    if not options:
        return
    if forces:
        raise InputError(
            f"{proposal.database}: the units do not say how many newtons one is, so nothing is written; say "
            f"it with numbers of your own: {' '.join(options)}"
        )
    proposal.doubts += [
        f"{what} is left out: its unit is none of this quantity; say what one is worth, with a number of "
        f"your own: {option}"
        for option, what in options.items()
    ]


def name_unused(proposal: Proposal, database: Database, received: Mapping[str, Trace]) -> None:
    """Say which signals that move in the traffic are in no map, and how one of them becomes a channel."""
    guessed = {one.name: one for one in all_signals(database, USUAL_FINGERS)}
    protection = {
        f"{name}.{signal}"
        for name, draft in proposal.messages.items()
        for signal in (draft.keys.get("counter"), draft.keys.get("checksum", {}).get("signal"))
    }
    said = {guessed[name].own for name in guessed if any(f"{name} " in doubt for doubt in proposal.doubts)}
    pages = {
        f"{message.name}.{signal.selected_by}"
        for message in database.messages.values()
        for signal in message.signals.values()
    }
    moved = {name for name, trace in received.items() if float(np.ptp(trace.raw)) > 0.0}
    alike: dict[str, list[str]] = {}
    for name in sorted(moved - protection - pages - set(signals_of(proposal)), key=list(received).index):
        if name in guessed and guessed[name].own not in said:
            alike.setdefault(guessed[name].own, []).append(name)
    if not alike:
        return
    forces = {one.name for finger in proposal.fingers.values() for one in finger.others}
    directed = [names for names in alike.values() if forces.isdisjoint(names)]
    if len(directed) < len(alike):
        proposal.doubts.append(
            f"not used, as no name says the direction of these forces: "
            f"{_listed([names for names in alike.values() if names not in directed])}; --press A..B and "
            "--shear A..B, windows of the log in which a finger is pressed, and pulled along its +x, show it"
        )
    if directed:
        proposal.doubts.append(
            f"not used, as neither name nor unit says for what: {_listed(directed)}; one that is a channel "
            f"is said with what one count is worth: {option_of(directed[0][0], proposal, database)}"
        )


def _listed(alike: Sequence[Sequence[str]]) -> str:
    named = [f"{one[0]} (and {len(one) - 1} alike)" if len(one) > 1 else one[0] for one in alike]
    if len(named) > MOST_NAMED:
        named[MOST_NAMED:] = [f"{len(named) - MOST_NAMED} more"]
    return ", ".join(named)


def option_of(signal: str, proposal: Proposal, database: Database) -> str:
    """Return the option that makes ``signal``, of a unit that does not show, the first channel that lacks."""
    fingers = [finger for finger in proposal.fingers.values() if finger.taxels is None]
    lacking = (one for one in ASKED if any(one not in finger.channels for finger in fingers))
    channel = next(lacking, "displacement")
    worth = f"{ONE_IS_WORTH[SI[channel]]}/{database.signal(signal).unit or 'count'}"
    return f'--set \'fingers.*.{channel}={{ signal = "{signal}", gain = "{worth}" }}\''


def _is_open(command: Draft) -> bool:
    kind, unit = command.keys.get("kind", "force"), str(command.keys.get("unit", ""))
    return kind in ("force", "increment") and not command.keys.get("gain") and not is_force(unit)


def _unit(draft: Draft) -> str:
    return str(draft.keys.get("unit", "")) or "count"


def _in_unit(draft: Draft) -> str:
    return f"{draft.signal} [{_unit(draft)}]"
