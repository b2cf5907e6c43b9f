"""An effect of somebody else's package, from installed wheels, in an environment of its own."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

pytestmark = pytest.mark.long
ROOT = Path(__file__).parents[1]

NOT_SOURCE = shutil.ignore_patterns(
    ".*", "build", "recordings", "tests", "docs", "examples", "__pycache__", "*.egg-info"
)

USE = """
import numpy as np
import vegrip
from vegrip.effects import effect, names
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model, read_model, write_model

assert "site-packages" in vegrip.__file__, vegrip.__file__
assert "second_spot" in names()
base = paper_model(8e-3)
model = base.with_effect(effect("second_spot"))
t = np.linspace(0.0, 1.0, 500)
depth = 2.0 * base.reference_depth * t
more = model.simulate(t, depth).normal_force - base.simulate(t, depth).normal_force
assert more[100] == 0.0 and more[-1] > 0.1 * base.simulate(t, depth).normal_force[-1]
write_model(model, "model.toml")
assert [e.name for e in read_model("model.toml").effects][-1] == "second_spot"
estimator = ContactEstimator(model, SensorNoise())
force = model.simulate(t, depth).normal_force
for i in range(t.size):
    state = FingertipState(int(1e9 * t[i]), "tip", i, force[i], 0.0, 0.0, 0.0, depth[i])
    estimate = estimator.update(state)
assert abs(estimate.normal_force.value - force[-1]) < 0.05
"""


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """A Python with vegrip and the example installed from wheels; only what they depend on is borrowed."""
    folder = tmp_path_factory.mktemp("clean")
    for source in (ROOT, ROOT / "examples" / "second_spot"):
        build = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation"]
        copied = folder / "source" / source.name
        shutil.copytree(source, copied, ignore=NOT_SOURCE)
        subprocess.run([*build, "-w", str(folder / "wheels"), str(copied)], check=True)
    venv.create(folder / "env")
    own = folder / "env" / "bin" / "python"
    wheels = [str(path) for path in (folder / "wheels").glob("*.whl")]
    install = [sys.executable, "-m", "pip", "--python", str(own), "install", "-q", "--no-deps", "--no-index"]
    subprocess.run([*install, "--no-compile", *wheels], check=True)
    site = next((folder / "env" / "lib").glob("python*/site-packages"))
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return own


def run(python, tmp_path, *arguments):
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    return subprocess.run(
        [python, *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )


def test_it_is_simulated_saved_and_followed_online_like_a_built_in_one(python, tmp_path):
    done = run(python, tmp_path, "-c", USE)
    assert done.returncode == 0, done.stderr


def test_the_tests_that_come_with_it_pass_there(python, tmp_path):
    tests = ROOT / "examples" / "second_spot" / "tests"
    done = run(python, tmp_path, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tests))
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout
