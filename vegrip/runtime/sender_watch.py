"""Finds two hands that speak as one: their states come in turn, and their counters may fit into each other.

Of the values ``x_i`` of one channel compare, over the last states,

    S_1 = mean of (x_i - x_{i-1})^2     and     S_2 = mean of (x_i - x_{i-2})^2 .

For a value that moves slowly ``S_1 < S_2``, for noise alone they are equal. Two streams in turn that differ
by ``D``, each with noise of standard deviation ``sigma``, have ``S_1 / S_2 = 1 + D^2 / (2 sigma^2)``: every
other value is near, the next one is not. A vibration at half the rate of the states looks the same, so this
only reports.
"""

import logging
import math
from collections.abc import Iterator, Mapping
from typing import Final

from vegrip.clock import NS
from vegrip.messages import FingertipState
from vegrip.transport.endpoint import ADVICE, PART_BACK, PART_GONE

QUIET_NS: Final = 60 * NS
"""[ns] without the trouble after which it is news again."""

HINTS: Final[Mapping[str, str]] = {
    "also_sent": "another node on this bus also sends what only this one may send; stop one of the two, or "
    "give them different hands (hand, namespace or channel)",
    "reports_lowered": "this machine cannot keep up, so margins, estimates and health are reported only 5 "
    "times a second for each finger; every command is sent. Close other programs, and see `vegrip doctor`",
    "no_traffic": "nothing of the map (transport.map) has come since the bus was opened; look at channel and "
    "bit rate, whether the hand is switched on, and with `vegrip connect` whether this is its database",
    "command_held": "no new command came, so the last one is repeated to a hand that cannot hold by itself; "
    "activate the node, or end it to stop sending",
    "bus_lost": "the bus was lost: its process has died, or its interface is gone; it is opened again as "
    "soon as it is there, and until then the fingers hold and go to their fail-safe grip",
    "bus_off": "bus-off: the CAN controller has cut itself off after too many errors; give all nodes of the "
    "bus the same bit rates (transport.bitrate, transport.data_bitrate), then look at wiring and termination",
    "connections": "too many programs are connected to a socket of this node, and the next one must wait; "
    "look for one that connects again and again, and never closes",
    "cut_off": "a publisher sent something that is not a message of vegrip (not ZeroMQ, or above 64 KiB); "
    "the connection was opened anew; look what runs at the addresses in transport.subscribe",
    "parts": "messages come that are not topic and payload, and are refused; look what else publishes at the "
    "addresses in transport.subscribe",
    "two_senders": "the states of a finger alternate between two values: two hands send under one "
    "name, give them different ones (hand, namespace or channel); or it vibrates at half the rate of states",
    "checksum": "what comes has a wrong checksum and is refused; the link is disturbed, or the sender has "
    "another layout, finger or namespace than it says",
    "counter": "messages come twice, or with numbers that run backwards or jump, and are refused; look for a "
    "second sender of the same name, or for a link that repeats and reorders",
    "version": "messages of another version of the message set come and are refused; update the older side",
    "layout": "frames of the other layout come and are refused; give both ends the same transport.fd",
    "length": "frames of another length come and are refused; give both ends the same layout and version",
    "finger": "messages of a finger that is not configured come and are refused; name it in `fingers`, in "
    "the same order at both ends",
    **{
        name: f"messages come {what} and are refused; look at the sender, proto/messages.toml has the format"
        for name, what in (
            ("schema", "that are not complete maps of msgpack"),
            ("type", "with a field of another type"),
            ("value", "with an invalid value"),
            ("size", "that are too long or too short"),
        )
    },
    "crowded": "more senders than there are places for have been received, and those silent for longest were "
    "forgotten; a program on this network invents names",
    "request": "a program sent something to the control socket that is not a request; use `vegrip param`, "
    "`lifecycle` or `topic` of this version",
    "subscription": "a program sent something to the telemetry socket that is not a subscription; use "
    "`vegrip topic` or `monitor`, or a ZeroMQ socket of kind SUB",
    "fd_refused": "CAN FD frames come, but this node is set to classic CAN; set transport.fd = true",
    "key_refused": "a publisher refuses us because it does not know our key; put our public key there "
    "with `vegrip keys trust`, and start it again",
    "key_wrong": "a publisher cannot prove to have the key in curve.publisher; put its present public key "
    "(.key) there, and start this node again",
    "key_unknown": "a subscriber whose key is not in curve.peers was refused; to allow it, "
    "`vegrip keys trust THEIR.key`, and start this node again",
    "key_stale": "a subscriber that does not have our public key, or has no key, was refused; "
    "give it the .key file that belongs to curve.own",
}


NO_HINTS: Final[Mapping[str, str]] = {}


class FaultHints:
    """Finds what is new in the counts of a node."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[int, int]] = {}  # name: (count, [ns] when it last rose)

    def news(
        self, rejected: Mapping[str, int], now: int, own: Mapping[str, str] = NO_HINTS
    ) -> Iterator[tuple[str, str]]:
        """Yield name and remedy of each trouble that has begun, or has begun again after ``QUIET_NS``.

        A part that has come back may go again at once, and the other way round: both are always news.
        ``own`` has the sentences of counts that only this endpoint has.
        """
        for name, sentence in {**HINTS, **own}.items():
            count = rejected.get(name, 0)
            before, when = self._last.get(name, (0, -QUIET_NS))
            if count > before:
                self._last[name] = (count, now)
                if now - when >= QUIET_NS:
                    yield name, sentence
                    if other := _opposite(name):
                        self._last[other] = self._last.get(other, (0, 0))[0], -QUIET_NS


def level_of(name: str) -> int:
    """Return at which level of the log the count ``name`` is told."""
    return (
        logging.INFO if name.startswith(PART_BACK) else logging.WARNING if name in ADVICE else logging.ERROR
    )


def _opposite(name: str) -> str:
    """Return what undoes ``name``, "" where nothing does."""
    for one, other in ((PART_GONE, PART_BACK), (PART_BACK, PART_GONE)):
        if name.startswith(one):
            return other + name.removeprefix(one)
    return ""


WINDOW_STATES: Final = 64  # states
TWO_SENDERS_RATIO: Final = (
    6.0  # of S_1 to S_2; noise alone comes to 1, streams three standard deviations apart to 5.5
)
IN_A_ROW: Final = 16  # states for which the ratio holds; coarse values alternate by chance, but not for long
TURN_STATES: Final = 512  # of all fingers until another one is looked at: a hundred of each of five
MOST_FINGERS: Final = 256  # are watched; a sender of made-up names must not make the table grow


class _Channel:
    __slots__ = ("_above", "_before", "_last", "_one", "_two")

    def __init__(self) -> None:
        self._last = self._before = math.nan
        self._one = self._two = 0.0  # S_1, S_2, forgetting
        self._above = 0  # states in a row with too large a ratio

    def note(self, value: float) -> bool:
        one, two = value - self._last, value - self._before
        self._before, self._last = self._last, value
        if two != two:  # noqa: PLR0124 (NaN: the first two)
            return False
        self._one += (one * one - self._one) / WINDOW_STATES
        self._two += (two * two - self._two) / WINDOW_STATES
        self._above = self._above + 1 if self._one > TWO_SENDERS_RATIO * self._two else 0
        return self._above >= IN_A_ROW


class _Finger:
    __slots__ = ("_count", "_displacement", "_force")

    def __init__(self) -> None:
        self._count = 0
        self._force, self._displacement = _Channel(), _Channel()

    def note(self, force: float, displacement: float) -> bool:
        self._count += 1
        alternates = force - force == 0.0 and self._force.note(force)
        alternates |= displacement - displacement == 0.0 and self._displacement.note(displacement)
        return alternates and self._count > WINDOW_STATES


class SenderWatch:
    """Counts the states in which a finger seems to be two."""

    def __init__(self) -> None:
        self.count = 0
        self._fingers: dict[str, _Finger] = {}
        self._turn, self._passed = "", TURN_STATES

    def has_turn(self, name: str) -> bool:
        """Return whether the next state of the finger ``name`` is to be looked at.

        For one who cannot afford to look at all: one finger after the other has its turn.
        """
        self._passed += 1
        if self._passed > TURN_STATES and name != self._turn:
            self._turn, self._passed = name, 0
        return name == self._turn

    def note(self, state: FingertipState) -> None:
        self.note_values(state.finger, state.normal_force, state.displacement)

    def note_values(self, name: str, force: float, displacement: float) -> None:
        """Take in normal force [N] and displacement [m] of the next state of the finger ``name``."""
        finger = self._fingers.get(name)
        if finger is None:
            if len(self._fingers) >= MOST_FINGERS:
                return
            finger = self._fingers[name] = _Finger()
        self.count += finger.note(force, displacement)
