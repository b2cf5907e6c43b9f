"""The list of parts has every pin once, and says which of them vegrip asks for."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tools.sbom import read_pins, sbom

ROOT = Path(__file__).parents[2]
PROJECT = {
    "name": "vegrip",
    "version": "1.0",
    "description": "grips",
    "license": "Apache-2.0",
    "dependencies": ["Some_Thing>=2"],
    "optional-dependencies": {"web": ["some.thing>=2", "other[x]>=1"]},
}


@pytest.fixture(scope="module")
def written() -> dict[str, Any]:
    run = subprocess.run([sys.executable, "-m", "tools.sbom"], cwd=ROOT, check=True, capture_output=True)
    told: dict[str, Any] = json.loads(run.stdout)
    return told


def test_every_pin_is_a_part_once(written: dict[str, Any]) -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").split()
    parts = [f"{one['name']}=={one['version']}" for one in written["components"]]
    assert sorted(parts) == sorted(re.sub(r"[-_.]+(?=.*==)", "-", line).lower() for line in lines)


def test_references_are_unique_and_lead_to_parts(written: dict[str, Any]) -> None:
    known = [one["bom-ref"] for one in (*written["components"], written["metadata"]["component"])]
    assert len(set(known)) == len(known)
    (own,) = written["dependencies"]
    assert own["ref"] == written["metadata"]["component"]["bom-ref"]
    assert set(own["dependsOn"]) <= set(known)
    assert "pkg:pypi/numpy@" in " ".join(own["dependsOn"])


def test_it_is_of_the_kind_and_version_that_it_says(written: dict[str, Any]) -> None:
    assert (written["bomFormat"], written["specVersion"], written["version"]) == ("CycloneDX", "1.5", 1)
    assert written["metadata"]["component"]["licenses"] == [{"license": {"id": "Apache-2.0"}}]
    assert all(re.fullmatch(r"pkg:pypi/[a-z0-9-]+@\S+", one["purl"]) for one in written["components"])


def test_a_part_says_what_asks_for_it_however_its_name_is_spelt() -> None:
    parts = sbom(PROJECT, read_pins("some-thing==2.1\nOther==1.0  # why\n\nthird==3\n"))["components"]
    asked = {one["name"]: [why["value"] for why in one.get("properties", ())] for one in parts}
    assert asked == {"some-thing": ["run", "web"], "other": ["web"], "third": []}


def test_what_is_asked_for_and_not_pinned_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="does not pin other, some-thing"):
        sbom(PROJECT, {"third": "3"})


@pytest.mark.parametrize("line", ["numpy>=2", "numpy", "-e .", "a b==1"])
def test_a_line_that_is_no_pin_is_refused(line: str) -> None:
    with pytest.raises(ValueError, match="is no pin"):
        read_pins(line)
