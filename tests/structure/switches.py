"""switches.py SOURCE CXX: a build without the libraries that have switches needs none of them.

Configures the core build of the README in a temporary folder, holds what would be compiled and
linked against the names of those libraries, and compiles what stands in the place of their sources.
That all of it links is what a whole build shows (CONTRIBUTING.md).
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

SWITCHES = {"OPENVDB": r"openvdb/", "EMBREE": r"embree\d?/", "CERES": r"ceres/", "CAIRO": r"cairo[\w-]*\.h",
            "PICTURES": r"(png|jpeglib)\.h", "PYTHON": r"pybind11/", "MPI": r"mpi\.h"}
LINKED = r"openvdb|embree|ceres|cairo|python3|libmpi|libpng|libjpeg"


def configured(source, compiler, folder):
    """Every command of the compiler by its source."""
    done = subprocess.run(["cmake", "-S", str(source), "-B", str(folder), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                           f"-DCMAKE_CXX_COMPILER={compiler}", "-DLAMELLA_TESTS=OFF", "-DLAMELLA_ISAS=avx2",
                           *(f"-DLAMELLA_{switch}=OFF" for switch in SWITCHES)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    return {pathlib.Path(entry["file"]): entry for entry in json.loads((folder / "compile_commands.json").read_text())}


def reached(source, files):
    """The sources and the headers of the project that they include."""
    seen, left = set(), [path for path in files]
    while left:
        path = left.pop()
        if path in seen or not path.exists():
            continue
        seen.add(path)
        for name in re.findall(r'#include "([^"]+)"', path.read_text()):
            left.append(source / name)
    return seen


def main(source, compiler):
    source = pathlib.Path(source).resolve()
    wrong = []
    with tempfile.TemporaryDirectory(prefix="lamella-core-") as name:
        folder = pathlib.Path(name)
        commands = configured(source, compiler, folder)
        for path in sorted(reached(source, commands)):
            text = path.read_text()
            for switch, header in SWITCHES.items():
                if re.search(rf'#include [<"]{header}', text):
                    wrong.append(f"{path.relative_to(source)}: includes a header of {switch}, which is off")
        for line in (folder / "build.ninja").read_text().splitlines():
            if line.strip().startswith("LINK_LIBRARIES") and re.search(LINKED, line):
                wrong.append(f"links {line.strip()[:200]}")
        absent = sorted(path for path in commands if path.stem.endswith("_absent"))
        if len(absent) < 4:
            wrong.append(f"found {len(absent)} sources that stand in the place of others; expected 4 and more")
        for path in absent:
            entry = commands[path]
            command = re.sub(r" -o \S+", " -fsyntax-only", entry["command"]).replace(" -c ", " ")
            done = subprocess.run(command, shell=True, cwd=entry["directory"], capture_output=True, text=True)
            if done.returncode:
                wrong.append(f"{path.relative_to(source)}: {done.stderr}")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(commands)} sources, {len(absent)} of them in the place of others")


if __name__ == "__main__":
    main(*sys.argv[1:])
