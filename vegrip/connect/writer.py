"""A map as it is drawn up from a database, traffic and the user; its file says where each line comes from."""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vegrip.config import parse_toml, toml_key
from vegrip.connect.drafts import Draft, for_each_finger, is_complete
from vegrip.connect.proposal import Proposal, leave_out_unknown_units, name_unused, propose
from vegrip.connect.questions import Window, learn
from vegrip.connect.traffic import Trace, Traffic, traces, values_of, without_what_is_none
from vegrip.errors import ConfigError
from vegrip.identification.recording.checks import mark_in
from vegrip.identification.slip_channel import slides_of, slip_channel
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import Plan, make_plan, read_database
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.map_text import Setting, changed_text, key_line
from vegrip.transport.maps.schema import parse_map

FRICTION_NOTES = {
    "learning": "less is held once it is known",
    "slip_threshold": "[m/s] the slowest slide of the traffic that was felt",
    "slip_delay": "[s] from the fall of the load to the slip flag",
}


@dataclass(frozen=True)
class Known:
    """What a map is drawn up from."""

    path: Path  # of the database
    database: Database
    traffic: Traffic | None
    windows: Mapping[str, Window]
    names: Sequence[str]  # of the fingers
    nodes: Mapping[str, int]
    said: Sequence[Setting]
    options: Sequence[str]  # the same as it was typed
    transport: Mapping[str, Any]


def draw_up(known: Known, target: Path) -> tuple[Proposal, Plan, str]:
    """Return what is proposed of a hand, its plan, and the text of its map, to be written to ``target``."""
    database, traffic = known.database, known.traffic
    came = traces(traffic, database) if traffic is not None else {}
    proposal = propose(database, came, traffic, known.names, known.nodes, known.said)
    received, lost = without_what_is_none(came, database, proposal.keys)
    proposal.database = os.path.relpath(known.path.absolute(), target.absolute().parent)
    if traffic is not None:
        learn(proposal, received, known.windows, database, known.said)
    leave_out_unknown_units(proposal)
    name_unused(proposal, database, received)
    said = for_each_finger(known.said, proposal.fingers)
    about = [f"The hand of {known.path.name}, as vegrip connect proposes it. docs/connect.md has all keys."]
    about += [f"Changed by --set {each}" for each in known.options]
    plan, text = checked(map_text(proposal, known.transport, about), target, said)
    if traffic is None:
        return proposal, plan, text
    if any("slip" in finger.measured for finger in plan.fingers):
        _learn_friction(proposal, plan, traffic, said)
        plan, text = checked(map_text(proposal, known.transport, about), target, said)
    _report_losses(proposal, database, traffic, came, received, lost)
    return proposal, plan, text


def _report_losses(
    proposal: Proposal,
    database: Database,
    traffic: Traffic,
    came: Mapping[str, Trace],
    received: Mapping[str, Trace],
    lost: Mapping[str, int],
) -> None:
    """Say what of the traffic is in no channel: more than 1 % is a warning, a tenth is refused."""
    owners = {
        signal: f"{name}.{channel}"
        for name, finger in proposal.fingers.items()
        for channel, draft in finger.channels.items()
        for signal in draft.names
    }
    for name, where in owners.items():
        if lost.get(name):
            signal, count, whole = database.signal(name), lost[name], len(came[name].t)
            causes = [f"{raw} ({signal.choices[raw]})" for raw in signal.invalid]
            if signal.bounds is not None:
                causes.append(f"values outside {signal.low:g} .. {signal.high:g} {signal.unit}")
            proposal.lose(
                count,
                whole,
                f"{name}: {count} of {whole} values are no measurement, and are missing: "
                f"{', '.join(causes) or 'invalid'}; --set 'fingers.{where}.all_is_measured=true' takes them",
            )
        if name in received and (mark := mark_in(received[name].raw)) is not None:
            proposal.lost.append(
                f"{name} is {mark:g}, raw, in {np.count_nonzero(received[name].raw == mark)} of "
                f"{len(received[name].raw)} frames, far from all others: if that is no measurement, "
                f"--set 'fingers.{where}.invalid=[{mark:.0f}]'"
            )
    for name, count in traffic.short.items():
        message = database.messages[name]
        sizes = [len(frame.data) for frame in traffic.frames[message.identifier]]
        absent = [each for each, one in message.signals.items() if one.end > min(sizes)]
        absent = [each for each in absent if f"{name}.{each}" in owners]
        if not absent:
            continue
        proposal.lose(
            count,
            len(sizes),
            f"{count} frames of {name} are shorter than the {message.length} bytes that {database.name} "
            f"says; missing from them: {', '.join(absent)}; ask for the database of this version of the hand",
        )


def checked(text: str, path: Path, settings: Sequence[Setting]) -> tuple[Plan, str]:
    """Read the text of a map back as a node will; ``settings`` go over it."""
    text = changed_text(text, settings)
    try:
        hand = parse_map(parse_toml(text), path)
        plan = make_plan(hand, read_database(hand), tuple(hand.fingers))
        if not hand.format:
            MappedCodec(plan)  # compiles, and finds what only then shows
    except ConfigError as error:  # there is no such file yet, but options
        written = re.escape(str(path))
        said = re.sub(rf"^{written} \[([^]]+)\]", r"--set \1", str(error))
        raise ConfigError(re.sub(rf"^{written}:", "--set:", said)) from None
    return plan, text


def _learn_friction(proposal: Proposal, plan: Plan, traffic: Traffic, said: Sequence[Setting]) -> None:
    """Find how fine and how late slip is felt, and switch learning on by it."""
    values = values_of(plan, traffic)
    found = slip_channel([each for name in values.states for each in slides_of(values.recording(name))])
    stated = {path[1]: value for path, value in said if path[0] == "friction" and path[1:]}
    if "slip_threshold" in stated:
        found = replace(found, threshold=float(stated["slip_threshold"]))
    if "slip_delay" in stated:
        found = replace(found, delay=float(stated["slip_delay"]))
    proposal.friction = found.settings
    if found.settings:
        proposal.learned.append(
            f"slip is felt from {1e3 * found.threshold:.2g} mm/s on and {1e3 * found.delay:.0f} ms late "
            f"({found.slides} slides), so friction is learned"
        )
    if found.lacking:
        proposal.doubts.append(
            f"friction is not learned: {found.lacking}; or state what is known of the sensor: "
            "--set friction.slip_threshold=1e-4 --set friction.slip_delay=0.02"
        )


def map_text(proposal: Proposal, transport: Mapping[str, Any], about: list[str]) -> str:
    lines = [f"# {line}" for line in about] + [""]
    lines.append(key_line("database", proposal.database, "beside this file"))
    if proposal.nodes:
        lines.append(key_line("nodes", dict(proposal.nodes), "node-ID of each finger"))
    if proposal.rate:
        lines.append(key_line("rate", proposal.rate, "[Hz] of states, as they came"))
    if transport:
        lines += ["", "[transport]", *(key_line(key, value, "") for key, value in transport.items())]
    for name, draft in proposal.messages.items():
        lines += ["", f"[messages.{toml_key(name)}]", *_table(draft)]
    for name, finger in proposal.fingers.items():
        own = [key_line("trigger", finger.trigger, "the last message of a cycle")] if finger.trigger else []
        if finger.max_age:
            own.append(
                key_line("max_age", finger.max_age, "[s] after which a value of another message is missing")
            )
        lines += ["", f"[fingers.{toml_key(name)}]", *own]
        for channel, each in finger.channels.items():
            lines += [f"[fingers.{toml_key(name)}.{channel}]", *_table(each)]
        if finger.taxels is not None:
            lines += [f"[fingers.{toml_key(name)}.taxels]", *_table(finger.taxels)]
        if finger.command is not None and is_complete(finger.command):
            lines += [f"[fingers.{toml_key(name)}.command]", *_table(finger.command)]
    if any(finger.command is not None for finger in proposal.fingers.values()):
        lines += ["", "[command]", key_line("period", 0.02, "[s] the last command is repeated so often")]
        lines.append(key_line("silence", "unknown", "what the hand does when commands stop: holds or opens?"))
    if proposal.friction:
        lines += ["", "[friction]"]
        lines += [
            key_line(key, value, FRICTION_NOTES.get(key, "")) for key, value in proposal.friction.items()
        ]
    if proposal.doubts:
        lines += ["", "# Still open:", *(f"# * {doubt}" for doubt in proposal.doubts)]
    return "\n".join(lines) + "\n"


def _table(draft: Draft) -> list[str]:
    return [
        key_line(key, value, draft.notes.get(key, ""))
        for key, value in draft.keys.items()
        if value not in ("", None)
    ]
