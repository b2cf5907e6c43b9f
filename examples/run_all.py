"""Run every example of this folder as a user would; fail if one of them fails."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent
QUICK = {"worked": ["--only", "robot-hand"]}
"""Arguments for examples that would otherwise take minutes."""


def main() -> int:
    """Run examples/*/run.py, each in an empty folder of its own; return how many failed."""
    failed = 0
    for example in sorted(HERE.glob("*/run.py")):
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            done = subprocess.run(
                [sys.executable, str(example), *QUICK.get(example.parent.name, [])],
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
            )
        ok = done.returncode == 0
        failed += not ok
        print(f"{'ok    ' if ok else 'FAILED'} {example.parent.name} ({time.monotonic() - start:.1f} s)")
        if not ok:
            print(done.stdout, done.stderr, sep="\n", file=sys.stderr)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
