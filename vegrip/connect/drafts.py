"""Tables of a map while it is being made: each key with its reason, and what the user says over guesses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from vegrip.connect.guess import Guess
from vegrip.errors import ConfigError
from vegrip.transport.maps.map_text import Setting
from vegrip.transport.maps.schema import MAPPED_CHANNELS
from vegrip.transport.maps.signals import expanded
from vegrip.transport.maps.units import SI, worth

BY_USER: Final = "said by --set"
EVERY: Final = "*"
"""In the place of a finger's name: all fingers."""

BEGIN: Final = ("signal", "signals", "stated")
"""Keys that make a channel of their own; others belong to one that is there."""


@dataclass(slots=True)
class Draft:
    """The table of one channel, and why it is so."""

    keys: dict[str, Any]
    notes: dict[str, str] = field(default_factory=dict)  # of keys

    @property
    def signal(self) -> str:
        """The signal, "" when there are several."""
        return str(self.keys.get("signal", ""))

    @property
    def names(self) -> tuple[str, ...]:
        several = tuple(str(name) for name in self.keys.get("signals", ()))
        return expanded(several) if several else (self.signal,) if self.signal else ()

    def is_set_by_user(self, key: str) -> bool:
        return self.notes.get(key) == BY_USER

    def set(self, key: str, value: Any, why: str = BY_USER) -> None:
        """Set a key with its reason; a key that the user set is not changed by what the traffic shows."""
        if why == BY_USER or not self.is_set_by_user(key):
            self.keys[key], self.notes[key] = value, why


@dataclass(slots=True)
class FingerDraft:
    """What is proposed of one finger."""

    channels: dict[str, Draft] = field(default_factory=dict)
    taxels: Draft | None = None
    command: Draft | None = None
    trigger: str = ""
    max_age: float = 0.0
    others: list[Guess] = field(default_factory=list)  # forces that no name separates
    alike: Mapping[str, str] = field(default_factory=dict)  # signal of any finger -> its own of that name

    @property
    def signals(self) -> list[str]:
        found = [name for draft in self.channels.values() for name in draft.names]
        return found + (self.taxels.keys["normal"] if self.taxels is not None else [])


def for_each_finger(settings: Sequence[Setting], fingers: Mapping[str, "FingerDraft"]) -> list[Setting]:
    """Return ``settings`` with ``fingers.*`` written out for each finger that has such a table."""
    found: list[Setting] = []
    for path, value in settings:
        if path[:2] != ["fingers", EVERY]:
            found.append((path, value))
            continue
        found += [
            (
                ["fingers", name, *path[2:]],
                finger.alike.get(value, value) if path[3:] == ["signal"] else value,
            )
            for name, finger in fingers.items()
            if len(path) < 4 or path[3] in BEGIN or _has(finger, path[2])
        ]
    return found


def _has(finger: FingerDraft, table: str) -> bool:
    draft = {"command": finger.command, "taxels": finger.taxels}.get(table, finger.channels.get(table))
    return draft is not None


def apply_settings(fingers: dict[str, FingerDraft], settings: Sequence[Setting]) -> None:
    """Set the keys of channels and commands that the user gives in the drafts of ``fingers``, in order."""
    for setting in settings:
        _apply(fingers, for_each_finger([setting], fingers))


def _apply(fingers: dict[str, FingerDraft], settings: Sequence[Setting]) -> None:
    for path, value in settings:
        if len(path) < 3 or path[0] != "fingers" or path[2] not in (*MAPPED_CHANNELS, "command"):
            continue
        _, name, table, *key = path
        if len(key) > 1 or (not key and not isinstance(value, Mapping)):
            continue  # refused when the file is read
        finger = fingers.setdefault(name, FingerDraft())
        before = finger.command if table == "command" else finger.channels.get(table)
        draft = before if before is not None and key else Draft({})
        for each, given in {key[0]: value}.items() if key else value.items():
            if each == "signal" and given != draft.signal:
                if table != "command":
                    _free(finger, str(given), draft)
                draft.keys.clear()  # the unit was that of the other signal
                draft.notes.clear()
            draft.set(each, given)
        if table == "command":
            finger.command = draft
        else:
            finger.channels[table] = draft


def _free(finger: FingerDraft, signal: str, draft: Draft) -> None:
    """Take ``signal`` from the channel that has it; that one gets the signal of ``draft`` for it."""
    finger.others = [one for one in finger.others if one.name != signal]
    owner = next((name for name, one in finger.channels.items() if one.signal == signal), None)
    if owner is None:
        return
    if draft.signal:
        finger.channels[owner] = Draft(dict(draft.keys), {"signal": f"{signal} was said to be another"})
    else:
        del finger.channels[owner]


def factor(channel: str, draft: Draft) -> float:
    """Return what one unit of ``draft`` (after its scale) is in SI, with its sign; 1 where it is unknown."""
    return float(draft.keys.get("sign", 1)) * (1.0 if (one := _worth(channel, draft)) is None else one)


def is_of_unknown_unit(channel: str, draft: Draft) -> bool:
    """Whether the unit of the signal does not show how much of the channel's quantity it is."""
    if any(draft.keys.get(key) for key in ("stated", "table", "raw", "gain")) or "above" in draft.keys:
        return False  # a gain that cannot be is refused with its reason when the map is read
    return _worth(channel, draft) is None


def _worth(channel: str, draft: Draft) -> float | None:
    unit, gain = str(draft.keys.get("unit", "")), str(draft.keys.get("gain", ""))
    try:
        return worth(unit, gain, SI[channel], channel)[0]
    except ConfigError:
        return None


def is_complete(command: Draft) -> bool:
    """Whether everything is known that a command of this kind needs."""
    kind = command.keys.get("kind", "force")
    needed = {"position": ("stiffness", "feedback"), "current": ("gain",)}.get(kind, ())
    return bool(command.signal) and all(command.keys.get(key) for key in needed)
