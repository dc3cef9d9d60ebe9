"""Builds the Python package: `pip install --no-build-isolation .`

The compiled part comes from the C++ build. LAMELLA_BUILD names its folder; without it build/release
is taken where it was configured with the Python package, so that nothing is compiled twice, else
build/python is configured, without tests. Ninja or make then does what is left to do.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent
PACKAGE = Path("compare/python/lamella")
SCRATCH = Path("build/package")


def cached(folder, name):
    """A value of a build folder's cache, or ""."""
    try:
        text = (folder / "CMakeCache.txt").read_text()
    except OSError:
        return ""
    found = re.search(rf"^{name}:[A-Z]*=(.*)$", text, re.MULTILINE)
    return found[1] if found else ""


def build_folder():
    named = os.environ.get("LAMELLA_BUILD")
    if named:
        return Path(named).resolve()
    release = ROOT / "build/release"
    if cached(release, "LAMELLA_PYTHON") not in ("", "OFF") \
            and cached(release, "CMAKE_HOME_DIRECTORY") == str(ROOT):
        return release
    return ROOT / "build/python"


class BuildByCMake(build_ext):
    def build_extension(self, extension):
        folder = build_folder()
        if not (folder / "CMakeCache.txt").exists():
            options = ["-DCMAKE_BUILD_TYPE=Release", "-DLAMELLA_TESTS=OFF", "-DLAMELLA_PYTHON=ON",
                       "-DLAMELLA_PCH=ON", "-DLAMELLA_UNITY=ON"]
            if shutil.which("ninja"):
                options += ["-G", "Ninja"]
            subprocess.run(["cmake", "-S", str(ROOT), "-B", str(folder), *options], check=True)
        subprocess.run(["cmake", "--build", str(folder), "--parallel", "--target",
                        "lamella_python"], check=True)
        built = next((folder / "python/lamella").glob("_core*.so"))
        target = Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(built, target)
        for module in (folder / "python/lamella").glob("lamella_*.so"):
            shutil.copy2(module, target.parent)
        shutil.copy2(ROOT / "analytic/catalogue/lamella_model.h", target.parent)


# What setuptools leaves behind lies in build, too.
SCRATCH.mkdir(parents=True, exist_ok=True)
version = re.search(r"project\(lamella VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
setup(version=version,
      packages=["lamella"],
      package_dir={"lamella": str(PACKAGE)},
      package_data={"lamella": ["py.typed", "*.pyi"]},
      ext_modules=[Extension("lamella._core", [])],
      cmdclass={"build_ext": BuildByCMake},
      options={"build": {"build_base": str(SCRATCH)}, "egg_info": {"egg_base": str(SCRATCH)}},
      zip_safe=False)
