"""The C compiler of this machine."""

import os
import shutil


def compiler() -> str | None:
    """Return the path of the C compiler: ``CC`` of the environment, else cc, gcc or clang."""
    for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        if name and (found := shutil.which(name)):
            return found
    return None
