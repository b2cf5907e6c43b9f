"""All checks of a machine, in the order of the report."""

from pathlib import Path

from vegrip.runtime.doctor import can_interfaces, checks, rights
from vegrip.runtime.doctor.finding import Finding


def examine(root: Path = Path("/"), recordings: Path = Path()) -> list[Finding]:
    """Return what was found; takes about half a second, changes nothing.

    Args:
        root: where the kernel's files are.
        recordings: folder that recordings go to.

    """
    return [
        checks.kernel(root),
        checks.clock_source(root),
        checks.clock(),
        checks.wake_up(),
        checks.governor(root),
        rights.priority(),
        rights.sockets(),
        rights.compiler_cache(),
        can_interfaces.raw_sockets(),
        *can_interfaces.interfaces(),
        checks.disk(recordings.resolve()),
    ]
