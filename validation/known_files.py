"""Tables and logs whose truth is known, as instruments, spreadsheets and loggers write them, with faults.

Each is drawn from a seed. A reader may refuse one, or say what of it is lost; it may not make a recording
that lacks or changes more than 1 % of it without a word.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import can
import numpy as np

from vegrip.messages import FingertipState
from vegrip.transport.codec import CanCodec
from vegrip.types import Floats

PERIOD = 0.01  # [s]
CLASSIC = 8  # [bytes] of a frame that is not FD
ALLOWED = 0.01  # of the rows
CLOSE = 2e-3  # of the range of a channel: what rounding in the file may change


@dataclass
class Truth:
    """What was measured, and how it stands in a file."""

    t: Floats  # [s]
    columns: dict[str, Floats]  # SI
    arguments: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)  # the form and the faults

    def share_wrong(self, t: Floats, columns: dict[str, Floats]) -> float:
        """Return the share of the rows that a recording lacks, or has at another time or value."""
        best = 1.0
        for shift in (self.t[0] - t[0], self.t[-1] - t[-1]):
            at = np.searchsorted(t + shift, self.t - PERIOD / 2)
            there = at < len(t)
            at = np.minimum(at, len(t) - 1)
            there &= np.abs(t[at] + shift - self.t) <= PERIOD / 2
            for name, values in self.columns.items():
                if name not in columns:
                    return 1.0
                slack = CLOSE * float(np.ptp(values))
                there &= np.abs(columns[name][at] - values) <= slack
            best = min(best, float(np.mean(~there)))
        return best


def press(rng: np.random.Generator) -> Truth:
    rows = int(rng.integers(250, 700))
    t: Floats = PERIOD * np.arange(rows, dtype=np.float64)
    top = rows // 2
    depth = np.interp(np.arange(rows), [0, 40, top, rows - 20, rows], [0, 0, 1, 0, 0]) * rng.uniform(0.4, 3.0)
    force = rng.uniform(500, 9000) * (depth / depth.max()) ** 1.5 + rng.normal(0, 2, rows)
    return Truth(t, {"displacement": 1e-3 * depth, "normal_force": 1e-3 * force})


def grouped(text: str, mark: str, sign: str) -> str:
    whole, _, rest = text.partition(".")
    minus, digits = whole[: whole.startswith("-")], whole.lstrip("-")
    parts = [digits[max(0, i - 3) : i] for i in range(len(digits), 0, -3)][::-1]
    return minus + mark.join(parts) + (sign + rest if rest else "")


def table(seed: int, folder: Path) -> tuple[Path, Truth]:
    """Write a table of a press; return its path and its truth."""
    rng = np.random.default_rng(seed)
    truth = press(rng)
    delimiter, sign = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ",")][rng.integers(5)]
    mark = rng.choice(["", "", "", {".": ",", ",": "."}[sign], "\u202f", "'"])
    digits = {"t": int(rng.choice([0, 1])), "d": int(rng.choice([0, 1, 3])), "f": int(rng.choice([0, 1, 2]))}
    minus = rng.choice(["-", "-", "\u2212"])
    t_ms, d_um, f_mn = (
        1e3 * truth.t + rng.choice([0.0, -2000.0, 3.6e6]),
        1e6 * truth.columns["displacement"],
        1e3 * truth.columns["normal_force"],
    )
    truth.columns = {
        "displacement": 1e-6 * np.round(d_um, digits["d"]),
        "normal_force": 1e-3 * np.round(f_mn, digits["f"]),
    }
    t_ms = times(rng, t_ms, truth)
    cells = [
        [write(value, digits[name], sign, mark, minus) for value in values]
        for name, values in (("t", t_ms), ("d", d_um), ("f", f_mn))
    ]
    break_cells(rng, cells, f_mn, truth)
    quote = '"' if delimiter in "".join((sign, mark)) else ""
    lines = [delimiter.join(f"{quote}{cell}{quote}" for cell in row) for row in zip(*cells, strict=True)]
    lines = break_lines(rng, lines, truth, may_double="times right" in truth.said)
    names, units = ["Zeit", "Weg", "Kraft"], ["(ms)", "(\u00b5m)", "(mN)"]
    head = [delimiter.join(names)]
    truth.arguments = ["--map", "t=Zeit", "--map", "displacement=Weg", "--map", "normal_force=Kraft"]
    if rng.random() < 0.3:
        head.append(delimiter.join(units))
        truth.said.append("a line of units")
    else:
        truth.arguments += ["--unit", "t=ms", "--unit", "displacement=um", "--unit", "normal_force=mN"]
    above = [f"Pr\u00fcfstand{delimiter}7", "Datum: 3. M\u00e4rz", ""][: int(rng.choice([0, 0, 3]))]
    encoding = rng.choice(["utf-8", "utf-8-sig", "cp1252", "utf-16"])
    encoding = encoding if "\u202f" not in mark and minus == "-" else "utf-8"
    truth.said += [
        f"delimiter {delimiter!r}, decimal {sign!r}, thousands {mark!r}, minus {minus!r}, {encoding}"
    ]
    truth.said += [f"digits {digits}"]
    path = folder / f"{seed}.csv"
    path.write_text("\n".join([*above, *head, *lines]) + "\n", encoding=encoding)
    return path, truth


def write(value: float, digits: int, sign: str, mark: str, minus: str) -> str:
    text = f"{value:.{digits}f}"
    text = grouped(text, mark, sign) if mark else text.replace(".", sign)
    return text.replace("-", minus)


TIMES = ("coarse", "differences", "set back", "set forward", "standing", "reversed", "equal")


def times(rng: np.random.Generator, t_ms: Floats, truth: Truth) -> Floats:
    """Return the times as a clock writes them."""
    kind = str(rng.choice(["right", "right", "right", *TIMES]))
    truth.said.append(f"times {kind}")
    half = len(t_ms) // 2
    by = float(rng.choice([200.0, 1500.0, 3.6e6]))
    if kind == "standing":
        t_ms = t_ms.copy()
        t_ms[half : half + int(rng.choice([2, 30, 120]))] = t_ms[half]
    return {
        "coarse": np.floor(t_ms / 50.0) * 50.0,
        "differences": np.concatenate([[0.0], np.diff(t_ms)]),
        "set back": np.concatenate([t_ms[:half], t_ms[half:] - by]),
        "set forward": np.concatenate([t_ms[:half], t_ms[half:] + by]),
        "reversed": t_ms[::-1],
        "equal": np.full_like(t_ms, t_ms[0]),
    }.get(kind, t_ms)


def break_cells(rng: np.random.Generator, cells: list[list[str]], force: Floats, truth: Truth) -> None:
    """Put words where a sensor did not measure."""
    kind = rng.choice(["none", "none", "top", "some", "stretch", "below"])
    word = rng.choice(["OL", "----", "#WERT!", "1.2.3.4", "-9999", "99999", "NaN", ""])
    truth.said.append(f"{kind} of the forces {word!r}")
    half = len(force) // 2
    bad = {
        "none": np.zeros(len(force), dtype=bool),
        "top": force > rng.uniform(0.7, 0.99) * force.max(),
        "some": rng.random(len(force)) < rng.choice([0.004, 0.03, 0.3]),
        "stretch": np.abs(np.arange(len(force)) - half) < rng.choice([2, 20, 80]),
        "below": force < rng.uniform(0.0, 0.2) * force.max(),
    }[str(kind)]
    for row in np.flatnonzero(bad):
        cells[2][row] = str(word)


def break_lines(rng: np.random.Generator, lines: list[str], truth: Truth, *, may_double: bool) -> list[str]:
    kind = rng.choice(["none", "none", "none", "torn", "doubled", "words"])
    kind = "none" if kind == "doubled" and not may_double else kind  # it would be two differences
    truth.said.append(f"lines {kind}")
    count = int(rng.choice([1, 4, 60]))
    for row in rng.choice(len(lines) - 40, count, replace=False) + 30:
        if kind == "torn":
            lines[row] = lines[row][: len(lines[row]) // 2]
        if kind == "doubled":
            lines[row] = f"{lines[row]}\n{lines[row]}"
        if kind == "words":
            lines[row] = "--- interrupted ---"
    return lines


Frames = list[tuple[float, int, bytes, int]]
"""Time [s], identifier, data, channel."""
Writer = Callable[[Path, Frames, np.random.Generator], None]
Fault = Callable[[Frames, list[int], np.random.Generator], Frames]


def write_candump(path: Path, frames: Frames, _: np.random.Generator) -> None:
    marks = {True: "##1", False: "#"}
    text = "".join(
        f"({t:.6f}) can{c} {i:03X}{marks[len(data) > CLASSIC]}{data.hex().upper()}\n"
        for t, i, data, c in frames
    )
    path.write_text(text, encoding="utf-8")


def write_asc(path: Path, frames: Frames, rng: np.random.Generator) -> None:
    is_relative, before = bool(rng.random() < 0.5), 0.0
    day = "Di M\u00e4r 2 09:37:49 2021"
    kind = "relative" if is_relative else "absolute"
    lines = [
        f"date {day}",
        f"base hex  timestamps {kind}",
        "no internal events logged",
        f"Begin Triggerblock {day}",
    ]
    sizes = {8: 8, 12: 9, 16: 10, 20: 11, 24: 12, 32: 13, 48: 14, 64: 15}
    for t, i, data, c in frames:
        said = t - before if is_relative else t
        shown = " ".join(f"{b:02x}" for b in data)
        head = f"{said:.6f} CANFD {c + 1} Rx {i:x} 1 0 {sizes[len(data)]:x} {len(data)} {shown} 0 0 0 0 0"
        lines.append(head if len(data) > CLASSIC else f"{said:.6f} {c + 1} {i:x} Rx d {len(data)} {shown}")
        before = t
    path.write_text("\n".join(lines) + "\n", encoding="cp1252")


def write_blf(path: Path, frames: Frames, rng: np.random.Generator) -> None:
    with can.BLFWriter(path, compression_level=int(rng.choice([-1, 0]))) as writer:
        for t, i, data, c in frames:
            fd = len(data) > CLASSIC
            writer.on_message_received(
                can.Message(t, i, is_extended_id=False, data=data, is_fd=fd, channel=c, bitrate_switch=fd)
            )


def write_trc(path: Path, frames: Frames, _: np.random.Generator) -> None:
    with can.TRCWriter(path) as writer:
        for t, i, data, c in frames:
            writer.on_message_received(can.Message(t, i, is_extended_id=False, data=data, channel=c))


def at(frames: Frames, times: list[float]) -> Frames:
    return [(t, *one[1:]) for t, one in zip(times, frames, strict=True)]


def without(frames: Frames, some: list[int], _: np.random.Generator) -> Frames:
    return [one for k, one in enumerate(frames) if k not in set(some)]


def silent(frames: Frames, some: list[int], _: np.random.Generator) -> Frames:
    begin = len(frames) // 3
    return frames[:begin] + frames[begin + len(some) :]


def damaged(frames: Frames, some: list[int], _: np.random.Generator) -> Frames:
    found = list(frames)
    for k in some:
        t, i, data, c = frames[k]
        found[k] = t, i, data[:5] + bytes((data[5] ^ 0x41,)) + data[6:], c
    return found


def set_from_the_middle(frames: Frames, by: float) -> Frames:
    half = len(frames) // 2
    return at(frames, [one[0] + (by if k >= half else 0.0) for k, one in enumerate(frames)])


def as_differences(frames: Frames) -> Frames:
    stamps = [one[0] for one in frames]
    return at(frames, [0.0, *np.diff(stamps).tolist()])


FAULTY: dict[str, Fault] = {
    "lost": without,
    "silence": silent,
    "damaged": damaged,
    "reversed": lambda frames, _some, _rng: frames[::-1],
    "echo": lambda frames, _some, _rng: [one for one in frames for _ in range(2)],
    "coarse": lambda frames, _some, _rng: at(frames, [float(np.floor(one[0])) for one in frames]),
    "zero": lambda frames, _some, _rng: at(frames, [0.0] * len(frames)),
    "channels": lambda frames, _some, _rng: sorted(
        [*frames, *((t + 0.004, i, data, 1) for t, i, data, _ in frames)]
    ),
}
FAULTS = ("none", "torn", "cut", "set back", "set forward", "differences", *FAULTY)
WRITERS: dict[str, Writer] = {".log": write_candump, ".asc": write_asc, ".blf": write_blf, ".trc": write_trc}


def log(seed: int, folder: Path) -> tuple[Path, Truth]:
    """Write a log of a press in our own layout; return its path and its truth."""
    rng = np.random.default_rng(seed)
    truth = press(rng)
    suffix = str(rng.choice(list(WRITERS)))
    codec = CanCodec(("thumb",), fd=suffix != ".trc" and bool(rng.random() < 0.7))
    frames: Frames = []
    begin = float(rng.choice([0.0, 1.7e9]))
    for k, t in enumerate(truth.t.tolist()):
        state = FingertipState(
            round(1e9 * t) + 1, "thumb", k, **{n: float(v[k]) for n, v in truth.columns.items()}
        )
        frames += [(begin + t, frame.arbitration_id, frame.data, 0) for frame in codec.encode(state)]
    kind = str(rng.choice(FAULTS))
    truth.said.append(f"{suffix} from {begin:g} s, {kind}")
    count = int(rng.choice([2, 12, len(frames) // 3]))
    some = sorted(rng.choice(len(frames) - 20, count, replace=False) + 10)
    if kind in FAULTY:
        frames = FAULTY[kind](frames, some, rng)
    elif kind == "set back":
        frames = set_from_the_middle(frames, -float(rng.choice([0.3, 3600.0])) if begin else -0.3)
    elif kind == "set forward":
        frames = set_from_the_middle(frames, float(rng.choice([0.3, 3600.0])))
    elif kind == "differences" and suffix == ".log":
        frames = as_differences(frames)
    path = folder / f"{seed}{suffix}"
    WRITERS[suffix](path, frames, rng)
    content = path.read_bytes()
    if kind == "torn" and suffix != ".blf":
        lines = content.split(b"\n")
        for k in some:
            lines[k] = lines[k][: len(lines[k]) * 2 // 3]
        path.write_bytes(b"\n".join(lines))
    if kind == "cut" and suffix == ".blf":  # a text that is cut is a shorter one
        path.write_bytes(content[: int(len(content) * rng.choice([0.5, 0.93, 0.999]))])
    truth.arguments = ["--fingers", "thumb"]
    return path, truth
