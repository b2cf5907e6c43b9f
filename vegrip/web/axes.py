"""Drawings as inline SVG: axes with round ticks and units, lines, bands and points. Pure text, no library.

Colours are names of the style sheet, so that a drawing is light or dark as its page is, and prints.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

Pair = tuple[float, float]
TICKS = 5  # about so many on an axis
MARK = 58  # [px] half of the words on a mark
LEFT, RIGHT, TOP, BOTTOM = 62, 12, 16, 40  # [px] around the drawing


@dataclass
class Axes:
    """One drawing.

    Args:
        x, y: least and greatest value shown.
        x_label, y_label: with units; without a label of y no ticks.
        size: width and height [px].
        logarithmic: the y axis.

    """

    x: Pair
    y: Pair
    x_label: str
    y_label: str
    size: tuple[int, int] = (640, 220)
    is_logarithmic: bool = False
    x_names: Sequence[str] = ()  # names instead of numbers, at 0, 1, 2, ...
    _parts: list[str] = field(default_factory=list)

    def line(self, xs: Sequence[float], ys: Sequence[float], colour: str, **style: object) -> None:
        given = {"stroke": f"var(--{colour})", "fill": "none", "stroke-width": 1.8} | style
        self._path(list(zip(xs, ys, strict=True)), given, closed=False)

    def band(self, xs: Sequence[float], low: Sequence[float], high: Sequence[float], colour: str) -> None:
        outline = [*zip(xs, high, strict=True), *reversed(list(zip(xs, low, strict=True)))]
        self._path(outline, {"fill": f"var(--{colour})", "stroke": "none"}, closed=True)

    def points(
        self,
        xs: Sequence[float],
        ys: Sequence[float],
        colour: str,
        *,
        filled: bool = True,
        radius: float = 4.5,
    ) -> None:
        fill = f"var(--{colour})" if filled else "var(--card)"
        self._parts += [
            f'<circle cx="{self._x(x):.1f}" cy="{self._y(y):.1f}" r="{radius}" fill="{fill}" '
            f'stroke="var(--{colour})" stroke-width="2"/>'
            for x, y in zip(xs, ys, strict=True)
        ]

    def mark(self, x: Pair, text: str) -> None:
        left, right = self._x(x[0]), self._x(x[1])
        self._parts.append(
            f'<rect x="{left:.1f}" y="{TOP}" width="{max(right - left, 2.0):.1f}" height="{self._height}" '
            'fill="none" stroke="var(--red)" stroke-width="1.5" stroke-dasharray="4 3"/>'
        )
        middle = min(max((left + right) / 2.0, LEFT + MARK), self.size[0] - RIGHT - MARK)
        self._parts.append(
            f'<text x="{middle:.1f}" y="{TOP - 3}" text-anchor="middle" class="bad">{escape(text)}</text>'
        )

    def svg(self, title: str) -> str:
        """Return the drawing; ``title`` says what it is to who cannot see it."""
        width, height = self.size
        return (
            f'<svg viewBox="0 0 {width} {height}" width="100%" role="img" aria-label="{escape(title)}">'
            f"{''.join(self._frame())}{''.join(self._parts)}</svg>"
        )

    @property
    def _width(self) -> int:
        return self.size[0] - LEFT - RIGHT

    @property
    def _height(self) -> int:
        return self.size[1] - TOP - BOTTOM

    def _x(self, value: float) -> float:
        share = (value - self.x[0]) / ((self.x[1] - self.x[0]) or 1.0)
        return LEFT + min(max(share, 0.0), 1.0) * self._width

    def _y(self, value: float) -> float:
        low, high, value = (_log(v) if self.is_logarithmic else v for v in (*self.y, value))
        share = (value - low) / ((high - low) or 1.0)
        return TOP + (1.0 - min(max(share, 0.0), 1.0)) * self._height

    def _path(self, points: Sequence[Pair], style: dict[str, object], *, closed: bool) -> None:
        if not points:
            return
        drawn = "L".join(f"{self._x(x):.1f} {self._y(y):.1f}" for x, y in points)
        attributes = " ".join(f'{name}="{value}"' for name, value in style.items())
        self._parts.append(f'<path d="M{drawn}{"Z" if closed else ""}" {attributes}/>')

    def _frame(self) -> list[str]:
        width, height = self.size
        foot, parts = height - BOTTOM, []
        rows = log_ticks(self.y) if self.is_logarithmic else ticks(self.y)
        for tick in rows if self.y_label else ():
            y = self._y(tick)
            parts.append(f'<path class="axis" d="M{LEFT} {y:.1f}H{width - RIGHT}"/>')
            parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
        named = [(float(i), name) for i, name in enumerate(self.x_names)]
        for tick, name in named or [(tick, f"{tick:g}") for tick in ticks(self.x)]:
            x = self._x(tick)
            parts.append(f'<path class="axis" d="M{x:.1f} {TOP}V{foot}"/>')
            parts.append(f'<text x="{x:.1f}" y="{foot + 15}" text-anchor="middle">{escape(name)}</text>')
        middle = LEFT + self._width / 2
        parts.append(
            f'<text x="{middle}" y="{height - 6}" text-anchor="middle">{escape(self.x_label)}</text>'
        )
        turned = f"translate(13 {TOP + self._height / 2}) rotate(-90)"
        parts.append(f'<text transform="{turned}" text-anchor="middle">{escape(self.y_label)}</text>')
        return parts


def ticks(extent: Pair) -> list[float]:
    """Return round numbers within ``extent``, about five."""
    low, high = extent
    if not high > low:
        return [low]
    rough = (high - low) / TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough)
    first = math.ceil(low / step - 1e-9)
    count = math.floor(high / step + 1e-9) - first + 1
    return [round((first + i) * step, 12) for i in range(count)]


def log_ticks(extent: Pair) -> list[float]:
    """Return 1, 2 and 5 times powers of ten within ``extent``."""
    low, high = extent
    powers = range(math.floor(_log(low)), math.ceil(_log(high)) + 1)
    return [v for p in powers for m in (1.0, 2.0, 5.0) if low <= (v := m * 10.0**p) <= high]


def extent(values: Sequence[float], *, room: float = 0.06) -> Pair:
    """Return least and greatest of ``values`` with some room around."""
    finite = [value for value in values if math.isfinite(value)]
    if not finite:
        return 0.0, 1.0
    low, high = min(finite), max(finite)
    away = room * ((high - low) or abs(high) or 1.0)
    return low - away, high + away


def _log(value: float) -> float:
    return math.log10(max(value, 1e-12))
