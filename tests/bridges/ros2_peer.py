"""A peer on Cyclone DDS alone, which knows the types of ROS 2 and nothing of vegrip.

Usage: python ros2_peer.py DOMAIN HOW [COUNT]; HOW: echo, publish, other_type, best_effort, version, joints
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

CONFIG = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>64</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""
PATIENCE = 60.0  # [s] on a busy machine
BURST = 20


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Wrench(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    force: Vector3
    torque: Vector3


@dataclass
class WrenchStamped(IdlStruct, typename="geometry_msgs::msg::dds_::WrenchStamped_"):
    header: Header
    wrench: Wrench


@dataclass
class Other(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    force: Vector3
    torque: Vector3


@dataclass
class Version(IdlStruct, typename="geometry_msgs::msg::dds_::WrenchStamped_"):
    header: Header
    force: Vector3


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


def main(domain: int, how: str, count: int) -> int:
    keep = Domain(domain, CONFIG)
    participant = DomainParticipant(domain)
    fits = Policy.Reliability.Reliable(duration(seconds=1))
    reliability = Policy.Reliability.BestEffort if how == "best_effort" else fits
    qos = Qos(reliability, Policy.History.KeepLast(100))
    kind = {"other_type": Other, "version": Version}.get(how, WrenchStamped)
    writer = DataWriter(participant, Topic(participant, "rt/hand/thumb/wrench", kind, qos))
    print("ready", flush=True)
    if how in ("other_type", "version", "best_effort"):
        sys.stdin.read()  # until it is told to end
        return 0
    topic = Topic(participant, "rt/hand/thumb/wrench_command", WrenchStamped, qos)
    reader = DataReader(participant, topic)
    joints = DataWriter(participant, Topic(participant, "rt/joint_states", JointState, qos))
    waits = {"echo": (reader.get_matched_publications,), "joints": (joints.get_matched_subscriptions,)}
    end = time.monotonic() + PATIENCE
    while not all(matched() for matched in (writer.get_matched_subscriptions, *waits.get(how, ()))):
        if time.monotonic() > end:
            return 1
        time.sleep(0.01)
    answers = []
    if how == "joints":
        joints.write(JointState(Header(Time(1, 0), ""), ["wrist", "thumb"], [9.0, 1e-3], [], []))
        joints.wait_for_acks(duration(seconds=PATIENCE))
        print("there", flush=True)
        sys.stdin.readline()  # until it was read
    for n in range(count):
        vector = Vector3(0.0, 0.0, float(n))
        writer.write(WrenchStamped(Header(Time(n, 5), "thumb"), Wrench(vector, Vector3(0.0, 0.0, 0.0))))
        while how == "echo" and n % BURST == BURST - 1 and len(answers) <= n and time.monotonic() < end:
            answers += [one.wrench.force.z for one in reader.take(100)]
    print(len(answers), answers == sorted(set(answers)), flush=True)
    sys.stdin.read()
    del keep
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0))
