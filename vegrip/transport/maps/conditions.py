"""What a device says of itself, by name: activated, holding, object lost, too hot. Pure.

::

    [conditions.holding]
    where = { "status.object" = [1, 2] }     # PACKET.FIELD = value or list of values, all of them
    is_fault = false
    [conditions.object_lost]
    where = { "status.object" = 3, "status.echo" = [254, 255] }
    after = "holding"                        # only if that has held since the last time

A condition is judged when the packet comes that it names first. What begins to hold is counted by its name,
unless ``is_fault`` is false.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from typing import Any

from vegrip.config import parameter
from vegrip.errors import ConfigError, suggestion


@dataclass(frozen=True)
class ConditionMap:
    """One of ``[conditions]``."""

    where: dict[str, Any] = parameter(doc="PACKET.FIELD = value, or a list of values; all of them")
    after: str = parameter("", doc="a condition that must have held since this one held last")
    is_fault: bool = parameter(True, doc="counted when it begins to hold")

    def __post_init__(self) -> None:
        if not self.where:
            raise ConfigError("'where' is empty; name a field: where = { \"status.fault\" = 8 }")
        if not all(isinstance(one, int) for values in self.values.values() for one in values):
            raise ConfigError("'where' takes whole numbers, or lists of them")

    @property
    def values(self) -> dict[str, tuple[Any, ...]]:
        """The values that each field may have."""
        return {
            place: tuple(value) if isinstance(value, (list, tuple)) else (value,)
            for place, value in self.where.items()
        }


class Conditions:
    """Which conditions hold, by the last raw values of the fields that they name.

    ``readers`` are, by packet, functions that read the raw value of each field.
    """

    def __init__(
        self,
        maps: Mapping[str, ConditionMap],
        readers: Mapping[str, Mapping[str, Callable[[bytes], int]]],
        counts: Counter[str],
    ) -> None:
        self.now: set[str] = set()
        self._maps, self._readers, self._counts = maps, readers, counts
        self._last: dict[str, int] = {}
        self._wanted = {name: each.values for name, each in maps.items()}
        self._judged_by = {name: next(iter(each.where)).partition(".")[0] for name, each in maps.items()}
        self._held_before: set[str] = set()  # conditions whose ``after`` has held since they held last

    @property
    def faults(self) -> Set[str]:
        """Those of them that are faults."""
        return {name for name in self.now if self._maps[name].is_fault}

    def judges(self, packet: str, name: str) -> bool:
        """Whether the condition ``name`` is judged when ``packet`` comes."""
        return self._judged_by.get(name) == packet

    def take(self, packet: str, data: bytes) -> None:
        """Look at a packet that came."""
        readers = self._readers.get(packet)
        if not readers:
            return
        self._last |= {f"{packet}.{field}": read(data) for field, read in readers.items()}
        for name, wanted in self._wanted.items():
            after = self._maps[name].after
            if after in self.now:
                self._held_before.add(name)
            if self._judged_by[name] != packet:
                continue
            holds = all(self._last.get(place) in values for place, values in wanted.items())
            if not holds:
                self.now.discard(name)
            elif name not in self.now and (not after or name in self._held_before):
                self.now.add(name)
                self._held_before.discard(name)
                if self._maps[name].is_fault:
                    self._counts[name] += 1


def fields_of(
    maps: Mapping[str, ConditionMap], packets: Mapping[str, Any], where: str
) -> dict[str, list[str]]:
    """Return the fields that conditions need, by packet; ``packets`` has the fields of each."""
    found: dict[str, list[str]] = {}
    for name, each in maps.items():
        if each.after and each.after not in maps:
            raise ConfigError(
                f"{where} [conditions.{name}]: 'after' is {each.after!r}; {suggestion(each.after, maps)}"
            )
        for place in each.where:
            packet, _, field = place.partition(".")
            if packet not in packets or field not in packets[packet]:
                known = [f"{one}.{part}" for one, parts in packets.items() for part in parts]
                hint = suggestion(place, known, "there are")
                raise ConfigError(f"{where} [conditions.{name}]: there is no {place!r}; {hint}")
            found.setdefault(packet, []).append(field)
    return found
