"""What a foreign hand does not send, and what that costs: sentences at the start, and settings that follow.

A channel that is not there, a message without a counter or a checksum, a slow hand, a protocol that cannot
say "stop": each is a fault that will not be seen, or a bound that is wider. The node says so once, before it
grips.
"""

import math
from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any, Final

from vegrip.grip.safety import MECHANICAL, WatchdogSettings
from vegrip.identification.sensors import lacking
from vegrip.transport.mapped.commands import FrameCommands
from vegrip.transport.mapped.largest_force import describe_limit, largest_force
from vegrip.transport.mapped.plan import VECTORS, FingerPlan, Plan
from vegrip.transport.maps.schema import HandMap, MessageMap

WATCHDOG: Final = WatchdogSettings()  # unless the hand is slower, or coarser, than that
LONGEST_WAIT: Final = 1800.0  # [s] for a sensor of which the noise moves nothing
USUAL_NOISE: Final = {
    "normal_force": 0.01, "tangential_force": 0.01, "torque_z": 1e-4, "displacement": 5e-6,
}  # fmt: skip
"""[SI] Standard deviations that the estimator believes where none is stated."""
SILENT_AFTER_STATES: Final = 3  # that may be missing before a hand is silent
HELD_STATES: Final = 4  # in the greatest age of a message from which on its values may be held
STATE_IT: Final = "or state the load in the map: tangential_force_x = { stated = '1.5 N' }, and y as '0 N'"
UNPROTECTED: Final = (
    "messages have no checksum, and a counter only if you map one: a repeated or replayed state is not "
    "distinguished from a new one"
)
UNKNOWN_RATE: Final = (
    "the rate of states is not stated (rate = ...): silence counts after 50 ms, which a hand below 60 Hz "
    "does not keep"
)
OF_THE_GRIP: Final = ("friction", "sensors", "limits")  # tables that are handed on as they stand
STUCK_STEPS: Final = 3  # of its sensor, within which the force of a tip that is pressed in cannot stay
SOFT_TIP: Final = 1e3  # [N/m] stiffness of a soft tip
MIN_SLIP_RATE_HZ: Final = 100.0  # [Hz] below which a slip is over before it is seen
NOISE_CHANNELS: Final = {
    "normal_force": "normal_force",
    "displacement": "displacement",
    "tangential_force_x": "tangential_force",
    "tangential_force_y": "tangential_force",
    "tangential_magnitude": "tangential_force",
    "torque_z": "torque_z",
    "contact_radius": "contact_radius",
    "temperature": "temperature",
}


def price(plan: Plan) -> list[str]:
    """Return what the owner of the hand must know before it grips, a sentence each."""
    return [*price_of_sensors(plan), *_commands(plan)]


def price_of_sensors(plan: Plan, besides: Collection[str] = ()) -> list[str]:
    """Return what a plan costs; ``besides`` are channels that another device measures of its fingers."""
    said = [f"{finger.name}: {text}" for finger in plan.fingers for text in _finger(plan, finger, besides)]
    return [*said, *_unknown(plan), *_messages(plan), *_rate(plan)]


def price_of_drive(plan: Plan) -> list[str]:
    return [*_unknown(plan), *_commands(plan)]


def _unknown(plan: Plan) -> list[str]:
    said = [f"{name} is not known, and left out: {how}" for name, how in plan.hand.open.items()]
    return said + [f"in no public source: {text}" for text in plan.hand.product.get("check", ())]


def settings(plan: Plan) -> dict[str, Any]:
    """Return the parameters of the grip controller that follow from the map; the user's go before them."""
    found: dict[str, Any] = {}
    noise = _noise(plan.hand)
    if noise:
        found["noise"] = noise
    asked = _waits(plan) | {"stuck_travel": round(STUCK_STEPS * _force_step(plan) / SOFT_TIP, 6)}
    watchdog = {name: value for name, value in asked.items() if value > getattr(WATCHDOG, name)}
    rate = plan.hand.rate
    if rate and SILENT_AFTER_STATES / rate > WATCHDOG.time_out:
        watchdog["time_out"] = round(SILENT_AFTER_STATES / rate, 4)
    if watchdog:
        found["watchdog"] = watchdog
    found |= {name: dict(table) for name in OF_THE_GRIP if (table := getattr(plan.hand, name))}
    known = largest_force(plan)
    if known is not None:
        found["limits"] = {"max_force": known.force, **plan.hand.limits}
    return found


def _waits(plan: Plan) -> dict[str, float]:
    names = {"frozen_after": MECHANICAL, "force_frozen_after": ("normal_force",)}
    return {
        name: max(_longest_run(plan, finger, channels) for finger in plan.fingers)
        for name, channels in names.items()
    }


def _force_step(plan: Plan) -> float:
    """Return the coarsest step in which a finger's normal force comes [N]; 0 where none is known."""
    steps = [
        abs(slot.scale)
        for finger in plan.fingers
        if (channel := finger.channels.get("normal_force")) is not None and not channel.table
        for slot in (plan.slots[number] for number in channel.slots)
        if slot.place is not None and not slot.place.is_float
    ]
    return max(steps, default=0.0)


def _longest_run(plan: Plan, finger: FingerPlan, channels: Sequence[str]) -> float:
    """Return for how long a live sensor may repeat itself [s]; 0 where its steps are not known.

    With steps ``q`` and noise ``s`` in front of them a value in the middle of a step repeats itself with
    the chance ``p = erf(q / (2 sqrt(2) s))``, and n times in a row with the chance ``p^n``: what is rarer
    than the ``frozen_chance`` of the watchdog is no chance. A measured noise holds that of the steps, so
    ``s^2 = noise^2 - q^2 / 12`` (Sheppard). Where the steps hide the noise, p = 1 and standing still proves
    nothing; nor does it where the value of a slow message stands from one state to the next.
    """
    rate = plan.hand.rate or SILENT_AFTER_STATES / WATCHDOG.time_out
    is_slow = finger.max_age * rate > HELD_STATES
    if finger.rotation and "normal_force" in channels:
        channels = tuple(dict.fromkeys((*channels, *VECTORS[0])))
    measured = {name: one for name in channels if (one := finger.channels.get(name)) and one.slots}
    repeated = 0.0  # ln p
    for name, channel in measured.items():
        slots = [plan.slots[number] for number in channel.slots]
        if any(slot.place is None or slot.place.is_float for slot in slots) or channel.table:
            return 0.0
        if is_slow and any(slot.message != finger.trigger for slot in slots):
            continue
        step = min(abs(slot.scale) for slot in slots)
        live = math.sqrt(max(_noise_of(plan.hand, finger.name, name) ** 2 - step**2 / 12.0, 0.0))
        p = math.erf(step / (math.sqrt(8.0) * live)) if live else 1.0
        repeated += math.log(p) if p else -math.inf
    run = math.log(WATCHDOG.frozen_chance) / repeated if repeated else math.inf
    return round(min(run / rate, LONGEST_WAIT), 3) if measured else 0.0


def _noise_of(hand: HandMap, finger: str, channel: str) -> float:
    mapped = hand.fingers[finger]
    source = mapped.channels.get(channel) or mapped.taxels
    return (source.noise if source is not None else 0.0) or USUAL_NOISE[NOISE_CHANNELS[channel]]


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


def _finger(plan: Plan, finger: FingerPlan, besides: Collection[str]) -> list[str]:
    if finger.is_drive:
        dies = plan.hand.product.get("dies", "is not known: find out, and write it into the map")
        return ["it is a drive and feels nothing", f"when this computer dies, it {dies}"]
    channels = {*finger.measured, *besides}
    said = lacking(channels, STATE_IT)
    sources = plan.hand.fingers[finger.name].channels
    said += [
        f"{name} is stated as {sources[name].stated}, not measured: the margin is that for this value and "
        "no other"
        for name, channel in finger.channels.items()
        if channel.stated
    ]
    force = sources.get("normal_force")
    if force is not None and force.gain and not force.noise:
        said.append(
            "normal_force is made from another quantity and has no 'noise': state its standard "
            "deviation, or it is believed like a force sensor"
        )
    if _longest_run(plan, finger, ("normal_force",)) == LONGEST_WAIT:
        said.append(
            "the steps of normal_force hide its noise, so it stands still at rest: one that is stuck looks "
            "the same, so no grip is lowered while it stands"
        )
    return said


def _messages(plan: Plan) -> list[str]:
    if plan.hand.format:
        return [UNPROTECTED]
    asked = [name for name in plan.messages if plan.database.messages[name].asked]
    specs = {name: plan.hand.messages.get(name, MessageMap()) for name in plan.messages}
    bare = [name for name, spec in specs.items() if not spec.counter]
    open_ = [name for name, spec in specs.items() if spec.checksum.kind == "none"]
    said = []
    if asked:
        said.append(
            f"{_list(asked)}: values are asked for one after the other, one each "
            f"{1e3 * plan.hand.command.poll:g} ms and node, so they are not of the same moment"
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
    if all(finger.is_drive for finger in plan.fingers):
        return []
    if not rate:
        return [UNKNOWN_RATE]
    if rate >= MIN_SLIP_RATE_HZ:
        return []
    late = 1e3 / rate
    found = [
        f"states come at {rate:g} Hz: a slip is seen up to {late:.0f} ms later than it begins; keep a larger "
        "margin (grip.wanted_margin)"
    ]
    if SILENT_AFTER_STATES / rate > WATCHDOG.time_out:
        found.append(
            f"the hand counts as silent after {1e3 * SILENT_AFTER_STATES / rate:.0f} ms instead of 50 ms"
        )
    return found


def _commands(plan: Plan) -> list[str]:
    mute = [finger.name for finger in plan.fingers if plan.hand.fingers[finger.name].command is None]
    said = []
    if mute:
        said.append(f"{_list(mute)}: no command is mapped: margins are published, no finger is commanded")
    if len(mute) == len(plan.fingers):
        return said
    sending = plan.hand.command
    ending = {
        "holds": "it holds when they stop, as the map says",
        "opens": "it OPENS when they stop: should this computer fail, the grip is lost",
        "unknown": "what it does when they stop is not known; find out, and write command.silence",
    }[sending.silence]
    said.append(
        "their commands have no lifetime: the last one is repeated every "
        f"{1e3 * sending.period:.0f} ms; {ending}"
    )
    said.append(describe_limit(plan))
    said += [text for finger in plan.fingers if (text := _kind(plan, finger.name))]
    if plan.hand.format:
        return said
    encoder = FrameCommands(plan, lambda _: (math.nan, math.nan), Counter())
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
    flaw = {
        "increment": "one that is lost is missing from the grip until the measured force says so",
        "position": f"the force is right only as far as the stiffness {command.stiffness} is, and follows "
        "the measured force",
        "current": "friction in the drive is not seen, and the force is right only as far as the gain "
        f"{command.gain} is",
    }[command.kind]
    return f"{finger}: commands are {command.kind}s: {flaw}"


def _list(names: list[str]) -> str:
    return ", ".join(names) if len(names) <= 4 else f"{', '.join(names[:3])} and {len(names) - 3} more"
