"""The packets of a map as a database, as that of a CAN bus."""

from collections.abc import Mapping

from vegrip.errors import ConfigError
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.packets import (
    Packet,
    PacketMap,
    Record,
    as_little,
    on_bus,
    signals_of,
    start_pattern,
    template_of,
)
from vegrip.transport.maps.signals import ForeignMessage


def packet_database(maps: Mapping[str, PacketMap], where: str, offset: int = 0) -> Database:
    """Return the messages and signals that ``maps`` declare, with what a stream needs to find them.

    ``offset`` is added to identifiers on CAN.
    """
    messages: dict[str, ForeignMessage] = {}
    packets: dict[str, Packet] = {}
    records: list[tuple[str, int, Record]] = []
    for number, (name, each) in enumerate(maps.items()):
        place = f"{where} [packets.{name}]"
        signals, checked = signals_of(each, place)
        on_can = each.identifier >= 0
        identifier = on_bus(each.identifier + offset) if on_can else number
        least = max((signal.start + signal.length for signal in as_little(signals)), default=0) + 7 >> 3
        if each.of:
            if each.of not in maps or not maps[each.of].index or each.record < 0:
                raise ConfigError(
                    f"{place}: 'of' is {each.of!r}; it must name a packet with an 'index', beside 'record'"
                )
            pattern, reach = start_pattern(each.start, place)
            records.append((each.of, each.record, Record(identifier, pattern, max(least, reach))))
        else:
            packets[name] = Packet(name, identifier, each, signals, checked, least, place)
        length = max(each.length if isinstance(each.length, int) and not each.of else least, least)
        messages[name] = ForeignMessage(
            name,
            identifier,
            length,
            on_can and length > 8,
            signals,
            checked=not on_can,
            template=template_of(each, length, place),
            has_validity=bool(each.valid),
        )
    on_wire = {name: one for name, one in packets.items() if maps[name].identifier < 0}
    if on_wire and len(on_wire) < len(packets):
        raise ConfigError(
            f"{where}: some [packets] have an 'identifier' (CAN) and some none; all must or none"
        )
    for of, kind, record in records:
        packets[of].records[kind] = record
    return Database("the map", messages, packets=tuple(on_wire.values()))
