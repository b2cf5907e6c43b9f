"""Draw the figures of docs/theory.md and print the numbers it quotes.

Run it with ``.venv/bin/python docs/theory_figures.py``.
"""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from vegrip.contact.coupling import creep_ratio, exponent_after_creep, radius_ratio
from vegrip.contact.creep import indentation_after_step, paper_indentation_after_step
from vegrip.contact.elastic import ExponentialStiffness, PowerStiffness
from vegrip.contact.geometry import contact_radius, parabolic_radius
from vegrip.contact.hereditary import hereditary_force, solve
from vegrip.contact.limit_surface import reference
from vegrip.contact.paper.figures import panels
from vegrip.contact.paper.tables import CANONICAL_K, fit_power, fit_radius, fit_radius_directly
from vegrip.contact.paper.tables import CREEP as H
from vegrip.contact.paper.tables import RELAXATION as G
from vegrip.contact.pressure import coefficient
from vegrip.contact.prony import creep_of, relaxation_of

IMAGES = Path(__file__).parent / "images"
SWITCH = 0.3  # [s] from displacement held to load held
HERTZ = PowerStiffness(4e4, 0.5)
SKIN = ExponentialStiffness(200.0, 900.0)
Drawn = tuple[Figure, dict[str, float]]


def conjugate() -> Drawn:
    """G and h of the paper are not a pair."""
    figure, (left, right) = panels(2)
    t = np.linspace(0, 4, 4001)
    j = creep_of(G)
    left.plot(t, H(t), label="paper: $h$", color="tab:red")
    left.plot(t, j(t), label="conjugate of $g$: $j$", color="black")
    left.set(xlabel="$t$ [s]", ylabel="reduced creep", xlim=(0, 4), ylim=(1, 1.5))
    right.plot(t, hereditary_force(t, H(t), G), label=r"$\int g\,dh$", color="tab:red")
    right.plot(t, hereditary_force(t, j(t), G), label=r"$\int g\,dj$", color="black")
    right.set(xlabel="$t$ [s]", ylabel="force that comes back", xlim=(0, 4), ylim=(0.85, 1.05))
    for ax in (left, right):
        ax.legend(frameon=False)
    pair = relaxation_of(H)
    numbers = {
        "int g dh, t -> inf": G.equilibrium * H.equilibrium,
        "j(inf)": j.equilibrium,
        "rate of j [1/s]": j.rates[0],
        "g(inf) conjugate to h": pair.equilibrium,
        "its rate [1/s]": pair.rates[0],
    }
    return figure, numbers


def creep_laws() -> Drawn:
    """Creep acts on the load, not on the indentation."""
    figure, (ax,) = panels()
    t = np.linspace(0, 3, 301)
    ax.plot(t, H(t), color="tab:red", label="paper: $h$, any stiffness")
    ax.plot(t, _ratio(t, HERTZ, 1.0), color="black", label="sphere, any load")
    for N, dashes in ((0.05, "--"), (1.0, "-."), (10.0, ":")):
        ax.plot(
            t, _ratio(t, SKIN, N), color="tab:blue", linestyle=dashes, label=f"exponential stiffness, {N:g} N"
        )
    ax.set(xlabel="$t$ [s]", ylabel=r"$\delta / \delta_0$ under constant load", xlim=(0, 3), ylim=(1, 1.5))
    ax.legend(fontsize=7, frameon=False)
    numbers = {f"exponential, {N:g} N": float(_ratio(np.inf, SKIN, N)) for N in (0.05, 1.0, 10.0)}
    power = np.log(creep_of(G).equilibrium) / np.log(H.equilibrium)
    sphere = float(_ratio(np.inf, HERTZ, 1.0))
    return figure, {"sphere": sphere, "power at which the paper is right": power} | numbers


def saturation() -> Drawn:
    """The coupling ends where the pressure is uniform."""
    figure, (ax,) = panels()
    h = np.linspace(1, 1.4995, 400)
    exact = exponent_after_creep(h)
    ax.semilogy(h, exact.k, color="black", label="eq. (4) inverted")
    ax.semilogy(h, fit_power().exponent(h), color="tab:red", linestyle="--", label="eq. (40)")
    ax.axvspan(1.5, 1.65, color="lightgrey", label="saturated")
    ax.set(xlabel="$h$", ylabel="$k$", xlim=(1, 1.65))
    ax.legend(frameon=False)
    last = exponent_after_creep([1.4, 1.6])
    numbers = {"k at h = 1.4": last.k[0], "largest k": last.k[1], "largest a/a0": float(radius_ratio(np.inf))}
    return figure, numbers


def mixed() -> Drawn:
    """Which force the creep ratio is taken against."""
    figure, (left, right) = panels(2)
    t = np.linspace(0, 2, 401)
    held = t < SWITCH
    relaxed = float(HERTZ.force(1e-3) * G(SWITCH))
    delta, N = np.where(held, 1e-3, np.nan), np.where(held, np.nan, relaxed)
    history = solve(t, HERTZ, G, indentation=delta, normal_force=N)
    left.plot(t, history.normal_force, color="black")
    left.set(xlabel="$t$ [s]", ylabel="$N$ [N]", xlim=(0, 2), ylim=(0, None))
    left.set_title(f"displacement held, from {SWITCH:g} s on load held", fontsize=9)
    last = {}
    for reference_force, colour in (("present", "tab:red"), ("largest", "black")):
        ratio = creep_ratio(t, history.indentation, history.normal_force, HERTZ, reference=reference_force)
        k = exponent_after_creep(ratio).k
        right.plot(t, k, color=colour, label=f"$N_{{ref}}$ = {reference_force} force")
        last[f"k at {SWITCH:g} s, {reference_force} force"] = k[held][-1]
        last[f"k at 2 s, {reference_force} force"] = k[-1]
    right.set(xlabel="$t$ [s]", ylabel="$k$", xlim=(0, 2))
    right.legend(frameon=False)
    return figure, last


def radius() -> Drawn:
    """Three radii for one indentation."""
    figure, (left, right) = panels(2)
    x = np.linspace(1e-6, 0.4, 200)
    left.plot(x, contact_radius(x, 1.0), color="black", label="eq. (1)")
    left.plot(x, parabolic_radius(x, 1.0, 2.0), color="tab:red", label=r"eq. (32), $\kappa = 2$")
    left.plot(x, parabolic_radius(x, 1.0, 1.0), color="tab:blue", label=r"Hertz, $\kappa = 1$")
    left.set(xlabel=r"$\delta / R$", ylabel="$a / R$", xlim=(0, 0.4), ylim=(0, None))
    excess = parabolic_radius(x, 1.0) / contact_radius(x, 1.0)
    right.plot(x, 100 * (excess**2 - 1), color="black", label="$a^2$")
    right.plot(x, 100 * (excess - 1), color="black", linestyle="--", label="$a$")
    right.plot(0.2, 10, "o", color="tab:red", label="footnote 4")
    right.set(xlabel=r"$\delta / R$", ylabel="eq. (32) above eq. (1) [%]", xlim=(0, 0.4), ylim=(0, None))
    for ax in (left, right):
        ax.legend(frameon=False)
    at = float(parabolic_radius(0.2, 1.0) / contact_radius(0.2, 1.0))
    return figure, {"excess of a^2 at 20 % [%]": 100 * (at**2 - 1), "excess of a at 20 % [%]": 100 * (at - 1)}


def inversion() -> Drawn:
    """The fitted inversion misses where it starts."""
    figure, (ax,) = panels()
    h = np.linspace(1, 1.3, 121)
    exact = exponent_after_creep(h).k
    samples = {"2, 2.1 .. 4": CANONICAL_K, "2, 3 .. 10": np.arange(2, 11), "1, 2 .. 10": np.arange(1, 11)}
    numbers = {}
    for name, k in samples.items():
        fitted = fit_power(k).exponent(h)
        ax.plot(h, fitted - exact, label=f"fit at $k$ = {name}")
        numbers[f"k(h = 1), fit at {name}"] = fitted[0]
    ax.axhline(0, color="black", linewidth=0.8)
    ax.set(xlabel="$h$", ylabel="$k$ of eq. (40) minus exact", xlim=(1, 1.3))
    ax.legend(frameon=False, fontsize=8)
    return figure, numbers


def radius_fits() -> Drawn:
    """What the paper leaves open about its least squares."""
    figure, (ax,) = panels()
    k = np.linspace(2, 4, 201)
    fits = {
        "$W = I$": fit_radius(weights="equal"),
        "$W = diag(y)$": fit_radius(weights="y"),
        "$W = diag(y^2)$, canonical": fit_radius(),
        "$k$ = 2, 3, 4 only": fit_radius([2.0, 3.0, 4.0]),
        "three parameters": fit_radius_directly(offset=True),
    }
    for name, fit in fits.items():
        ax.plot(k, 100 * (fit.radius_ratio(k) / radius_ratio(k) - 1), label=name)
    ax.axhline(0, color="black", linewidth=0.8)
    ax.set(xlabel="$k$", ylabel="fitted $a/a_0$ against eq. (25) [%]", xlim=(2, 4))
    ax.legend(fontsize=7, frameon=False)
    numbers = {f"A, {name}": fit.A for name, fit in fits.items()}
    return figure, numbers | {f"B, {name}": fit.B for name, fit in fits.items()}


def peak() -> Drawn:
    """Where figs. 5 and 8 must end."""
    figure, (ax,) = panels()
    k = np.linspace(2, 5, 200)
    end = exponent_after_creep(H.equilibrium).k
    ax.plot(k, _peak(k), color="black", label=r"$C_k (a_0 / a)^2 = C_k^2 / C_{k_0}$")
    ax.plot(end, _peak(end), "o", color="tab:red", label=f"end of fig. 8, {float(_peak(end)):.4f}")
    ax.plot(4, _peak(4.0), "s", color="tab:blue", label=f"end of fig. 5, {float(_peak(4.0)):.4f}")
    ax.set(xlabel="$k$", ylabel=r"$p_{max} / \bar p_0$", xlim=(2, 5))
    ax.legend(frameon=False)
    return figure, {"end of fig. 8": float(_peak(end)), "end of fig. 5": float(_peak(4.0))}


def signs() -> Drawn:
    """The sign of the force in the paper's equations."""
    figure, (ax,) = panels(height=3.0)
    d = np.tan(np.linspace(0, 0.499 * np.pi, 200))
    f, m = reference.point(2.0, d)
    ax.plot(-f, m, color="tab:red", label="eqs. (57), (58): COR at $+d$")
    ax.plot(f, m, color="black", label="magnitudes, as here and in figs. 9, 10")
    ax.set(xlabel=r"$f_t / (\mu N)$", ylabel=r"$m_n / (\mu N a)$", ylim=(0, 0.75))
    ax.legend(frameon=False, fontsize=8)
    return figure, {"f at d = a": float(reference.point(2.0, 1.0)[0])}


def _ratio(t: float | np.ndarray, law: PowerStiffness | ExponentialStiffness, N: float) -> np.ndarray:
    return indentation_after_step(t, N, law, G) / paper_indentation_after_step(0.0, N, law, H)


def _peak(k: float | np.ndarray) -> np.ndarray:
    return np.asarray(coefficient(k) / radius_ratio(k) ** 2)


def figures() -> Iterator[Callable[[], Drawn]]:
    """In the order of the page."""
    yield from (conjugate, creep_laws, saturation, mixed, radius, inversion, radius_fits, peak, signs)


def main() -> None:
    """Write the PNGs and print the numbers."""
    IMAGES.mkdir(exist_ok=True)
    for draw in figures():
        figure, numbers = draw()
        figure.savefig(IMAGES / f"theory-{draw.__name__.replace('_', '-')}.png", dpi=100)
        sys.stdout.write(f"{draw.__name__}\n")
        sys.stdout.writelines(f"  {name:40} {float(value):.6g}\n" for name, value in numbers.items())


if __name__ == "__main__":
    main()
