"""What a foreign hand does not tell, and what that costs: sentences at the start, and settings that follow.

A channel that is not there, a message without a counter or a checksum, a slow hand, a protocol that cannot
say "stop": each is a fault that will not be seen, or a bound that is wider. The node says so once, before it
grips.
"""

import math
from collections import Counter
from typing import Any, Final

from vegrip.identification.sensors import lacking
from vegrip.transport.mapped.encoder import CommandEncoder
from vegrip.transport.mapped.plan import FingerPlan, Plan
from vegrip.transport.mapped.schema import HandMap

TIME_OUT: Final = 0.05  # [s] of the watchdog unless the hand is too slow for it
SILENT_AFTER_STATES: Final = 3  # that may be missing before a hand is silent
STATE_IT: Final = "or state the load in the map: tangential_force_x = { stated = '1.5 N' }, and y as '0 N'"
MIN_SLIP_RATE_HZ: Final = 100.0  # [Hz] below which a slip is over before it is seen
NOISE_CHANNELS: Final = {
    "normal_force": "normal_force",
    "displacement": "displacement",
    "tangential_force_x": "tangential_force",
    "tangential_force_y": "tangential_force",
    "torque_z": "torque_z",
    "contact_radius": "contact_radius",
    "temperature": "temperature",
}


def price(plan: Plan) -> list[str]:
    """Return what the owner of the hand must know before it grips, a sentence each."""
    said = [f"{finger.name}: {text}" for finger in plan.fingers for text in _finger(plan, finger)]
    return [*said, *_messages(plan), *_rate(plan), *_commands(plan)]


def settings(hand: HandMap) -> dict[str, Any]:
    """Return the parameters of the grip controller that follow from the map; the user's go before them."""
    found: dict[str, Any] = {}
    noise = _noise(hand)
    if noise:
        found["noise"] = noise
    if hand.rate and SILENT_AFTER_STATES / hand.rate > TIME_OUT:
        found["watchdog"] = {"time_out": round(SILENT_AFTER_STATES / hand.rate, 4)}
    return found


def _noise(hand: HandMap) -> dict[str, float]:
    """The largest of all fingers: one noise serves them all."""
    found: dict[str, float] = {}
    for mapped in hand.fingers.values():
        for name, source in mapped.channels.items():
            if source.noise and name in NOISE_CHANNELS:
                key = NOISE_CHANNELS[name]
                found[key] = max(found.get(key, 0.0), source.noise)
        if mapped.taxels is not None and mapped.taxels.noise:
            found["normal_force"] = max(found.get("normal_force", 0.0), mapped.taxels.noise)
    return found


def _finger(plan: Plan, finger: FingerPlan) -> list[str]:
    channels = finger.measured
    said = lacking(channels, STATE_IT)
    stated = [name for name, channel in finger.channels.items() if channel.stated]
    said += [
        (
            f"{name} is stated as {plan.hand.fingers[finger.name].channels[name].stated}, not "
            "measured: the margin is that for this value and no other"
        )
        for name in stated
    ]
    poor = [
        name
        for name, source in plan.hand.fingers[finger.name].channels.items()
        if source.gain and name == "normal_force"
    ]
    if poor and not plan.hand.fingers[finger.name].channels["normal_force"].noise:
        said.append(
            "normal_force is made from another quantity and has no 'noise': state its standard "
            "deviation, or it is believed like a force sensor"
        )
    return said


def _messages(plan: Plan) -> list[str]:
    if plan.hand.format:
        return [
            (
                "messages have no checksum, and a counter only if you map one: a repeated or "
                "replayed state is not distinguished from a new one"
            )
        ]
    asked = [name for name in plan.messages if plan.database.messages[name].asked]
    bare = [
        name for name in plan.messages if name not in plan.protection or not plan.protection[name].counter
    ]
    open_ = [
        name
        for name in plan.messages
        if name not in plan.protection or plan.protection[name].checksum.kind == "none"
    ]
    said = []
    if asked:
        said.append(
            f"{_list(asked)}: values are asked for one after the other, one each "
            f"{1e3 * plan.hand.sending.poll:g} ms and node, so they are not of the same moment"
        )
    if bare:
        said.append(
            f"{_list(bare)}: no counter: a lost, repeated or replayed message is not seen, only "
            "silence and values that stand still"
        )
    if open_:
        said.append(
            f"{_list(open_)}: no checksum: what a sender damages before the bus is believed if it is in range"
        )
    return said


def _rate(plan: Plan) -> list[str]:
    rate = plan.hand.rate
    if not rate:
        return [
            (
                "the rate of states is not stated (rate = ...): silence counts after 50 ms, which a "
                "hand below 60 Hz does not keep"
            )
        ]
    if rate >= MIN_SLIP_RATE_HZ:
        return []
    late = 1e3 / rate
    said = [
        (
            f"states come at {rate:g} Hz: a slip is seen up to {late:.0f} ms later than it begins; "
            "keep a larger margin (grip.wanted_margin)"
        )
    ]
    if SILENT_AFTER_STATES / rate > TIME_OUT:
        said.append(
            f"the hand counts as silent after {1e3 * SILENT_AFTER_STATES / rate:.0f} ms instead of 50 ms"
        )
    return said


def _commands(plan: Plan) -> list[str]:
    mute = [finger.name for finger in plan.fingers if plan.hand.fingers[finger.name].command is None]
    said = []
    if mute:
        said.append(f"{_list(mute)}: no command is mapped: margins are published, no finger is commanded")
    if len(mute) == len(plan.fingers):
        return said
    sending = plan.hand.sending
    ending = {
        "holds": "it holds when they stop, as the map says",
        "opens": "it OPENS when they stop: should this computer fail, the grip is lost",
        "unknown": "what it does when they stop is not known; find out, and write command.silence",
    }[sending.silence]
    said.append(
        "their commands have no lifetime: the last one is repeated every "
        f"{1e3 * sending.period:.0f} ms; {ending}"
    )
    said += [_kind(plan, finger.name) for finger in plan.fingers if _kind(plan, finger.name)]
    if plan.hand.format:
        return said
    encoder = CommandEncoder(plan, lambda _: (math.nan, math.nan), Counter())
    said += [
        f"{name}: sent as zero, since the map does not say otherwise: {', '.join(unset)}"
        for name, unset in encoder.unset.items()
        if unset
    ]
    return said


def _kind(plan: Plan, finger: str) -> str:
    command = plan.hand.fingers[finger].command
    if command is None or command.kind == "force":
        return ""
    return {
        "increment": (
            f"{finger}: commands are increments: one that is lost is missing from the grip until the "
            "measured force says so"
        ),
        "position": (
            f"{finger}: commands are positions: the force is right only as far as the stiffness "
            f"{command.stiffness} is, and follows the measured force"
        ),
        "current": (
            f"{finger}: commands are currents: friction in the drive is not seen, and the force is "
            f"right only as far as the gain {command.gain} is"
        ),
    }[command.kind]


def _list(names: list[str]) -> str:
    return ", ".join(names) if len(names) <= 4 else f"{', '.join(names[:3])} and {len(names) - 3} more"
