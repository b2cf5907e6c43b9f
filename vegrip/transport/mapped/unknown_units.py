"""Signals of which a map says nothing until the user does: in percent or counts, or of no known use."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from vegrip.errors import InputError
from vegrip.transport.mapped.database import Database
from vegrip.transport.mapped.drafts import Draft, FingerDraft, is_of_unknown_unit
from vegrip.transport.mapped.guess import all_signals
from vegrip.transport.mapped.proposal import USUAL, Proposal, signals_of
from vegrip.transport.mapped.traffic import Trace
from vegrip.transport.mapped.units import SI, is_force

ONE_IS_WORTH: Final = {"N": "0.25 N", "N*m": "2 mN*m", "m": "0.01 mm", "degC": "0.1 degC", "m/s": "1 mm/s"}
"""Examples of what one count may be."""

MOST_NAMED: Final = 8  # signals of no known use, counted without those alike

FORCES: Final = ("force", "increment")


def leave_out_unknown_units(proposal: Proposal) -> None:
    """Take out of ``proposal`` what its unit does not tell in SI; say the option that keeps it.

    Raises:
        InputError: the normal force is in such a unit.

    """
    options: dict[str, str] = {}  # -> what it is for
    forces = False
    for finger in proposal.fingers.values():
        for channel in [name for name, draft in finger.channels.items() if is_of_unknown_unit(name, draft)]:
            draft = finger.channels.pop(channel)
            forces = forces or channel == "normal_force"
            worth = f"{ONE_IS_WORTH[SI[channel]]}/{_unit(draft)}"
            options.setdefault(f"--set 'fingers.*.{channel}.gain={worth}'", f"{_named(draft)} for {channel}")
        _forget_trigger(finger)
        command = finger.command
        if command is not None and _is_open(command):
            finger.command = None
            option = f"--set 'fingers.*.command.gain=4 {_unit(command)}/N'"
            options.setdefault(option, f"{_named(command)}, which takes the command,")
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


def name_unused(proposal: Proposal, database: Database, heard: Mapping[str, Trace]) -> None:
    """Say which signals that move in the traffic are in no map, and how one of them becomes a channel."""
    guessed = {one.name: one for one in all_signals(database, USUAL)}
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
    moved = {name for name, trace in heard.items() if float(np.ptp(trace.raw)) > 0.0}
    alike: dict[str, list[str]] = {}
    for name in sorted(moved - protection - pages - set(signals_of(proposal)), key=list(heard).index):
        if name in guessed and guessed[name].own not in said:
            alike.setdefault(guessed[name].own, []).append(name)
    if not alike:
        return
    first = next(iter(alike.values()))[0]
    message, _, signal = first.partition(".")
    unit = database.messages[message].signals[signal].unit or "count"
    finger = next(iter(proposal.fingers))
    named = [f"{one[0]} (and {len(one) - 1} alike)" if len(one) > 1 else one[0] for one in alike.values()]
    if len(named) > MOST_NAMED:
        named[MOST_NAMED:] = [f"{len(named) - MOST_NAMED} more"]
    proposal.doubts.append(
        f"not used, as neither name nor unit says for what: {', '.join(named)}; one that is a channel is "
        f'said with what one count is worth: --set \'fingers.{finger}.displacement={{ signal = "{first}", '
        f'gain = "0.01 mm/{unit}" }}\''
    )


def _forget_trigger(finger: FingerDraft) -> None:
    """Take back a trigger of which no channel is left: the message of the force or the indentation is it."""
    names = [name for draft in finger.channels.values() for name in draft.names]
    names += finger.taxels.keys["normal"] if finger.taxels is not None else []
    if finger.trigger not in {*names, *(name.partition(".")[0] for name in names)}:
        finger.trigger = ""


def _is_open(command: Draft) -> bool:
    kind, unit = command.keys.get("kind", "force"), str(command.keys.get("unit", ""))
    return kind in FORCES and not command.keys.get("gain") and not is_force(unit)


def _unit(draft: Draft) -> str:
    return str(draft.keys.get("unit", "")) or "count"


def _named(draft: Draft) -> str:
    return f"{draft.signal} [{_unit(draft)}]"
