"""The pages of the Python reference: one for each package that a program imports."""

import importlib
from collections.abc import Iterator
from types import ModuleType

PACKAGES = {
    # package: what it is for
    "vegrip": "The front door",
    "vegrip.estimator": "Estimator",
    "vegrip.model": "Contact model",
    "vegrip.effects": "Effects",
    "vegrip.identification.recording": "Recordings",
    "vegrip.identification.simulate": "Simulate",
    "vegrip.identification.fit": "Fit",
    "vegrip.identification.compare": "Compare",
    "vegrip.identification.diagnosis": "Diagnose",
    "vegrip.identification.changed": "What changed",
    "vegrip.identification.experiment": "Experiment",
    "vegrip.runtime": "Nodes",
    "vegrip.transport": "Transports",
    "vegrip.virtual": "Virtual hand",
}


def pages() -> Iterator[tuple[str, str]]:
    """Yield (file name, Markdown) for each package: its docstring and what it exports, each object once."""
    shown: set[str] = set()
    for package in sorted(PACKAGES, key=lambda name: name == "vegrip"):  # the front door points to the others
        module = importlib.import_module(package)
        names = [name for name in getattr(module, "__all__", ()) if not name.startswith("_")]
        homes = {name: _home(module, name) for name in names}
        text = [f"# {PACKAGES[package]}: `{package}`", "", f"::: {package}"]
        text += ["    options:", "      show_root_heading: false", "      members: false", ""]
        text += [f"* [`{name}`][{home}]" for name, home in homes.items() if home in shown]
        text += [f"\n::: {home}" for home in homes.values() if home not in shown]
        shown |= set(homes.values())
        file = package.removeprefix("vegrip.identification.").removeprefix("vegrip.")
        yield f"{file}.md", "\n".join(text) + "\n"


def _home(module: ModuleType, name: str) -> str:
    """Return where an exported object is defined; a package may import it only when it is used."""
    found = getattr(module, name)
    package = getattr(found, "__module__", "")
    is_ours = package.startswith("vegrip.") and hasattr(found, "__qualname__")
    return f"{package}.{found.__qualname__}" if is_ours else f"{module.__name__}.{name}"
