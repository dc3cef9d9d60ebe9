"""The library of reference lobes: built, kept, verified, used by checks and by other programs."""

import hashlib
import json
import os
import pathlib
import re
import struct
import subprocess
import zipfile

from lamella_program import PROGRAM, ProgramTest, check_schema

PLUGINS = os.environ["LAMELLA_PLUGINS"]
DOCUMENT = pathlib.Path(__file__).parents[2] / "compare/LIBRARY.md"
QUICK = ["isotropic_halfspace", "coat_over_dark"]

# Of the lines of Python: a BSDF that is right for the isotropic half space.
RENDERER = """import io, subprocess
import numpy as np

SCALE = 1

def my_bsdf(wi, wo, stack):
    azimuth = lambda w: np.degrees(np.arctan2(w[:, 1], w[:, 0]))
    rows = np.column_stack([wi[:, 2], azimuth(wi), wo[:, 2], azimuth(wo)])
    pairs = io.StringIO()
    np.savetxt(pairs, rows, delimiter=",", header="mu_i,phi_i,mu_o,phi_o", comments="", fmt="%.17g")
    out = subprocess.run([PROGRAM, "eval", "chandrasekhar", "albedo=0.9", "--pairs", "-"], input=pairs.getvalue(),
                         capture_output=True, text=True, check=True).stdout
    return np.loadtxt(io.StringIO(out), delimiter=",", skiprows=1)[:, 4:] * SCALE
"""


def code_of(language):
    """The block of that language in the document."""
    text = DOCUMENT.read_text()
    return re.search(rf"```{language}\n(.*?)```", text, re.S)[1]


class Library(ProgramTest):
    def build(self, *names, status=0):
        return self.json_of("library", "build", "kept", "--only", ",".join(names or QUICK), "--quiet", status=status)

    def index(self):
        return json.loads((self.folder / "kept/index.json").read_text())

    def write_index(self, index):
        (self.folder / "kept/index.json").write_text(json.dumps(index))

    def changed_value(self, name, lobe, factor):
        """Scales the first values of a lobe, and makes archive and index agree with that."""
        path = self.folder / f"kept/{name}.npz"
        with zipfile.ZipFile(path) as archive:
            members = {member: archive.read(member) for member in archive.namelist()}
        data = bytearray(members[lobe + ".npy"])
        start = 10 + struct.unpack_from("<H", data, 8)[0]
        for k in range(16):
            value = struct.unpack_from("<d", data, start + 8 * k)[0]
            struct.pack_into("<d", data, start + 8 * k, value * factor)
        members[lobe + ".npy"] = bytes(data)
        with zipfile.ZipFile(path, "w") as archive:
            for member, content in members.items():
                archive.writestr(zipfile.ZipInfo(member), content)
        index = self.index()
        for entry in index["entries"]:
            for file in entry["files"]:
                if file["name"] == path.name:
                    file["bytes"] = path.stat().st_size
                    file["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        self.write_index(index)


class Build(Library):
    def test_goes_on_and_keeps_what_is_whole(self):
        self.assertEqual(self.build(QUICK[0])["found"], 1)
        answer = self.build()
        self.assertEqual((answer["found"], answer["kept"]), (1, 1))
        index = self.index()
        self.assertEqual([entry["name"] for entry in index["entries"]], ["coat_over_dark", "isotropic_halfspace"])
        for entry in index["entries"]:
            for part in ("lobes", "points"):
                self.assertEqual(entry[part]["method"], "adding-doubling")
                self.assertTrue(entry[part]["reached"] or entry[part]["bound"] < 1e-8, entry[part])
            for file in entry["files"]:
                path = self.folder / "kept" / file["name"]
                self.assertEqual(path.stat().st_size, file["bytes"])
                self.assertEqual(hashlib.sha256(path.read_bytes()).hexdigest(), file["sha256"])
        before = (self.folder / "kept/index.json").read_bytes()
        self.assertEqual(self.build()["kept"], 2)
        self.assertEqual((self.folder / "kept/index.json").read_bytes(), before)

    def test_finds_again_what_is_damaged_or_another_stack(self):
        self.build()
        path = self.folder / "kept/coat_over_dark.exr"
        whole = path.read_bytes()
        path.write_bytes(whole[:-1] + b"x")
        self.assertEqual(self.build()["found"], 1)
        self.assertEqual(path.read_bytes(), whole)
        index = self.index()
        index["entries"][1]["stack"] = index["entries"][1]["stack"].replace("0.9", "0.8")
        self.write_index(index)
        self.assertEqual(self.build()["found"], 1)
        (self.folder / "kept/coat_over_dark.csv").unlink()
        self.assertEqual(self.build()["found"], 1)

    def test_refuses_names_and_indices_that_are_none(self):
        answer = self.lamella("library", "build", "kept", "--only", "coat_over_darf", status=2)
        self.assertIn('did you mean "coat_over_dark"?', answer.err)
        (self.folder / "kept").mkdir(exist_ok=True)
        for text in ("{", "[]", '{"format": 2, "entries": []}', '{"format": 1, "entries": [{}]}',
                     '{"format": 1, "entries": [{"name": "../x"}]}'):
            self.write("kept/index.json", text)
            answer = self.lamella("library", "show", "kept", status=2)
            self.assertIn("kept/index.json", answer.err)
            self.assertIn("allowed: ", answer.err)
        self.lamella("library", "show", "none", status=2)
        self.lamella("library", "show", "kept", "--all", status=2)


class Verify(Library):
    def test_passes_by_the_solver_and_by_walks_and_finds_a_wrong_value(self):
        self.build()
        answer = self.json_of("library", "verify", "kept", "--quiet")
        self.assertEqual(answer["verdict"], "pass")
        self.assertEqual([line["verdict"] for line in answer["checks"]], ["pass", "pass"])
        walks = ["library", "verify", "kept", "--all", "--by-walks", "--walks", "1e5", "--quiet"]
        self.assertEqual(self.json_of(*walks)["verdict"], "pass")
        # More than the bounds of 1e-6 and less than walks see.
        self.changed_value("isotropic_halfspace", "reflect.all", 1 + 1e-4)
        answer = self.json_of("library", "verify", "kept", "--quiet", status=1)
        failed = [line for line in answer["checks"] if line["verdict"] == "fail"]
        self.assertEqual([line["name"] for line in failed], ["isotropic_halfspace"])
        self.assertIn("reflect all", failed[0]["worst"]["text"])
        self.assertEqual(self.json_of(*walks)["verdict"], "pass")
        self.changed_value("isotropic_halfspace", "reflect.all", 1.2)
        self.assertEqual(self.json_of(*walks, status=1)["verdict"], "fail")

    def test_names_files_that_are_not_those_of_the_index(self):
        self.build()
        (self.folder / "kept/coat_over_dark.npz").write_bytes(b"PK")
        (self.folder / "kept/isotropic_halfspace.csv").unlink()
        answer = self.json_of("library", "verify", "kept", "--quiet", status=1)
        self.assertEqual(answer["checks"], [])
        self.assertIn("coat_over_dark: coat_over_dark.npz: 2 bytes", answer["broken"][0])
        self.assertIn("isotropic_halfspace.csv", answer["broken"][1])


class Check(Library):
    def check(self, *words, status):
        answer = self.lamella("check", *words, "--quick", "--library", "kept", "--quiet", "--json", "-", status=status)
        parsed = answer.json()
        check_schema("check", parsed)
        return {line["name"]: line for line in parsed["checks"]}

    def test_runs_a_model_on_what_it_claims(self):
        self.build(*QUICK, "lambert_sphere_0.3")
        lines = self.check("chandrasekhar", status=0)
        # Its formula is exact: within the bounds of the cells.
        self.assertLess(lines["isotropic_halfspace"]["worst"]["found"], 1e-4)
        self.assertNotIn("coat_over_dark", lines)
        self.check("chandrasekhar", "--max-error", "1e-9", status=1)
        self.assertIn("claims", self.lamella("check", "chandrasekhar", "albedo=0.5", "--library", "kept",
                                             status=2).err)
        lines = self.check("lambert_sphere_three_term", "albedo=0.3", status=0)
        self.assertLess(lines["lambert_sphere_0.3"]["worst"]["found"], 2e-3)

    def test_runs_shared_objects_on_entries_that_are_named(self):
        self.build(QUICK[0])
        plugin = os.path.join(PLUGINS, "minnaert.so")
        self.assertIn("--entry", self.lamella("check", plugin, "--library", "kept", status=2).err)
        answer = self.run_program("check", plugin, "--quick", "--library", "kept", "--entry", QUICK[0], "--json", "-",
                                  "--quiet")
        self.assertIn(answer.status, (0, 1), str(answer))
        names = [line["name"] for line in answer.json()["checks"]]
        self.assertEqual(names[8:], [QUICK[0]])
        self.lamella("check", "lambert", "--library", "kept", "--entry", "none", status=2)


class OtherPrograms(Library):
    def test_the_lines_of_python_and_of_c_plus_plus(self):
        self.lamella("library", "build", "lamella-library", "--only", QUICK[0], "--quiet")
        self.write("my_renderer.py", RENDERER.replace("PROGRAM", repr(PROGRAM)))
        self.write("ci.py", code_of("python"))
        run = lambda *words: subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=False)
        good = run("/usr/bin/python3", "ci.py")
        self.assertEqual(good.returncode, 0, good.stderr)
        text = (self.folder / "my_renderer.py").read_text()
        self.write("my_renderer.py", text.replace("SCALE = 1", "SCALE = 1.1"))
        self.assertNotEqual(run("/usr/bin/python3", "ci.py").returncode, 0)
        lines = [line for line in code_of("python").splitlines() if line.strip()]
        self.assertLessEqual(len(lines), 10)
        self.assertLessEqual(len([line for line in code_of("cpp").splitlines() if line.strip()]), 12)
        self.write("ci.cpp", code_of("cpp"))
        # What is right at the points, and what is a tenth off.
        for scale, status in ((1, 0), (1.1, 1)):
            rows = (self.folder / "lamella-library/isotropic_halfspace.csv").read_text().splitlines()[1:]
            tests = "".join(f"  if (std::fabs(mi - {row[0]}) + std::fabs(mo - {row[2]}) < 1e-12) return {row[4]} * {scale};\n"
                            for row in (line.split(",") for line in rows))
            self.write("my_bsdf.h", "#include <cmath>\ninline double my_bsdf(double mi, double, double mo, double) {\n"
                       + tests + "  return 0;\n}\n")
            built = run("g++", "-std=c++17", "-Wall", "-Werror", "ci.cpp", "-o", "ci")
            self.assertEqual(built.returncode, 0, built.stderr)
            self.assertEqual(run("./ci").returncode, status)
