"""Names of nodes and namespaces."""

import re

from vegrip.errors import ConfigError

_NAME = re.compile(r"[a-zA-Z][a-zA-Z0-9_]*")


def full_name(namespace: str, name: str) -> str:
    """Return ``/namespace/name``.

    Raises:
        ConfigError: a part that is not letters, digits and _, beginning with a letter.

    """
    parts = [part for part in namespace.split("/") if part] + [name]
    for part in parts:
        if not _NAME.fullmatch(part):
            raise ConfigError(f"{part!r} is no name for a node or namespace: letters, digits and _ only")
    return "/" + "/".join(parts)
