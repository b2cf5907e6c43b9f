"""The export as an Arduino library and as a Zephyr module, beside its own Makefile and CMakeLists.txt."""

from collections.abc import Mapping
from importlib.metadata import version

SHARED = {
    "arduino_library.properties": "arduino/{p}_{entry}/library.properties",
    "zephyr_module.yml": "zephyr/module.yml",
    "zephyr_CMakeLists.txt": "zephyr/CMakeLists.txt",
    "zephyr_Kconfig": "zephyr/Kconfig",
    "zephyr_sample_CMakeLists.txt": "zephyr/sample/CMakeLists.txt",
}
OWN = {
    "arduino.ino": "arduino/{p}_{entry}/examples/grip/grip.ino",
    "zephyr_prj.conf": "zephyr/sample/prj.conf",
    "zephyr_sample.yaml": "zephyr/sample/sample.yaml",
    "zephyr_main.c": "zephyr/sample/src/main.c",
}
"""Template -> path in the folder."""
TITLES = {"estimator": "Estimator of a soft fingertip's contact", "finger": "Grip of soft fingertips"}
SENTENCES = {
    "estimator": "Contact, friction, slip margin and least force of a soft fingertip from what it measures.",
    "finger": "The grip of soft fingertips: CAN FD frames of states in, frames of commands out.",
}


def words(entry: str) -> dict[str, str]:
    """Return what these templates know by name."""
    return {
        "ENTRY": entry.upper(),
        "title": TITLES[entry],
        "sentence": SENTENCES[entry],
        "version": version("vegrip"),
    }


def arduino_sources(p: str, entry: str, files: Mapping[str, str]) -> dict[str, str]:
    """Return copies of header and source where Arduino looks: a library must be whole by itself."""
    return {f"arduino/{p}_{entry}/src/{p}_{entry}.{kind}": files[f"{p}_{entry}.{kind}"] for kind in "hc"}
