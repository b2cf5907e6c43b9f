"""Write an object dictionary as an EDS file (CiA 306).

    python -m tools.write_eds proto/

The writer of the package ``canopen`` leaves out comments and limits, and stamps the file with the time.
"""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from tools.object_dictionary import (
    UNSIGNED8,
    UNSIGNED32,
    Device,
    Entry,
    Object,
    Pdo,
    Record,
    Variable,
    fingertip,
    grasp_force,
    known_parameters,
)

DATE = "11-20-2026"  # of the layout; a file is written anew only when it changes
VAR, ARRAY, RECORD = 0x7, 0x8, 0x9
BIT_RATES_KBIT = (10, 20, 50, 125, 250, 500, 800, 1000)  # [kbit/s]
SUPPORTED = (125, 250, 500, 1000)


def text(device: Device) -> str:
    """Return the EDS file of ``device``."""
    objects = sorted((*device.objects, *pdo_objects(device.pdos)), key=lambda found: found.index)
    mandatory = [o for o in objects if o.index in (0x1000, 0x1001, 0x1018)]
    manufacturer = [o for o in objects if 0x2000 <= o.index < 0x6000]
    optional = [o for o in objects if o not in mandatory and o not in manufacturer]
    lines = [*_head(device), *_comments(device)]
    for title, found in (("Mandatory", mandatory), ("Optional", optional), ("Manufacturer", manufacturer)):
        lines += _section(f"{title}Objects", _listed(found))
        for one in found:
            lines += _object(one)
    return "\n".join(lines)


def pdo_objects(pdos: Iterable[Pdo]) -> Iterator[Record]:
    """Yield the communication and mapping records of ``pdos``."""
    for pdo in pdos:
        kind, base = ("TPDO", 0x1800) if pdo.is_transmitted else ("RPDO", 0x1400)
        parameters = (
            Entry("COB-ID", UNSIGNED32, "ro", pdo.cob_id),
            Entry("Transmission type", UNSIGNED8, "rw", f"{pdo.transmission_type:#x}"),
        )
        yield Record(base + pdo.number, f"{kind} communication parameter {pdo.number + 1}", parameters)
        mapped = tuple(
            Entry(f"Mapped object {n}", UNSIGNED32, "ro", f"0x{index:04X}{sub:02X}{bits:02X}")
            for n, (index, sub, bits) in enumerate(pdo.mapped, 1)
        )
        yield Record(base + 0x200 + pdo.number, f"{kind} mapping parameter {pdo.number + 1}", mapped)


def _head(device: Device) -> Iterator[str]:
    info = {
        "FileName": device.file,
        "FileVersion": "1",
        "FileRevision": "0",
        "EDSVersion": "4.0",
        "Description": device.description,
        "CreationTime": "12:00PM",
        "CreationDate": DATE,
        "CreatedBy": "tools.write_eds",
        "ModificationTime": "12:00PM",
        "ModificationDate": DATE,
        "ModifiedBy": "tools.write_eds",
    }
    about = {
        "VendorName": "vegrip",
        "VendorNumber": "0x0",
        "ProductName": device.product,
        "ProductNumber": f"{device.product_number:#x}",
        "RevisionNumber": "0x10000",
        "OrderCode": "0",
        **{f"BaudRate_{rate}": str(int(rate in SUPPORTED)) for rate in BIT_RATES_KBIT},
        "SimpleBootUpMaster": "0",
        "SimpleBootUpSlave": "1",
        "Granularity": "0",
        "DynamicChannelsSupported": "0",
        "GroupMessaging": "0",
        "NrOfRXPDO": str(sum(not pdo.is_transmitted for pdo in device.pdos)),
        "NrOfTXPDO": str(sum(pdo.is_transmitted for pdo in device.pdos)),
        "LSS_Supported": "0",
    }
    yield from _section("FileInfo", info)
    yield from _section("DeviceInfo", about)
    yield from _section("DummyUsage", {f"Dummy000{n}": "0" for n in range(1, 8)})


def _comments(device: Device) -> Iterator[str]:
    lines = [*device.comments, *_notes(device.objects)]
    numbered = {f"Line{n}": line for n, line in enumerate(lines, 1)}
    yield from _section("Comments", {"Lines": str(len(lines)), **numbered})


def _notes(objects: Iterable[Object]) -> Iterator[str]:
    for one in objects:
        entries = (one.entry,) if isinstance(one, Variable) else one.entries
        for sub, entry in enumerate(entries, 1):
            where = f"{one.index:04X}" if isinstance(one, Variable) else f"{one.index:04X}sub{sub:X}"
            if entry.note:
                yield f"{where} {entry.name}: {entry.note}".replace("=", ":")  # a value ends at no second =


def _listed(objects: list[Object]) -> dict[str, str]:
    numbered = {str(n): f"0x{one.index:04X}" for n, one in enumerate(objects, 1)}
    return {"SupportedObjects": str(len(objects)), **numbered}


def _object(one: Object) -> Iterator[str]:
    if isinstance(one, Variable):
        yield from _section(f"{one.index:04X}", _entry(one.entry))
        return
    count = len(one.entries)
    head = {"ParameterName": one.name, "ObjectType": f"{ARRAY if one.is_array else RECORD:#x}"}
    yield from _section(f"{one.index:04X}", {**head, "SubNumber": f"{count + 1:#x}"})
    number = Entry("Highest sub-index supported", UNSIGNED8, "const", f"{count:#x}")
    for sub, entry in enumerate((number, *one.entries)):
        yield from _section(f"{one.index:04X}sub{sub:X}", _entry(entry))


def _entry(entry: Entry) -> dict[str, str]:
    return {
        "ParameterName": entry.name,
        "ObjectType": f"{VAR:#x}",
        "DataType": f"0x{entry.data_type:04X}",
        "AccessType": entry.access,
        **({"DefaultValue": entry.default} if entry.default else {}),
        "PDOMapping": str(int(entry.is_mappable)),
    }


def _section(title: str, keys: dict[str, str]) -> Iterator[str]:
    yield f"[{title}]"
    yield from (f"{key}={value}" for key, value in keys.items())
    yield ""


def main() -> None:
    """Write both files into the folder named on the command line."""
    if len(sys.argv) != 2:
        sys.exit("usage: python -m tools.write_eds FOLDER (the project's own is proto)")
    folder = Path(sys.argv[1])
    if not folder.is_dir():
        sys.exit(f"write_eds: {folder} is no folder")
    before = folder / "grasp_force.eds"
    known = known_parameters(before.read_text(encoding="ascii")) if before.exists() else {}
    for device in (fingertip(), grasp_force(known)):
        (folder / device.file).write_text(text(device), encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
