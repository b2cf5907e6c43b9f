"""A proposed map as a file, with a comment on each line that says where it comes from."""

from collections.abc import Mapping
from typing import Any

from vegrip.config import toml_key, toml_value
from vegrip.transport.mapped.drafts import Draft, is_complete
from vegrip.transport.mapped.proposal import Proposal

FRICTION_NOTES = {
    "shared": "learned by all fingers of a grasp together",
    "probing": "less is held until it is known",
    "slip_threshold": "[m/s] the slowest slide of the traffic that was felt",
    "slip_delay": "[s] from the fall of the load to the slip flag",
}
UNITS = {"normal": "[N]", "tangential": "[N]", "torque": "[N m]"}


def map_text(proposal: Proposal, transport: Mapping[str, Any], about: list[str]) -> str:
    """Return the text of the file."""
    lines = [f"# {line}" for line in about] + [""]
    lines.append(_line("database", proposal.database, "beside this file"))
    if proposal.nodes:
        lines.append(_line("nodes", dict(proposal.nodes), "node-ID of each finger"))
    if proposal.rate:
        lines.append(_line("rate", proposal.rate, "[Hz] of states, as they came"))
    if transport:
        lines += ["", "[transport]", *(_line(key, value, "") for key, value in transport.items())]
    for name, draft in proposal.messages.items():
        lines += ["", f"[messages.{toml_key(name)}]", *_table(draft)]
    for name, finger in proposal.fingers.items():
        own = [_line("trigger", finger.trigger, "the last message of a cycle")] if finger.trigger else []
        if finger.max_age:
            own.append(
                _line("max_age", finger.max_age, "[s] after which a value of another message is missing")
            )
        lines += ["", f"[fingers.{toml_key(name)}]", *own]
        for channel, each in finger.channels.items():
            lines += [f"[fingers.{toml_key(name)}.{channel}]", *_table(each)]
        if finger.taxels is not None:
            lines += [f"[fingers.{toml_key(name)}.taxels]", *_table(finger.taxels)]
        if finger.command is not None and is_complete(finger.command):
            lines += [f"[fingers.{toml_key(name)}.command]", *_table(finger.command)]
    if any(finger.command is not None for finger in proposal.fingers.values()):
        lines += ["", "[command]", _line("period", 0.02, "[s] the last command is repeated so often")]
        lines.append(_line("silence", "unknown", "what the hand does when commands stop: holds or opens?"))
    if proposal.friction:
        lines += ["", "[friction]"]
        lines += [_line(key, value, FRICTION_NOTES.get(key, "")) for key, value in proposal.friction.items()]
    if proposal.doubts:
        lines += ["", "# Still open:", *(f"# * {doubt}" for doubt in proposal.doubts)]
    return "\n".join(lines) + "\n"


def _table(draft: Draft) -> list[str]:
    return [
        _line(key, value, draft.notes.get(key, ""))
        for key, value in draft.keys.items()
        if value not in ("", None)
    ]


def _line(key: str, value: Any, note: str) -> str:
    text = f"{toml_key(key)} = {toml_value(value)}"
    return f"{text:<44} # {note}" if note else text


def changed_text(text: str, settings: list[tuple[list[str], Any]]) -> str:
    """Return the text of a map with some keys set; only lines of those tables change."""
    for path, value in settings:
        text = _changed(text, path, value)
    return text


def _changed(text: str, path: list[str], value: Any) -> str:
    *tables, key = path
    lines = text.split("\n")
    header = f"[{'.'.join(toml_key(name) for name in tables)}]" if tables else ""
    line = _line(key, value, "said by --set")
    inline = f"{toml_key(key)} ="
    nested = f"[{'.'.join(toml_key(name) for name in path)}]"
    if nested in lines:  # a table is replaced by what was said of it
        first = lines.index(nested)
        last = next(
            (n for n in range(first + 1, len(lines)) if lines[n].startswith("[") or not lines[n]), len(lines)
        )
        del lines[first:last]
    if header and header not in lines:
        return "\n".join([*lines, header, line, ""])
    first = lines.index(header) + 1 if header else 0
    last = next((n for n in range(first, len(lines)) if lines[n].startswith("[")), len(lines))
    for number in range(first, last):
        if lines[number].startswith(inline):
            lines[number] = line
            return "\n".join(lines)
    if not header:
        first = next((n for n, each in enumerate(lines) if each.startswith("database")), 0)
    lines.insert(first, line)
    return "\n".join(lines)
