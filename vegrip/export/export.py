"""From a model to a folder of C."""

from dataclasses import dataclass
from pathlib import Path

from vegrip.c99.kinds import DOUBLE, FLOAT
from vegrip.export import texts
from vegrip.export.measure import Measured, Run, Size, measure
from vegrip.export.precision import PRECISIONS, Request
from vegrip.export.texts import Texts, filled
from vegrip.whole_file import write_whole

WORDS = {
    "update": "update", "slip_margin": "slip margin", "least_force": "least force", "frame": "frame",
    "tick": "tick",
}  # fmt: skip
SEQUENCE = {
    "estimator": "presses, slips, lost and wrong samples, a late one",
    "finger": "frames of presses, slips, lost and wrong samples, broken frames, silence and ticks",
}
COMPARED = {"estimator": "every output", "finger": "every command"}
RAMP = "The largest difference is that of a fail-safe ramp that begins one command earlier or later.\n\n"


def report(request: Request, texts: Texts, measured: Measured) -> str:
    """Return the page."""
    precision, is_finger = PRECISIONS[request.precision], request.entry == "finger"
    core, run = precision.processor["Core"], measured.cortex_run
    sizes = (("this machine", measured.host), (core, measured.cortex))
    counted = run is not None and run.instructions
    known = {
        **precision.known,
        "name": f"{request.prefix}_{request.entry}", "prefix": request.prefix, "entry": request.entry,
        "effects": ", ".join(effect.name for effect in request.model.effects), "hash": texts.text_hash,
        "kind": precision.words["precision"].lower(), "count": str(len(texts.program.functions)),
        "ram": str(texts.ram),
        "sizes": "".join(_size(name, size) for name, size in sizes if size is not None),
        "sequence": SEQUENCE[request.entry], "compared": COMPARED[request.entry],
        "whole": " and, at the end, the whole memory" if precision.reals == DOUBLE else "",
        "largest": precision.words["finger_difference" if is_finger else "difference"],
        "runs": "".join(_run(one) for one in (measured.host_run, run) if one is not None),
        "ramp": RAMP if is_finger and precision.reals == FLOAT else "",
        "instructions": _instructions(measured, run) if run is not None and counted else "",
        "missing": "".join(f"* {one} was not there when this was written\n" for one in measured.missing),
    }  # fmt: skip
    return filled("REPORT.md", known)


def _size(target: str, size: Size) -> str:
    depths = ", ".join(f"{WORDS[name]} {depth}" for name, depth in size.stack.items())
    stack = depths or "not reported by this compiler"
    return f"| {target} | {size.compiler} | {size.flash} | {size.ram} | {stack} |\n"


def _run(run: Run) -> str:
    result = f"PASS {run.frames} frames" if run.passed else "FAIL"
    return f"| {run.machine} | {result} | {run.equal} of {run.numbers} | {run.largest:.3g} |\n"


def _instructions(measured: Measured, run: Run) -> str:
    most = measured.search.most if measured.search is not None else {}
    rows = (
        f"| {WORDS[name]} | {usual} | {recorded} | {most.get(name, '-')} |\n"
        for name, (usual, recorded) in run.instructions.items()
    )
    tried = f"most of {measured.search.inputs} inputs" if measured.search is not None else "most found"
    return filled("REPORT_instructions.md", {"machine": run.machine, "tried": tried, "rows": "".join(rows)})


@dataclass(frozen=True)
class Exported:
    """The files that were written, and what was measured of them."""

    files: tuple[Path, ...]
    ram: int  # [bytes] of a finger
    measured: Measured


def write_export(request: Request, folder: Path) -> Exported:
    """Write what is asked for as C99 to ``folder``, compile it, run its self-test and report."""
    written = texts.write(request)
    paths = []
    for name, text in written.files.items():
        paths.append(_write(folder / name, text))
    precision = PRECISIONS[request.precision]
    measured = measure(folder, request.prefix, written.program.calls, request.entry, precision)
    paths.append(_write(folder / "REPORT.md", report(request, written, measured)))
    return Exported(tuple(paths), written.ram, measured)


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text)
    return path
