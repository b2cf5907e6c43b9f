"""Begins a helper of a node: ``python -m vegrip.runtime.behind PARENT MODULE [ARGUMENT ...]``.

From here on the helper ends with its node. It may not wait with that for the imports of MODULE: they take
seconds, minutes on a busy machine, in which a node may have ended.
"""

import runpy
import sys

from vegrip.host.realtime import take_usual_priority
from vegrip.runtime.launcher import end_with_parent

if __name__ == "__main__":
    parent, module = int(sys.argv[1]), sys.argv[2]
    end_with_parent(parent)
    take_usual_priority()  # where no program in front of it has done so
    sys.argv[:3] = [module]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
