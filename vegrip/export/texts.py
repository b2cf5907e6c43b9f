"""The files of an export, as texts: the templates with a model's names and numbers put in."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources
from string import Template

import numpy as np
from numpy.typing import NDArray

from vegrip.c99 import LONG, Program, literals, translate
from vegrip.c99.kinds import RealType
from vegrip.estimator.compiled import text_of
from vegrip.estimator.estimator import quantile
from vegrip.estimator.initial_state import initial_memory
from vegrip.estimator.kernels_c import ENTRIES
from vegrip.estimator.layout import FRICTION, REPORT, Layout, layout_of
from vegrip.estimator.memory import LEAST_SLIP_SPEED, SLIPS
from vegrip.estimator.origins import Origins
from vegrip.estimator.saved_numbers import CORRELATED, SavedNumbers, Span
from vegrip.export import frameworks
from vegrip.export.precision import PRECISIONS
from vegrip.export.request import MARGIN, Request
from vegrip.export.saved import HEAD, NUMBER_DIGITS, TAIL, packed, text_number
from vegrip.export.vectors import ESTIMATES, FLAGS, OUTPUTS, Vectors
from vegrip.model import ContactModel
from vegrip.model.file import model_text

BESIDE = 48
"""Bytes of a finger beside the numbers of its memory, in double precision; 40 in single."""
ONE_LINE = 6  # numbers
TIMES = {"elapsed_time": (LONG, LONG), "bounded_time": (LONG,)}
"""Kernels that the part written by hand calls, too."""
NAMES = {
    "indentation": ("DEPTH_NOW", "DEPTH_STD"), "normal_force": ("FORCE", "FORCE_STD"),
    "contact_radius": ("RADIUS", "RADIUS_STD"), "pressure_exponent": ("EXPONENT", "EXPONENT_STD"),
    "friction_coefficient": ("MU", "MU_STD"), "limit_force": ("LIMIT_FORCE", "LIMIT_FORCE_STD"),
    "limit_torque": ("LIMIT_TORQUE", "LIMIT_TORQUE_STD"),
    "limit_radius": ("LIMIT_RADIUS", "LIMIT_RADIUS_STD"),
}  # fmt: skip
ONLY_TOUCHING = ("pressure_exponent", "limit_radius")
FILES = {
    "estimator.h": "{p}_estimator.h", "estimator.c": "{p}_estimator.c", "vectors.h": "{p}_vectors.h",
    "vectors.c": "{p}_vectors.c", "selftest.c": "{p}_selftest.c", "Makefile": "Makefile",
    "counting.h": "{p}_counting.h", "worst.c": "{p}_worst.c",
    "CMakeLists.txt": "CMakeLists.txt", "bare_metal.c": "examples/bare_metal.c",
    "linux.c": "examples/linux.c",
    "startup.c": "{core}/startup.c", "link.ld": "{core}/link.ld", **frameworks.ESTIMATOR,
}  # fmt: skip


@dataclass(frozen=True)
class Texts:
    """Path in the folder -> text, and what is told of them."""

    files: dict[str, str]
    program: Program
    text_hash: str
    ram: int  # [bytes] of a finger


def write(request: Request, vectors: Vectors) -> Texts:
    """Return the files.

    Raises:
        UntranslatableError: a line of an effect or kernel has no counterpart in C.

    """
    model, p, precision = request.model, request.prefix, PRECISIONS[request.precision]
    layout = layout_of(model)
    text = text_of(model, layout, ellipse=request.settings.surface == "ellipse")
    origins = Origins(model.effects)
    entries = {name: ENTRIES[name] for name in ("update", "margin_of", "least_force")} | TIMES
    program = translate(
        text,
        entries,
        prefix=f"{p}_k",
        place=origins.place,
        notes=origins.notes(),
        is_public=False,
        reals=precision.reals,
    )
    digest = hashlib.sha256(text.encode()).hexdigest()
    known = {
        "p": p, "P": p.upper(), "entry": "estimator", "hash": digest[:NUMBER_DIGITS],
        "effects": ", ".join(e.name for e in model.effects),
        **_settings(request, precision.reals), **_memory(request, layout, precision.reals),
        **_vectors(vectors),
        "kernels": program.text(),
        "worst_sources": f"{p}_worst.c {p}_vectors.c {p}_estimator.c",
        **precision.known, **frameworks.words("estimator"),
    }  # fmt: skip
    known |= saving_words(known, text_number(digest), model, layout, precision.reals)
    files = {}
    for template, name in FILES.items():
        files[name.format(p=p, entry="estimator", core=known["core"])] = filled(template, known)
    files |= frameworks.arduino_sources(p, "estimator", files)
    files["model.toml"] = model_text(model)
    files["examples/finger.txt"] = saved_text(text_number(digest), model, layout, vectors.memory)
    return Texts(files, program, digest, _ram(request, layout))


def filled(template: str, known: dict[str, str]) -> str:
    """Return the text of a template with its words put in."""
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
    """Return what is saved of a memory, one number a line."""
    numbers = packed(mark, memory[SavedNumbers(model, layout).places])
    return "".join(f"{literals.hexadecimal(one)}\n" for one in numbers.tolist())


def _ram(request: Request, layout: Layout) -> int:
    """Return the bytes of a finger; two of its numbers lie beside the memory."""
    number = PRECISIONS[request.precision].number_bytes
    return number * layout.size + BESIDE - 2 * (8 - number)


def _settings(request: Request, reals: RealType) -> dict[str, str]:
    settings = request.settings
    return {
        "longest_gap": literals.real(settings.longest_gap),
        "gap_ns": str(round(settings.longest_gap * 1e9) + 1),
        "recovery": str(settings.recovery),
        "horizon": f"{settings.horizon:g}",
        "risk": f"{1.0 - settings.confidence:.3g}",
        "quantile": literals.real(quantile(settings.confidence), reals),
        "margin": literals.real(MARGIN),
        "slips": literals.real(SLIPS),
        "least_slip_speed": literals.real(LEAST_SLIP_SPEED),
        "temperature": f"{request.model.reference_temperature:g}",
    }


def _memory(request: Request, layout: Layout, reals: RealType) -> dict[str, str]:
    model, p, places = request.model, request.prefix, layout.places()
    start = {name: str(place[0]) for name, place in places.items()}
    report = {name: str(places["REPORT"][0] + i) for i, name in enumerate(REPORT)}
    variances, stds, lines = [], [], []
    for place, (symbol, (effect, declared)) in enumerate(model.parameters.items()):
        value = model.values[symbol]
        variances.append(str(_variance_of(layout, place)))
        stds.append(literals.real(0.0 if np.isnan(value.std) else value.std, reals))
        learned = "learned" if place in layout.learned or place == layout.mu else "as told"
        doc = f"{effect}: {declared.doc}".replace("*/", "* /")
        lines.append(f"    {p.upper()}_PARAMETER_{symbol}, /* [{declared.unit}] {doc}; {learned} */")
    memory = initial_memory(model, layout, request.noise, request.settings)
    return {
        "size": str(layout.size),
        "bytes": str(_ram(request, layout)),
        "parameters": "\n".join(lines),
        "variance_of": ", ".join(variances),
        "std_of": ", ".join(stds),
        "blank": _numbers(literals.real(one, reals) for one in memory.tolist()),
        "EXOGENOUS": start["EXOGENOUS"],
        "CHANNEL": start["CHANNEL"],
        "VALUES": start["VALUES"],
        **{f"REP_{name}": place for name, place in report.items()},
        "accessors": "\n".join(_accessor(p, name, report) for name in ESTIMATES),
    }


def _variance_of(layout: Layout, place: int) -> int:
    """Return where the variance of a parameter lies in the memory, or -1."""
    if place == layout.mu:
        return layout.places()["FRICTION"][0] + FRICTION.index("VAR")
    if place in layout.learned:
        j = layout.learned_from + layout.learned.index(place)
        return layout.places()["P"][0] + j * layout.n + j
    return -1


def _accessor(p: str, name: str, report: dict[str, str]) -> str:
    value, std = NAMES[name]
    known = f"{p}_in_contact(e)" if name in ONLY_TOUCHING else "true"
    reported = f"{p}_reported(e, {report[value]}, {report[std]}, {known})"
    body = [f"    return {reported};"]
    if name == "indentation":  # is told in the air, too, however wide
        body = [
            f"    {p}_estimate found = {reported};",
            f"    found.valid = e->trusted && {p}_is_sound(e);",
            "    return found;",
        ]
    return "\n".join([f"{p}_estimate {p}_{name}(const {p}_estimator *e)", "{", *body, "}", ""])


def _vectors(vectors: Vectors) -> dict[str, str]:
    rows = []
    for frame in vectors.frames:
        inputs = ", ".join(literals.hexadecimal(one) for one in frame.inputs)
        outputs = ", ".join(literals.hexadecimal(one) for one in frame.outputs)
        rows.append(f"    {{{frame.stamp}LL, {{{inputs}}},\n     {{{outputs}}}, {frame.flags}U}},")
    return {
        "frames": str(len(vectors.frames)),
        "outputs": str(len(OUTPUTS)),
        "output_names": ", ".join(OUTPUTS),
        "flag_names": ", ".join(FLAGS),
        "rows": "\n".join(rows),
        "memory": _numbers(map(literals.hexadecimal, vectors.memory.tolist())),
    }


def _numbers(words: Iterable[str]) -> str:
    return "\n".join(f"    {', '.join(line)}," for line in _lines(words))


def _lines(words: Iterable[str]) -> list[list[str]]:
    all_words = list(words)
    return [all_words[i : i + ONE_LINE] for i in range(0, len(all_words), ONE_LINE)]
