"""Coverage-guided fuzzing of everything that reads bytes from outside: ``make fuzz``.

The first byte chooses the decoder. Where a checksum stands in the way it is put right first, because a fuzzer
would hardly ever get behind it, and an attacker can compute it. What is sought is any exception, any message
out of bytes without a valid checksum, and anything that takes long.
"""

import sys
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["vegrip", "canopen", "msgpack"]):
    import canopen

    from validation.faults.simulated_bus import SimulatedBus
    from vegrip.canopen.device import Device
    from vegrip.canopen.network import LoopNetwork
    from vegrip.canopen.sensors import SdoReader
    from vegrip.messages import (
        Channel,
        ContactEstimate,
        Estimate,
        FingertipState,
        ForceCommand,
        Lifecycle,
        ModelHealth,
        NodeStatus,
        Reason,
        SlipMargin,
    )
    from vegrip.transport.canbus import carry
    from vegrip.transport.canbus.frame_time import BitTiming
    from vegrip.transport.canbus.hub_wire import unpack_delivery
    from vegrip.transport.codec import CanCodec, Frame, MsgpackCodec
    from vegrip.transport.codec.database import layouts
    from vegrip.transport.codec.protection import P04, P04_HEADER
    from vegrip.transport.codec.schema import Topics, message_set

FINGERS = ("thumb", "index")
PARTS = [part for layout in layouts().layouts for part in layout.parts]
TOPICS = [schema.topic.replace("{finger}", "thumb") for schema in message_set().messages.values()]
DICTIONARY = canopen.import_od("proto/fingertip.eds", 16)


def can_frames(data: bytes) -> None:
    """Several frames of one stream, each with the right checksum."""
    part = PARTS[data[0] % len(PARTS)]
    codec = CanCodec(FINGERS, fd=part.fd)
    for start in range(1, len(data), part.length):
        payload = bytearray(data[start : start + part.length].ljust(part.length, b"\0"))
        part.profile.protect(payload, part.base)
        codec.decode(Frame(part.base, bytes(payload), part.fd, start))


def raw_frame(data: bytes) -> None:
    """A frame as it comes: never a message."""
    identifier = int.from_bytes(data[:2], "little") & 0x7FF
    for fd in (False, True):
        assert CanCodec(FINGERS, fd=fd).decode(Frame(identifier, data[2:], fd, 0)) is None or len(data) > 9


def payload(data: bytes) -> None:
    """A msgpack payload with the right checksum."""
    topic = TOPICS[data[0] % len(TOPICS)]
    route = Topics().incoming(topic)
    assert route is not None
    protected = bytearray(P04_HEADER) + data[1:4000]
    P04.protect(protected, route.data_id)
    MsgpackCodec().decode(topic, bytes(protected), 0)


def hub(data: bytes) -> None:
    """Packets of the virtual bus."""
    unpack_delivery(data)
    model = SimulatedBus(BitTiming(), carry)
    model.attach(1)
    packet = data[: len(model.record.packet)]
    model.record.packet[: len(packet)] = packet
    carry.take_packet(model.record, model.record.order[0], len(packet), 0)


def canopen_services(data: bytes) -> None:
    """Frames for the services of a device, which nothing protects."""
    network = LoopNetwork(lambda *_: None, lambda: 0)
    Device(16, DICTIONARY, network).boot()
    for start in range(0, len(data) - 2, 10):
        can_id = int.from_bytes(data[start : start + 2], "little") & 0x7FF
        network.receive(can_id, data[start + 2 : start + 10], 0)


def sdo_answers(data: bytes) -> None:
    """Answers of a device that is read."""
    reader = SdoReader([(0x1000, 0), (0x1018, 2)], lambda _: None)
    reader.serve(0)
    for start in range(0, len(data), 8):
        reader.answer(data[start : start + 8], 0)


TARGETS = (can_frames, raw_frame, payload, hub, canopen_services, sdo_answers)


def one_input(data: bytes) -> None:
    """Give ``data`` to the decoder that its first byte chooses."""
    if len(data) > 2:
        TARGETS[data[0] % len(TARGETS)](data[1:])


def plant(folder: Path) -> None:
    """Write one good message of each kind into ``folder``: a fuzzer does not guess a version."""
    known = Estimate(0.5, 0.1, True, 0.01)
    messages = (
        FingertipState(0, "thumb", 0, 4.0, 0.5, 0.2, 0.01, 1e-3, 30.0, 0.0, 1e-3, 4e-3),
        ForceCommand(0, "thumb", 0, 2.0, 0.1, Reason.HOLD, 50_000_000),
        SlipMargin(0, "thumb", 0, known, 0.3, 0.95, 1.0, 2.0, 1.0),
        ContactEstimate(0, "thumb", 0, True, Channel.FORCE, known, known, known, known, known),
        ModelHealth(0, "thumb", 0),
        NodeStatus(0, "grasp_force", 0, Lifecycle.ACTIVE),
    )
    for number, message in enumerate(messages):
        for fd in (False, True):
            for frame in CanCodec(FINGERS, fd=fd).encode(message):
                index = [part.base for part in PARTS].index(frame.arbitration_id)
                seed = bytes([TARGETS.index(can_frames), index]) + frame.data
                (folder / f"seed-{number}-{frame.arbitration_id:x}").write_bytes(seed)
        topic, body = MsgpackCodec().encode(message) or ("", b"")
        place = next(i for i, name in enumerate(TOPICS) if name == topic)
        seed = bytes([TARGETS.index(payload), place]) + body[P04_HEADER:]
        (folder / f"seed-{number}").write_bytes(seed)


if __name__ == "__main__":
    plant(Path(sys.argv[-1]))
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
