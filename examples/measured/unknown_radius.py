"""What depends on an unrecorded radius, and what does not: the skin with three assumed probes."""

import tempfile
from dataclasses import replace
from pathlib import Path

from cases import HERE, SKIN, read, run, si

from vegrip.model import read_model, write_model


def unknown_radius() -> str:
    """Run the node with three radii; the stiffness prior at a given depth stays the same."""
    recording = read(SKIN)
    lines = [
        "| assumed radius | force in the hold, rms error | contact radius at its end | limit torque / mu N |",
        "|---|---|---|---|",
    ]
    for radius in (6e-3, 8e-3, 16e-3):
        with tempfile.TemporaryDirectory() as folder:
            model = read_model(HERE / "skin_model.toml")
            write_model(replace(model, tip_radius=radius), Path(folder) / "skin_model.toml")
            (Path(folder) / "skin.toml").write_text((HERE / "skin.toml").read_text())
            result = run(replace(SKIN, parameters=str(Path(folder) / "skin")), recording)
        a = result.contact["contact_radius"][-1]
        arm = result.contact["limit_torque"][-1] / result.contact["limit_force"][-1]
        error = result.error(result.estimated_force(), SKIN.window)
        lines.append(f"| {1e3 * radius:.0f} mm | {si(error)} | {1e3 * a:.1f} mm | {1e3 * arm:.1f} mm |")
    return "\n".join(lines)
