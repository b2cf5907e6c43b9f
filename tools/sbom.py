"""Write the list of parts (SBOM) as CycloneDX 1.5 JSON: ``python -m tools.sbom > build/vegrip.cdx.json``.

Parts are all pins of ``constraints.txt``, for running and for developing alike; those that ``pyproject.toml``
asks for by name stand as dependencies of vegrip. No time and no number by chance are in it, so the same two
files give the same bytes.
"""

import json
import re
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def sbom(project: dict[str, Any], pins: dict[str, str]) -> dict[str, Any]:
    """Return the SBOM of ``[project]`` of ``pyproject.toml`` with ``pins``, version by canonical name.

    Raises:
        ValueError: the project asks for what is not pinned.

    """
    own = _part(canonical(project["name"]), project["version"])
    own |= {"type": "application", "description": project["description"]}
    own["licenses"] = [{"license": {"id": project["license"]}}]
    asked: dict[str, set[str]] = {name: {"run"} for name in _names(project["dependencies"])}
    for extra, lines in project["optional-dependencies"].items():
        for name in _names(lines):
            asked.setdefault(name, set()).add(extra)
    if missing := sorted(set(asked) - set(pins)):
        raise ValueError(f"constraints.txt does not pin {', '.join(missing)}")
    parts = {name: _part(name, version) for name, version in sorted(pins.items())}
    for name, why in asked.items():
        parts[name]["properties"] = [{"name": "vegrip:asked-for-by", "value": one} for one in sorted(why)]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": own},
        "components": list(parts.values()),
        "dependencies": [
            {"ref": own["bom-ref"], "dependsOn": [parts[name]["bom-ref"] for name in sorted(asked)]}
        ],
    }


def read_pins(text: str) -> dict[str, str]:
    """Return version by canonical name of ``name==version`` lines.

    Raises:
        ValueError: a line is no pin.

    """
    pins = {}
    for line in filter(None, (line.partition("#")[0].strip() for line in text.splitlines())):
        name, is_pin, version = line.partition("==")
        if not is_pin or not NAME.fullmatch(name.strip()):
            raise ValueError(f"constraints.txt: {line!r} is no pin, write name==version")
        pins[canonical(name.strip())] = version.strip()
    return pins


def canonical(name: str) -> str:
    """Return a name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _names(lines: list[str]) -> list[str]:
    return [canonical(found[0]) for line in lines if (found := NAME.match(line))]


def _part(name: str, version: str) -> dict[str, Any]:
    purl = f"pkg:pypi/{name}@{version}"
    return {"type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl}


def main() -> int:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    try:
        told = sbom(project, read_pins((ROOT / "constraints.txt").read_text(encoding="utf-8")))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 1
    print(json.dumps(told, indent=2))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
