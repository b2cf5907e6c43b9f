"""Read an EDS file, and see whether it describes the device that is meant."""

import configparser
from importlib.resources import as_file, files
from pathlib import Path

import canopen
from canopen.objectdictionary import ObjectDictionary, ODVariable

from vegrip.errors import ConfigError


def read_eds(name: str, node: int, like: str) -> ObjectDictionary:
    """Return the object dictionary in the EDS file ``name`` for the node-ID ``node``.

    Args:
        name: a path; empty for the file ``like``.
        node: node-ID.
        like: the file of ``proto/`` that it must agree with: same product, same mapping of every PDO.

    Raises:
        ConfigError: no such file, not an EDS file, or of another device.

    """
    shipped = _shipped(like, node)
    if not name:
        return shipped
    found = _import(Path(name), node)
    difference = difference_of(found, shipped)
    if difference:
        raise ConfigError(f"{name} does not describe this device: {difference}; use {like} of vegrip.proto")
    return found


def difference_of(found: ObjectDictionary, expected: ObjectDictionary) -> str:
    """Return the first difference in identity and PDOs, "" if there is none."""
    for index, sub in essentials(expected):
        try:
            value = _entry(found, index, sub).default
        except KeyError:
            return f"object {index:04X}sub{sub} is missing"
        wanted = _entry(expected, index, sub).default
        if value != wanted:
            return f"object {index:04X}sub{sub} is {_hex(value)}, not {_hex(wanted)}"
    return ""


def essentials(dictionary: ObjectDictionary) -> list[tuple[int, int]]:
    """Return index and sub-index of what makes the device: type, product, revision, PDO mappings."""
    mappings = [index for index in dictionary if 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00]
    mapped = [(index, sub) for index in mappings for sub in dictionary[index].subindices]
    return [(0x1000, 0), (0x1018, 2), (0x1018, 3), *mapped]


def wanted_value(dictionary: ObjectDictionary, index: int, sub: int) -> int:
    return int(_entry(dictionary, index, sub).default or 0)


def _entry(dictionary: ObjectDictionary, index: int, sub: int) -> ODVariable:
    found = dictionary[index]
    return found if isinstance(found, ODVariable) else found[sub]


def _shipped(name: str, node: int) -> ObjectDictionary:
    with as_file(files("vegrip.proto").joinpath(name)) as path:
        return _import(path, node)


def _import(path: Path, node: int) -> ObjectDictionary:
    if path.suffix.lower() not in (".eds", ".dcf"):
        raise ConfigError(f"{path} is no EDS file; its name must end in .eds or .dcf")
    try:
        return canopen.import_od(str(path), node)
    except OSError as error:
        raise ConfigError(f"{path} cannot be read ({error.strerror})") from None
    except (configparser.Error, ValueError, KeyError, AttributeError) as error:
        reason = str(error).strip().splitlines()[0] if str(error) else type(error).__name__
        raise ConfigError(f"{path} is not a valid EDS file: {reason}") from None


def _hex(value: object) -> str:
    return hex(value) if isinstance(value, int) else str(value)
