"""What to do about the troubles that NodeStatus only counts by name; said once, when they begin."""

from collections.abc import Iterator, Mapping
from typing import Final

from vegrip.clock import NS

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
    "crowded": "more senders than there are places for have been heard, and those silent for longest were "
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


class FaultHints:
    """Finds what is new in the counts of a node."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[int, int]] = {}  # name: (count, [ns] when it last rose)

    def news(self, rejected: Mapping[str, int], now: int) -> Iterator[tuple[str, str]]:
        """Yield name and remedy of each trouble that has begun, or has begun again after ``QUIET_NS``."""
        for name, sentence in HINTS.items():
            count = rejected.get(name, 0)
            before, when = self._last.get(name, (0, -QUIET_NS))
            if count > before:
                self._last[name] = (count, now)
                if now - when >= QUIET_NS:
                    yield name, sentence
