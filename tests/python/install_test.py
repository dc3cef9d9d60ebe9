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
    assert {"_core.pyi", "py.typed"} <= imported(place, tmp_path)
    assert f"VERSION {told[1]} " in (SOURCE / "CMakeLists.txt").read_text()


GRID_FILE = """
import lamella as lm
print(lm.simulate(lm.Stack.read("cloth.toml"), wi=[30], walks=1000).estimator)
"""


def imported(place, folder):
    """Where a copy of the package in `place` is imported from, by a Python that knows no other."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    told = subprocess.run(
        [sys.executable, "-c", "import lamella as lm; print(lm.__file__, len(lm.models()))"],
        cwd=folder, env={**environment, "PYTHONPATH": str(place)}, capture_output=True, text=True,
        check=True).stdout.split()
    assert Path(told[0]).is_relative_to(place) and int(told[1]) > 15
    names = {p.name for p in (place / "lamella").iterdir()}
    if (BUILD / "modules/lamella_openvdb.so").exists():
        assert "lamella_openvdb.so" in names
        reads_a_grid_file(place, folder, environment)
    return names


def reads_a_grid_file(place, folder, environment):
    """The package has its module of OpenVDB, and says so in one line where it has lost it."""
    made = subprocess.run([os.environ["LAMELLA"], "grid", "weave", "voxels=16", "-o", "cloth.vdb"],
                          cwd=folder, capture_output=True, text=True, check=True).stdout
    (folder / "cloth.toml").write_text(made)
    read = [sys.executable, "-c", GRID_FILE]
    environment = {**environment, "PYTHONPATH": str(place)}
    told = subprocess.run(read, cwd=folder, env=environment, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    module = place / "lamella/lamella_openvdb.so"
    module.rename(module.with_suffix(".away"))
    told = subprocess.run(read, cwd=folder, env=environment, capture_output=True, text=True)
    module.with_suffix(".away").rename(module)
    assert told.returncode == 1
    assert "the module for .vdb files cannot be loaded" in told.stderr.splitlines()[-1]


def test_cmake_installs_the_package(tmp_path):
    if shutil.which("cmake") is None:
        pytest.skip("no cmake")
    subprocess.run(["cmake", "--install", str(BUILD), "--prefix", str(tmp_path), "--component",
                    "python"], check=True, capture_output=True)
    [place] = tmp_path.glob("lib/python3*/dist-packages")
    # Nothing else belongs to it.
    assert [p.name for p in tmp_path.iterdir()] == ["lib"]
    assert {"_core.pyi", "py.typed"} <= imported(place, tmp_path)


@pytest.mark.skipif("LAMELLA_SOAK" not in os.environ, reason="compresses for half a minute: in the soak")
def test_cpack_makes_debian_packages(tmp_path):
    for program in "cpack", "dpkg-deb", "dpkg-shlibdeps":
        if shutil.which(program) is None:
            pytest.skip(f"no {program}")
    subprocess.run(["cpack", "-G", "DEB", "-B", str(tmp_path / "packages"), "-D",
                    "CPACK_COMPONENTS_ALL=program;python"], cwd=BUILD, check=True,
                   capture_output=True)
    packages = {p.name.split("_")[0]: p for p in (tmp_path / "packages").glob("*.deb")}
    assert set(packages) == {"lamella", "python3-lamella"}
    for name, package in packages.items():
        depends = subprocess.run(["dpkg-deb", "--field", str(package), "Depends"], check=True,
                                 capture_output=True, text=True).stdout
        assert "libtbb12" in depends and ("python3-numpy" in depends) == (name != "lamella")
        subprocess.run(["dpkg-deb", "--extract", str(package), str(tmp_path / name)], check=True)
    version = subprocess.run([str(tmp_path / "lamella/usr/bin/lamella"), "--version"], check=True,
                             capture_output=True, text=True).stdout
    assert f"VERSION {version.split()[-1]} " in (SOURCE / "CMakeLists.txt").read_text()
    assert list((tmp_path / "lamella").glob("usr/share/man/man1/lamella.1*"))
    [place] = (tmp_path / "python3-lamella").glob("usr/lib/python3*/dist-packages")
    imported(place, tmp_path)
