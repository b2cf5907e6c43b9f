"""Run every example of this folder as a user would; fail if one fails, and name those that had no data."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

SKIPPED = 77
"""Exit code of an example whose data are not here: it has shown nothing, so it is not called ok."""

HERE = Path(__file__).parent


def main() -> int:
    """Run examples/*/run.py, each in an empty folder of its own; return how many failed."""
    failed = skipped = 0
    for example in sorted(HERE.glob("*/run.py")):
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            done = subprocess.run(
                [sys.executable, str(example)],
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
            )
        word = {0: "ok", SKIPPED: "skipped"}.get(done.returncode, "FAILED")
        failed, skipped = failed + (word == "FAILED"), skipped + (word == "skipped")
        print(f"{word:7} {example.parent.name} ({time.monotonic() - start:.1f} s)")
        if word == "FAILED":
            print(done.stdout, done.stderr, sep="\n", file=sys.stderr)
        if word == "skipped":
            print(f"        {done.stdout.strip().removeprefix('skipped: ')}")
    if skipped:
        print(f"{skipped} skipped: these show nothing without their data")
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
