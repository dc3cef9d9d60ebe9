"""`pip install --no-build-isolation .` without a network, from the build that is there."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(os.environ["LAMELLA_SOURCE"])
BUILD = Path(os.environ["PYTHONPATH"]).parent


def test_the_package_installs_from_the_build(tmp_path):
    for module in "setuptools", "wheel", "pip":
        pytest.importorskip(module)
    if shutil.which("cmake") is None:
        pytest.skip("no cmake")
    place = tmp_path / "site"
    environment = {**os.environ, "LAMELLA_BUILD": str(BUILD)}
    del environment["PYTHONPATH"]
    done = subprocess.run([sys.executable, "-m", "pip", "install", "--no-build-isolation",
                           "--no-index", "--no-deps", "--target", str(place), str(SOURCE)],
                          env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    told = subprocess.run(
        [sys.executable, "-c", "import lamella; print(lamella.__file__, lamella.__version__)"],
        cwd=tmp_path, env={**environment, "PYTHONPATH": str(place)}, capture_output=True, text=True,
        check=True).stdout.split()
    assert Path(told[0]).is_relative_to(place)
    assert {"_core.pyi", "py.typed"} <= {p.name for p in (place / "lamella").iterdir()}
    assert f"VERSION {told[1]} " in (SOURCE / "CMakeLists.txt").read_text()
