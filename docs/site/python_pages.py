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
    "vegrip.identification.experiment": "Experiment",
    "vegrip.runtime": "Nodes",
    "vegrip.transport": "Transports",
    "vegrip.virtual": "Virtual hand",
}


def pages() -> Iterator[tuple[str, str]]:
    """Yield (file name, Markdown) for each package: its docstring and what it exports."""
    for package, title in PACKAGES.items():
        module = importlib.import_module(package)
        names = [name for name in getattr(module, "__all__", ()) if not name.startswith("_")]
        text = [
            f"# {title}: `{package}`",
            "",
            f"::: {package}",
            "    options:",
            "      show_root_heading: false",
            "      members: false",
        ]
        text += [f"\n::: {_home(module, name)}" for name in names]
        yield (
            f"{package.removeprefix('vegrip.') or 'vegrip'}.md".replace("identification.", ""),
            "\n".join(text) + "\n",
        )


def _home(module: ModuleType, name: str) -> str:
    """Return where an exported object is defined; a package may import it only when it is used."""
    found = getattr(module, name)
    package = getattr(found, "__module__", "")
    is_ours = package.startswith("vegrip.") and hasattr(found, "__qualname__")
    return f"{package}.{found.__qualname__}" if is_ours else f"{module.__name__}.{name}"
