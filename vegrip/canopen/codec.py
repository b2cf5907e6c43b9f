"""The classic codec on a CANopen bus: the same bytes under other identifiers; services get the rest."""

from collections import Counter
from collections.abc import Callable, Mapping

from vegrip.messages import Message, make_row
from vegrip.transport.codec import CanCodec, Frame

Service = Callable[[Frame], None]
Gate = Callable[[int], bool]
Keep = Callable[[Message, list[Frame]], None]


class CanopenCodec:
    """What :class:`~vegrip.transport.can_endpoint.CanEndpoint` needs of a codec.

    Args:
        codec: classic layout.
        identifiers: COB-ID -> identifier of the classic frame.
        service: takes every frame that is no PDO of ours.
        hears: whether the PDO with this COB-ID may be taken now.
        speaks: whether it may be sent now.
        keep: takes what is to be sent, for those who read it by SDO.
        without_pdo: kinds of messages that are read by SDO only.

    """

    def __init__(
        self,
        codec: CanCodec,
        identifiers: Mapping[int, int],
        service: Service,
        hears: Gate,
        speaks: Gate,
        keep: Keep = lambda message, frames: None,  # noqa: ARG005
        without_pdo: tuple[type, ...] = (),
    ) -> None:
        self._codec = codec
        self.clipped = codec.clipped
        self._identifier = dict(identifiers)
        self._cob_id = {identifier: cob_id for cob_id, identifier in identifiers.items()}
        self._service, self._hears, self._speaks, self._keep = service, hears, speaks, keep
        self._without_pdo = without_pdo

    @property
    def rejected(self) -> Counter[str]:
        return self._codec.rejected

    @property
    def broken(self) -> Mapping[str, int]:
        return self._codec.broken

    @property
    def lost(self) -> int:
        return self._codec.lost

    def decode(self, frame: Frame) -> Message | None:
        """Return the message that a PDO completes; hand any other frame to the services."""
        cob_id = frame.arbitration_id
        identifier = self._identifier.get(cob_id)
        if identifier is None:
            self._service(frame)
            return None
        return self._codec.decode(frame, identifier) if self._hears(cob_id) else None

    def encode(self, message: Message) -> list[Frame]:
        """Return the PDOs of ``message`` that may be sent; messages without a PDO have none."""
        frames = [] if isinstance(message, self._without_pdo) else self._codec.encode(message)
        self._keep(message, frames)
        sent: list[Frame] = []
        for identifier, *rest in frames:
            cob_id = self._cob_id.get(identifier)
            if cob_id is not None and self._speaks(cob_id):
                sent.append(make_row(Frame, (cob_id, *rest)))
        return sent
