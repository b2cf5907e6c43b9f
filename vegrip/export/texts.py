"""The files of an export, as texts: the templates with the names and numbers of a model put in."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.metadata import version
from string import Template
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from vegrip.c99 import LONGS, MEMORY, Program, literals, translate
from vegrip.c99.kinds import RealType
from vegrip.c99.names import local
from vegrip.estimator.compiled import text_of
from vegrip.estimator.layout import NAMED, Layout, layout_of
from vegrip.estimator.memory import SampleLayout
from vegrip.estimator.saved_numbers import CORRELATED, SavedNumbers, Span
from vegrip.export import estimator, finger
from vegrip.export.precision import PRECISIONS, Request
from vegrip.export.saved import HEAD, NUMBER_DIGITS, TAIL, packed, text_number
from vegrip.model import ContactModel
from vegrip.model.file import model_text

SHARED = {  # as an Arduino library and as a Zephyr module
    "arduino_library.properties": "arduino/{p}_{entry}/library.properties",
    "zephyr_module.yml": "zephyr/module.yml",
    "zephyr_CMakeLists.txt": "zephyr/CMakeLists.txt",
    "zephyr_Kconfig": "zephyr/Kconfig",
    "zephyr_sample_CMakeLists.txt": "zephyr/sample/CMakeLists.txt",
}
OWN_OF_FRAMEWORKS = {
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
ONE_LINE = 6  # numbers
NAMES = {
    "indentation": ("DEPTH_NOW", "DEPTH_STD"), "normal_force": ("FORCE", "FORCE_STD"),
    "contact_radius": ("RADIUS", "RADIUS_STD"), "pressure_exponent": ("EXPONENT", "EXPONENT_STD"),
    "friction_coefficient": ("MU", "MU_STD"), "limit_force": ("LIMIT_FORCE", "LIMIT_FORCE_STD"),
    "limit_torque": ("LIMIT_TORQUE", "LIMIT_TORQUE_STD"),
    "limit_radius": ("LIMIT_RADIUS", "LIMIT_RADIUS_STD"),
}  # fmt: skip
ONLY_TOUCHING = ("pressure_exponent", "limit_radius")
ASKED = {"touches": (MEMORY, LONGS), "is_sound": (MEMORY, LONGS)}
"""Kernels that the part written by hand calls, too."""
FILES = {
    "unit.h": "{p}_{entry}.h", "unit.c": "{p}_{entry}.c", "vectors.c": "{p}_vectors.c",
    "Makefile": "Makefile", "counting.h": "{p}_counting.h", "CMakeLists.txt": "CMakeLists.txt",
    "startup.c": "{core}/startup.c", "link.ld": "{core}/link.ld",
}  # fmt: skip
OWN_FILES = {
    "vectors.h": "{p}_vectors.h", "selftest.c": "{p}_selftest.c", "worst.c": "{p}_worst.c",
    "bare_metal.c": "examples/bare_metal.c", "linux.c": "examples/linux.c", **OWN_OF_FRAMEWORKS,
}  # fmt: skip
"""Templates of which each entry has its own; those of the finger begin with ``finger_``."""
PARTS = "/* ---- */\n"
"""Stands in the template of an entry's header between what the header is about, types, and calls."""


@dataclass(frozen=True)
class Texts:
    """Path in the folder -> text, and what is reported about them."""

    files: dict[str, str]
    program: Program
    text_hash: str
    ram: int  # [bytes] of a finger


def write(request: Request) -> Texts:
    """Return the files."""
    model, p, precision = request.model, request.prefix, PRECISIONS[request.precision]
    layout, entry, reals = layout_of(model), request.entry, precision.reals
    unit = (finger if entry == "finger" else estimator).unit(request)
    program = translate(
        unit.text,
        {**unit.entries, **ASKED},
        prefix=f"{p}_k",
        place=unit.origins.place,
        notes=unit.origins.notes(),
        is_public=False,
        reals=reals,
    )
    digest = hashlib.sha256(unit.text.encode()).hexdigest()
    n_bytes = -(-precision.number_bytes * len(unit.blank.f) // 8) * 8 + 8 * len(unit.blank.t) + unit.command
    known = {
        "p": p, "P": p.upper(), "entry": entry, "hash": digest[:NUMBER_DIGITS],
        "effects": ", ".join(effect.name for effect in model.effects), "kernels": program.text(),
        "reals": str(len(unit.blank.f)), "wholes": str(len(unit.blank.t)), "bytes": str(n_bytes),
        "blank_reals": _table(literals.real(one, reals) for one in unit.blank.f.tolist()),
        "blank_wholes": _table(literals.whole(one) for one in unit.blank.t.tolist()),
        "reals_at_end": _table(map(literals.hexadecimal, unit.reals.tolist())),
        "longest_gap": literals.real(request.settings.longest_gap),
        "reals_named": _record(f"{p}_reals", reals.c, _real_sections(unit.blank.layout)),
        "wholes_named": _record(f"{p}_wholes", "int64_t", unit.blank.layout.whole_sections()),
        "accessors": "\n".join(_accessor(p, entry, name) for name in NAMES),
        **precision.known, **framework_words(entry), **unit.words,
    }  # fmt: skip
    ellipse = request.settings.surface == "ellipse"
    mark = text_number(hashlib.sha256(text_of(model, layout, ellipse=ellipse).encode()).hexdigest())
    known |= saving_words(known, mark, model, layout, reals)
    known["chance"] = filled("chance.c", known)
    known["part_c"] = filled(f"{entry}.c", known)
    known["about"], known["types"], known["calls"] = filled(f"{entry}.h", known).split(PARTS)
    own = "finger_" if entry == "finger" else ""
    wanted = FILES | {f"{own}{template}": name for template, name in OWN_FILES.items()} | SHARED
    files = {
        name.format(p=p, entry=entry, core=known["core"]): filled(template, known)
        for template, name in wanted.items()
    }
    files |= arduino_sources(p, entry, files)
    files["examples/finger.txt"] = saved_text(mark, model, layout, unit.reals[: layout.size])
    files["model.toml"] = model_text(model)
    return Texts(files, program, digest, n_bytes)


def filled(template: str, known: dict[str, str]) -> str:
    folder = resources.files("vegrip.export") / "templates"
    return Template((folder / f"{template}.tmpl").read_text("utf-8")).substitute(known)


def saving_words(
    known: dict[str, str], mark: float, model: ContactModel, layout: Layout, reals: RealType
) -> dict[str, str]:
    """Return what the templates say of saved numbers, with the ``known`` words of the other parts."""
    saved = SavedNumbers(model, layout)
    words = {
        "saved": str(HEAD + len(saved.places) + TAIL), "n": str(layout.n),
        "text_number": f"((double){mark:.0f}LL)", "span_count": str(len(saved.spans)),
        "correlated": literals.real(CORRELATED),
        "spans": "\n".join(_span(one, reals) for one in saved.spans),
    }  # fmt: skip
    parts = {name: filled(f"{name}.c", {**known, **words}) for name in ("saving", "damage")}
    return words | parts


def _span(span: Span, reals: RealType) -> str:
    low, high = literals.real(span.low, reals), literals.real(span.high, reals)
    return f"    {{{span.first}, {span.count}, {span.step}, {low}, {high}}},"


def saved_text(mark: float, model: ContactModel, layout: Layout, memory: NDArray[np.float64]) -> str:
    numbers = packed(mark, memory[SavedNumbers(model, layout).places])
    return "".join(f"{literals.hexadecimal(one)}\n" for one in numbers.tolist())


def _accessor(p: str, entry: str, name: str) -> str:
    value, std = (f"e->f.named.report.{one.lower()}" for one in NAMES[name])
    # indentation is known in the air, too, however wide
    known = "true" if name == "indentation" else f"(isfinite({value} + {std}) != 0)"
    known += f" && {p}_in_contact(e)" if name in ONLY_TOUCHING else ""
    body = f"    return {p}_reported(e, {value}, {std}, {known});"
    return "\n".join([f"{p}_estimate {p}_{name}(const {p}_{entry} *e)", "{", body, "}", ""])


def _record(name: str, kind: str, sections: Iterable[tuple[str, tuple[str, ...], int]]) -> str:
    lines = ["typedef struct {"]
    for section, names, length in sections:
        if names:
            numbers = " ".join(f"{kind} {one.lower()};" for one in names)
            text = f"struct {{ {numbers} }} {local(section.lower())};"
            lines += wrap(text, 112, initial_indent="    ", subsequent_indent="        ")
        elif length:
            lines.append(f"    {kind} {local(section.lower())}[{length}];")
    return "\n".join([*lines, f"}} {name};", ""])


def _real_sections(layout: SampleLayout) -> Iterator[tuple[str, tuple[str, ...], int]]:
    _, *rest = layout.real_sections()
    for name, length in layout.filter.sections().items():
        names = NAMED.get(name, ("", ()))[1]
        yield name, names if len(names) == length else (), length
    yield from rest


def _table(words: Iterable[str]) -> str:
    every = list(words)
    lines = [every[i : i + ONE_LINE] for i in range(0, len(every), ONE_LINE)]
    return "\n".join(f"    {', '.join(line)}," for line in lines)


def framework_words(entry: str) -> dict[str, str]:
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
