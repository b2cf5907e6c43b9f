"""All keys of settings files, from the declarations that read them; and who changes each, and why."""

import dataclasses
import math
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from vegrip.canopen.network import CanopenSettings
from vegrip.config import Declaration, declaration, toml_value
from vegrip.estimator.settings import EstimatorSettings, SensorNoise, Sensors
from vegrip.grip.parameters import GraspParameters
from vegrip.identification.experiment.design_space import RigLimits
from vegrip.identification.recording import column_map
from vegrip.runtime.launch_file import PARTS, NodeConfig
from vegrip.transport.hands.device_endpoint import DeviceSettings
from vegrip.transport.hands.link_endpoint import LinkSettings
from vegrip.transport.maps.dialogue import DeviceMap
from vegrip.transport.maps.packets import PacketMap
from vegrip.transport.maps.schema import (
    ChecksumMap,
    CommandMap,
    FingerMap,
    HandKeys,
    MessageMap,
    SendingMap,
    SourceMap,
    TaxelMap,
)
from vegrip.transport.open import CanSettings, ZmqSettings
from vegrip.virtual.settings import HandSettings

FILES: dict[str, dict[str, type]] = {
    # file: table in it -> what reads it
    "Launch file": {
        "[[node]]": NodeConfig,
        '[transport], kind = "can"': CanSettings,
        '[transport], kind = "zmq"': ZmqSettings,
        '[transport], kind = "canopen"': CanopenSettings,
        '[transport], kind = "udp", "tcp" or "serial"': LinkSettings,
        '[transport], kind = "device"': DeviceSettings,
    },
    "Parameters of grasp_force": {"parameters": GraspParameters},
    "Settings of an estimator": {
        "[estimator]": EstimatorSettings,
        "[noise]": SensorNoise,
        "[sensors]": Sensors,
    },
    "Parameters of virtual_hand": {"parameters.hand": HandSettings},
    "Map of a hand of another make": {
        "top level": HandKeys,
        "[fingers.NAME]": FingerMap,
        "[fingers.NAME.CHANNEL]": SourceMap,
        "[fingers.NAME.taxels]": TaxelMap,
        "[fingers.NAME.command]": CommandMap,
        "[command]": SendingMap,
        "[messages.NAME]": MessageMap,
        "checksum": ChecksumMap,
        "[packets.NAME]": PacketMap,
        "[device]": DeviceMap,
    },
    "Column map": {
        "[channels.NAME]": column_map.ChannelMap,
        "[time]": column_map.TimeMap,
        "[episode]": column_map.EpisodeMap,
        "[baseline]": column_map.BaselineMap,
        "[contact]": column_map.ContactMap,
        "[table]": column_map.TableMap,
        "[bag]": column_map.BagMap,
    },
    "Limits of a rig": {"top level": RigLimits},
}


def page() -> str:
    """Return the page as Markdown."""
    lines = ["# Settings files", "", "Every key that a file may have. Without a default it is required.", ""]
    for file, tables in FILES.items():
        lines += [f"## {file}", ""]
        for table, cls in tables.items():
            lines += [f"### {file}: {table}", "", "| key | default | bounds | meaning |", "|---|---|---|---|"]
            lines += [*rows(cls), ""]
    return "\n".join(lines)


def who_page(options: Iterable[tuple[str, str, str, str]]) -> str:
    """Return who changes launch-file keys, parameters of ``grasp_force`` and options, and why.

    Args:
        options: group of commands, command, option and what it is for.

    """
    who = tomllib.loads((Path(__file__).parent / "who_sets.toml").read_text(encoding="utf-8"))
    lines = ["# Who sets what", "", "Each key and option, who changes it, and why.", ""]
    for table, heading in HEADINGS.items():
        lines += [f"## {heading}", "", "| key | who | why |", "|---|---|---|"]
        lines += [f"| `{key}` | {one} | {why} |" for key, (one, why) in who[table].items()]
        lines.append("")
    lines += ["## Options of commands", "", "| command | option | who | why |", "|---|---|---|---|"]
    for group, command, option, why in options:
        reader = "program that reads the answer" if option == "--json" else who["option"][group]
        lines.append(f"| `{command}` | `{option}` | {reader} | {why} |")
    return "\n".join([*lines, ""])


HEADINGS = {
    "launch": "Launch file",
    "transport": "Launch file: transport",
    "grip": "Parameters of grasp_force",
}


def keys(table: str) -> set[str]:
    """Return the keys that files may have, of a table of ``who_sets.toml``."""
    node, *transports = FILES["Launch file"].values()
    classes = {"launch": [node], "transport": transports, "grip": [GraspParameters]}[table]
    found = {row.split("`")[1] for cls in classes for row in rows(cls)}
    return found | set(PARTS) if table == "launch" else found


def rows(cls: type[Any], prefix: str = "") -> Iterator[str]:
    """Yield a row for each key of a declared dataclass, with those of the tables in it."""
    for field in dataclasses.fields(cls):
        default = _default(field)
        if dataclasses.is_dataclass(default) and "constant" not in field.metadata:
            yield from rows(type(default), f"{prefix}{field.name}.")
        elif "parameter" in field.metadata:
            declared = declaration(cls, field.name)
            about = declared.doc + (f" [{declared.unit}]" if declared.unit else "")
            cells = (f"`{prefix}{field.name}`", _shown(default), _bounds(declared), about.replace("|", "\\|"))
            yield f"| {' | '.join(cells)} |"


def _bounds(declared: Declaration) -> str:
    if declared.choices:
        return " or ".join(f"`{one}`" for one in declared.choices if one)
    low, high = declared.low, declared.high
    return "" if math.isinf(low) and math.isinf(high) else f"{low:g} .. {high:g}"


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _shown(default: Any) -> str:
    if default is dataclasses.MISSING:
        return ""
    if default in ("", (), {}, None) or (isinstance(default, float) and math.isnan(default)):
        return "none"
    return f"`{default:g}`" if isinstance(default, float) else f"`{toml_value(default)}`"
