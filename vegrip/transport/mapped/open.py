"""From the path of a map to a plan: the database is read by the kind of file that it is."""

from importlib.util import find_spec
from pathlib import Path

from vegrip.errors import ConfigError
from vegrip.transport.mapped.database import Database, read_dbc
from vegrip.transport.mapped.packets import packet_database
from vegrip.transport.mapped.plan import Plan, make_plan
from vegrip.transport.mapped.schema import HandMap, read_map


def read_database(hand: HandMap) -> Database:
    """Read the database of ``hand``; a network has none.

    Raises:
        ConfigError: no such file, or none that can be read.

    """
    if hand.packets:
        return packet_database(hand.packets, str(hand.path), hand.device.offset)
    if hand.database is None:
        return Database("", {})
    if hand.format:
        return _descriptors(hand.database)
    if hand.database.suffix.lower() == ".eds":
        from vegrip.transport.mapped.canopen_nodes import read_eds  # noqa: PLC0415 (a CANopen hand only)

        return read_eds(hand.database, hand.nodes)
    if hand.nodes:
        raise ConfigError(f"{hand.path}: 'nodes' belongs to an .eds, not to {hand.database.name}")
    return read_dbc(hand.database)


def _descriptors(path: Path) -> Database:
    if find_spec("google") is None or find_spec("google.protobuf") is None:
        raise ConfigError(f"{path}: protobuf needs its library; pip install 'vegrip[protobuf]'")
    try:
        return Database(path.name, {}, descriptors=path.read_bytes())
    except OSError as error:
        raise ConfigError(
            f"{path}: cannot be read ({error.strerror}); 'database' is relative to the map"
        ) from None


def open_plan(path: Path | str, fingers: tuple[str, ...] | None = None) -> Plan:
    """Return the plan of the map at ``path``, for ``fingers`` or all that it has.

    Raises:
        ConfigError: the map or its database cannot be used; says why and what to do.

    """
    hand = read_map(path)
    return make_plan(hand, read_database(hand), tuple(hand.fingers) if fingers is None else fingers)
