"""ROS 2 without an installation of ROS: its types on its topics over DDS, by Cyclone DDS.

In: ``/hand/FINGER/wrench`` (WrenchStamped, compression positive along z) and ``/joint_states`` (JointState,
whose position of the name FINGER is the displacement [m]), which go to a node as FingertipState. Out:
``/hand/FINGER/wrench_command``, ``/diagnostics`` and every other topic of the nodes as ``vegrip_msgs``.
Reliable, volatile, the last 100; on the loopback interface and without multicast unless stated otherwise.
What no program reads is neither asked of a node nor written.
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from socket import if_nameindex
from typing import Any, Final

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import DDSException, Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from vegrip.bridges import ros2_types as ros2
from vegrip.bridges.node_topics import READ_PERIOD, NodeTopics
from vegrip.clock import NS
from vegrip.errors import DeviceError
from vegrip.messages import FingertipState, Message

DEPTH: Final = 100  # messages kept for a reader that is slow, then the oldest give way
BLOCKED_MS: Final = 10  # [ms] that a write waits for such a reader at most
LOOK_PERIOD_S: Final = 1.0  # [s] between two looks at which topics and other programs there are
COMMANDED_PERIOD_S: Final = 0.001  # [s] of one look at the telemetry: by so much what comes in may be late
MAX_AGE: Final = NS // 10  # [ns] of a displacement; an older one is missing, as of hands with a map
MOST_AT_ONCE: Final = 256  # messages taken from one topic in a turn
CONFIG: Final = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface {interface}/></Interfaces>
<AllowMulticast>{multicast}</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>64</MaxAutoParticipantIndex>{peers}</Discovery></Domain></CycloneDDS>"""
KINDS: Final[Mapping[str, Any]] = {
    "float64": idl.float64, "int32": idl.int32, "uint32": idl.uint32, "uint8": idl.uint8, "byte": idl.byte,
    "string": str,
}  # fmt: skip


@cache
def idl_type(name: str) -> Any:
    """Return the class of a ROS 2 type, from its lines in ``.msg``; its name on the wire is that of ROS 2."""
    fields: dict[str, Any] = {}
    for line in ros2.PARTS[name].splitlines():
        kind, member = line.partition("#")[0].split()
        if "=" in member:
            continue
        plain = kind.removesuffix("[]")
        one = KINDS[plain] if plain in KINDS else idl_type(plain.replace("/", "/msg/"))
        sequence: Any = idl.sequence
        fields[member] = sequence[one] if kind.endswith("[]") else one
    package, _, short = name.rpartition("/")
    return make_idl_struct(f"{short}_", f"{package.replace('/', '.')}.dds_.{short}_", fields)


@dataclass
class Link:
    """A participant of a domain: its readers and writers, and what is wrong with those of others.

    Raises:
        DeviceError: the interface is not there, or the domain has no free port.

    """

    domain: int = 0
    interface: str = "lo"  # "" = whatever Cyclone DDS chooses
    multicast: bool = False
    complain: Callable[[str], object] = print
    left_out: int = 0
    """Messages that were not taken: of a second publisher, or not valid."""
    _reported: set[str] = field(default_factory=set)
    _writers: dict[str, Any] = field(default_factory=dict)
    _readers: dict[str, Any] = field(default_factory=dict)
    _received: dict[str, int] = field(default_factory=dict)  # the publisher that is received, by topic

    def __post_init__(self) -> None:
        there = [name for _, name in if_nameindex()]
        if self.interface.isalnum() and self.interface not in there:  # else it is an address
            where = f"domain {self.domain}: there is no interface {self.interface}"
            raise DeviceError(f"{where}; give one with --interface: {', '.join(there)}")
        named = f'name="{self.interface}"' if self.interface else 'autodetermine="true"'
        peers = "" if self.multicast else '<Peers><Peer address="127.0.0.1"/></Peers>'
        allowed = "true" if self.multicast else "false"
        try:
            self._domain = Domain(self.domain, CONFIG.format(interface=named, multicast=allowed, peers=peers))
            self._participant = DomainParticipant(self.domain)
        except DDSException as error:
            where = f"domain {self.domain} cannot be joined on {self.interface or 'any interface'}"
            raise DeviceError(f"{where} ({error.msg}); give another with --domain or --interface") from None
        history = Policy.History.KeepLast(DEPTH)
        reliable = Policy.Reliability.Reliable(duration(milliseconds=BLOCKED_MS))
        self._qos = Qos(reliable, history, Policy.Durability.Volatile, Policy.IgnoreLocal.Participant)
        self._others = [
            BuiltinDataReader(self._participant, kind)
            for kind in (BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription)
        ]

    def close(self) -> None:
        """Leave the domain."""
        self._readers.clear()
        self._writers.clear()
        self._others.clear()
        del self._participant, self._domain

    def is_read(self, topic: str, name: str) -> bool:
        """Offer ``topic`` of the type ``name``; return whether another program reads it."""
        if topic not in self._writers:
            kind = self._topic(topic, idl_type(name))
            self._writers[topic] = DataWriter(self._participant, kind, self._qos)
        return bool(self._writers[topic].get_matched_subscriptions())

    def write(self, topic: str, data: bytes) -> None:
        """Publish the bytes of a message on a topic that was offered."""
        writer = self._writers[topic]
        sample = object.__new__(writer.topic.data_type)
        sample.serialize = lambda **_: data  # which the writer asks it for
        try:
            writer.write(sample)
        except DDSException:  # a reader that is slow has blocked it
            self.left_out += 1

    def read(self, topic: str, kind: Any) -> list[Any]:
        """Return what came on ``topic`` since the last call, of the publisher that was received first."""
        if topic not in self._readers:
            self._readers[topic] = DataReader(self._participant, self._topic(topic, kind), self._qos)
        taken = []
        for sample in self._readers[topic].take(MOST_AT_ONCE):
            info = sample.sample_info
            if not info.valid_data:
                if info.publication_handle == self._received.get(topic):
                    del self._received[topic]  # it has gone
            elif self._received.setdefault(topic, info.publication_handle) == info.publication_handle:
                taken.append(sample)
            else:
                self.left_out += 1
                self._report(f"two publishers send {topic}; the first is received, stop one of them")
        return taken

    def look(self) -> None:
        """Say once what does not fit: another type, another version of it, a QoS that does not match."""
        mine = [self._readers, self._writers]
        for publishes, (reader, ends) in enumerate(zip(self._others, mine, strict=True)):
            for other in reader.read(MOST_AT_ONCE):
                topic = str(other.topic_name).removeprefix("rt")
                if other.sample_info.valid_data and topic in ends and other.key != ends[topic].guid:
                    self._compare(topic, other, ends[topic].topic.data_type, publishes=not publishes)

    def _compare(self, topic: str, other: Any, kind: Any, *, publishes: bool) -> None:
        does = "publishes" if publishes else "subscribes to"
        name = kind.__idl_typename__.replace(".", "::")
        if other.type_name != name:
            self._report(f"another program {does} {topic} as {other.type_name}; here it is {name}")
        elif other.type_id is not None and other.type_id != kind.__idl__.get_type_id():
            self._report(f"another program {does} {topic} with another version of {name}; build it anew")
        elif publishes and Policy.Reliability.BestEffort in other.qos:
            self._report(f"{topic} is published best effort and not received: publish it reliable")

    def _report(self, sentence: str) -> None:
        if sentence not in self._reported:
            self._reported.add(sentence)
            self.complain(sentence)

    def _topic(self, topic: str, kind: Any) -> Any:
        return Topic(self._participant, f"rt{topic}", kind, self._qos)


class Outgoing:
    """Messages of nodes to DDS, those that other programs read."""

    def __init__(self, link: Link) -> None:
        self._link, self._start = link, time.monotonic_ns()
        self._since_1970 = time.time_ns() - self._start

    def wanted(self, topics: Mapping[str, type[Message]]) -> list[str]:
        """Offer ``topics``, and return those that are read."""
        return [topic for topic, kind in topics.items() if self._ends(topic, kind)]

    def send(self, topic: str, message: Message) -> None:
        if ends := self._ends(topic, kind := type(message)):
            row, stamp = ros2.row_of(message, self._start), max(message.stamp + self._since_1970, 0)
            for end, name in ends:
                self._link.write(end, ros2.message_of(name, topic, kind, row, stamp))

    def _ends(self, topic: str, kind: type[Message]) -> list[tuple[str, str]]:
        ends = ros2.ends_of(topic, kind).items()
        ours = (end for end in ends if (kind, end[1]) != (FingertipState, ros2.WRENCH))  # which comes in
        return [(end, name) for end, name in ours if self._link.is_read(end, name)]


class Incoming:
    """Wrenches and joint positions of others, as states of the fingers."""

    def __init__(self, link: Link, fingers: tuple[str, ...], namespace: str = "") -> None:
        self._link, self._fingers, self._namespace = link, fingers, namespace
        self._seq = dict.fromkeys(fingers, 0)
        self._displacement = dict.fromkeys(fingers, (math.nan, 0))  # and when it came [ns]

    def read(self, now: int) -> list[FingertipState]:
        """Return the states that came; they are stamped ``now`` [ns], for clocks of others are theirs."""
        for sample in self._link.read(f"{self._namespace}/joint_states", idl_type(ros2.JOINTS)):
            for name, position in zip(sample.name, sample.position, strict=False):
                if name in self._displacement:
                    self._displacement[name] = position, now
        states = []
        for finger in self._fingers:
            position, received = self._displacement[finger]
            displacement = position if now - received <= MAX_AGE else math.nan
            for sample in self._link.read(f"{self._namespace}/hand/{finger}/wrench", idl_type(ros2.WRENCH)):
                force, torque = sample.wrench.force, sample.wrench.torque
                self._seq[finger] += 1
                states.append(FingertipState(
                    now, finger, self._seq[finger], normal_force=force.z, tangential_force_x=force.x,
                    tangential_force_y=force.y, torque_z=torque.z, displacement=displacement,
                ))  # fmt: skip
        return states


def relay(
    link: Link,
    source: NodeTopics,
    incoming: Incoming | None = None,
    send: Callable[[Message], object] | None = None,
    is_over: Callable[[], bool] = bool,
) -> None:
    """Pass on until ``is_over``: what nodes say to ``link``, and what comes in to ``send``."""
    outgoing, topics, look_due = Outgoing(link), list[str](), 0.0
    period = READ_PERIOD if incoming is None else COMMANDED_PERIOD_S
    while not is_over():
        if time.monotonic() >= look_due:
            topics, look_due = outgoing.wanted(source.look()), time.monotonic() + LOOK_PERIOD_S
            link.look()
            if not topics:
                source.rest()
        for topic, message in source.read(topics, period):
            outgoing.send(topic, message)
        if incoming is not None and send is not None:
            for state in incoming.read(time.monotonic_ns()):
                send(state)
