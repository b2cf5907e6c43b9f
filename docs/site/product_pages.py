"""A page for each product whose map is in the box, written from the map itself."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from vegrip.connect.writer import checked
from vegrip.transport.mapped.plan import FingerPlan, Plan, open_plan
from vegrip.transport.mapped.price import price
from vegrip.transport.maps.products import about, map_of, names, virtual_text
from vegrip.transport.maps.units import SI

REPORT = """## Tried on hardware

{tried}

A report needs:

* the device with its firmware, your name and a date;
* `vegrip lifecycle status` after a minute of grip: what was refused;
* the weight you hung on a tip, and the force that was read;
* which lines of the map you changed.

It goes into `tried_on` of the map.
"""


def pages() -> Iterator[tuple[str, str]]:
    """Yield (file name, Markdown) for the list and for each product."""
    found = [about(name) for name in names()]
    rows = [
        f"| [{one['name']}]({one['hand']}.md) | {one['carrier']} | {', '.join(one['channels'])} | "
        f"{one['commands'] or '-'} | {one['checked_against'] or 'its source alone'} |"
        for one in found
    ]
    head = [
        "# Products",
        "",
        "Whose bytes are public, so that their maps are in the box. None was tried on hardware.",
    ]
    head += ["Yours is not among them: [your sensor is not here](../../tutorials/your-sensor.md).", ""]
    head += ["| product | carrier | channels | commands by | compared with |", "|---|---|---|---|---|"]
    yield "index.md", "\n".join([*head, *rows]) + "\n"
    for one in found:
        yield f"{one['hand']}.md", "\n".join(_page(one)) + "\n"


def _page(one: dict[str, Any]) -> Iterator[str]:
    path, plan = map_of(one["hand"]), _plan(one["hand"])
    hand = plan.hand
    where = "--channel can0" if hand.transport["kind"] == "can" else f"--address {_address(hand.transport)}"
    yield f"# {one['name']}\n"
    yield "```sh"
    if one["channels"]:
        yield f"vegrip demo --as {one['hand']}         # without the device: a virtual one holds an object"
    yield f"vegrip connect --hand {one['hand']} -o hand.toml {where}"
    yield "vegrip launch hand --check\n```\n"
    yield "| | |\n|---|---|"
    yield f"| carrier | {one['carrier']}{_rate(hand.transport)} |"
    if one["channels"]:
        yield f"| states | {hand.rate:g} a second, of {', '.join(one['fingers'])} |"
    else:
        drive = hand.drive
        yield f"| force | {drive.minimum:g} to {drive.maximum:g} N{_steps(drive.resolution)} |"
    yield f"| it is asked | {_counted(hand.device.poll, 'question')} |"
    yield f"| it is told first | {_counted(hand.device.opening, 'entry')} |"
    yield f"| its own zero | {'`vegrip zero`' if hand.device.zero else 'no command'} |"
    yield f"| says of its contact | {', '.join(one['reports']) or 'nothing'} |"
    yield f"| commands | {one['commands'] or 'none is mapped'} |"
    yield f"| layout from | {one['source']} |"
    yield f"| compared with | {one['checked_against'] or 'nothing: from its source alone'} |\n"
    if one["channels"]:
        yield "## What it measures\n"
        yield "| channel | from | one step |\n|---|---|---|"
        yield from _channels(plan, plan.fingers[0])
    yield from _open(hand.product)
    yield "\n## What it does not tell, of one finger\n"
    yield from (f"* {sentence}" for sentence in price(plan))
    yield f"\n{REPORT.format(tried=', '.join(one['tried_on']) or 'Nobody has reported yet.')}"
    yield f"## The map\n\n```toml\n{path.read_text(encoding='utf-8')}```"


def _plan(name: str) -> Plan:
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.toml"
        plan, text = checked(virtual_text(map_of(name), has_drive=False), path, [])
        path.write_text(text, encoding="utf-8")
        return open_plan(path, (plan.fingers[0].name,))


def _address(transport: Any) -> str:
    usual = {"udp": "192.168.1.1:49152", "tcp": "192.168.1.1:502", "serial": "/dev/ttyUSB0"}
    return transport["address"] or usual[transport["kind"]]


def _rate(transport: Any) -> str:
    if transport["kind"] == "serial":
        return f", {transport['baud']} bit/s"
    return f", {1e-6 * transport['bitrate']:g} Mbit/s" if transport["kind"] == "can" else ""


def _counted(entries: Any, what: str) -> str:
    number = len(entries)
    plural = what[:-1] + "ies" if what.endswith("y") else what + "s"
    return "nothing" if not number else f"{number} {what if number == 1 else plural}"


def _channels(plan: Plan, finger: FingerPlan) -> Iterator[str]:
    for name, channel in finger.channels.items():
        slots = [plan.slots[number] for number in channel.slots]
        source = slots[0].message + "." + slots[0].signal
        more = f" and {len(slots) - 1} more" if len(slots) > 1 else ""
        place = slots[0].place
        step = (
            "float"
            if place is not None and place.is_float
            else f"{abs(slots[0].scale):.3g} {SI[name]}".strip()
        )
        unknown = any(f".{name}." in each or ".taxels." in each for each in _to_measure(plan))
        yield f"| {name} | `{source}`{more} | {'to be measured' if unknown else step} |"


def _to_measure(plan: Plan) -> list[str]:
    return [f".{key}" for key in plan.hand.product.get("measure", {})]


def _open(product: Any) -> Iterator[str]:
    measure, check = product.get("measure", {}), product.get("check", ())
    if measure or check:
        yield "\n## To be measured, or looked at once\n"
    yield from (f"* `{key}`: {how}" for key, how in measure.items())
    yield from (f"* {sentence}" for sentence in check)


def _steps(resolution: float) -> str:
    return f" in steps of {resolution:g}" if resolution else ""
