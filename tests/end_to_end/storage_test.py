"""Full disks, folders that take no files, two runs in one place: commands that keep results."""

import hashlib
import json
import pathlib
import subprocess
import time

from lamella_program import PROGRAM, ProgramTest

FEW = ["--walks", "2000", "--wi", "60", "--quiet"]
# By name: the command, and what its -o or folder is called.
COMMANDS = {
    "simulate": ["simulate", "sggx_slab", *FEW, "-o", "kept.exr"],
    "compare": ["compare", "sggx_slab", *FEW, "--model", "lambert,albedo=0.3", "-o", "kept"],
    "sweep": ["sweep", "sggx_slab", "--set", "layer.0.albedo=0.2:0.8:3", *FEW, "-o", "kept"],
    "samples": ["samples", "sggx_slab", *FEW, "-o", "kept.npz"],
    "data set": ["samples", "sggx_slab", "--per-bsdf", "--set", "layer.0.albedo=0.2:0.8:3", *FEW, "-o", "kept"],
    "part": ["simulate", "sggx_slab", *FEW, "--shard", "1/2", "-o", "kept.part"],
    "library": ["library", "build", "kept", "--only", "coat_over_dark,isotropic_halfspace", "--quiet"],
    "preview": ["preview", "lambert_sphere_halfspace", "--size", "16", "--model", "lambert", "--quiet", "-o", "kept"],
    "export": ["export", "eon,albedo=0.5", "--to", "mitsuba", "--quiet", "-o", "kept.bsdf"],
}
# Those whose folder one run has to itself.
OWNED = {
    "sweep": ["sweep", "hg_slab", "--set", "layer.0.albedo=0.2:0.8:3", "--walks", "1e9", "--wi", "60", "--quiet", "-o",
              "kept"],
    "compare": ["compare", "hg_slab", "--walks", "1e9", "--wi", "60", "--quiet", "-o", "kept"],
    "data set": ["samples", "hg_slab", "--per-bsdf", "--set", "layer.0.albedo=0.2:0.8:3", "--lobes", "--walks", "1e9",
                 "--wi", "60", "--quiet", "-o", "kept"],
    "library": ["library", "build", "kept", "--only", "narrow_flakes", "--time", "1000", "--quiet"],
}


def contents(place):
    """The files at a place by name: a hash where no clock is told in them, else None."""
    files = sorted(path for path in place.rglob("*") if path.is_file()) if place.is_dir() else [place]
    return {str(path.relative_to(place.parent)): None if path.suffix in (".json", ".jsonl", ".html", ".txt", ".part")
            else hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


class Storage(ProgramTest):
    def clear(self):
        for path in sorted(self.folder.rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()

    def test_a_full_disk_is_named_and_the_same_command_goes_on(self):
        for name, command in COMMANDS.items():
            with self.subTest(name):
                self.clear()
                self.lamella(*command)
                [place] = [path for path in self.folder.iterdir() if path.name.startswith("kept")]
                whole = contents(place)
                self.assertTrue(whole)
                self.clear()
                for size in (0, 1000):
                    answer = self.limited(size, *command)
                    self.assertEqual(answer.status, 2, str(answer))
                    self.assertRegex(answer.err, "^lamella: cannot write [^ ]*kept[^ ]*: File too large\n$")
                    left = [str(path) for path in self.folder.rglob("*") if path.name.startswith(".lamella-")]
                    self.assertEqual(left, [])
                    # What is there under its name is whole.
                    for path in self.folder.rglob("*.json"):
                        json.loads(path.read_text())
                self.lamella(*command)
                self.assertEqual(contents(place), whole)

    def test_a_folder_that_takes_no_files_is_named(self):
        for name, command in COMMANDS.items():
            with self.subTest(name):
                place = "/proc/" + next(word for word in command if word.startswith("kept"))
                answer = self.lamella(*(place if word.startswith("kept") else word for word in command), status=2)
                self.assertRegex(answer.err, "^lamella: cannot (write|make folder) /proc/[^\n]*\n$")

    def test_a_second_run_is_refused_and_a_killed_one_stops_nobody(self):
        for name, command in OWNED.items():
            with self.subTest(name):
                self.clear()
                with subprocess.Popen([PROGRAM, *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                      cwd=self.folder) as process:
                    try:
                        self.wait_for_lock()
                        answer = self.lamella(*command, status=2)
                        self.assertIn(f"pid {process.pid} on host", answer.err)
                        self.assertEqual(answer.err.count("\n"), 1)
                    finally:
                        process.kill()
                # The lock's file is still there, and nobody's.
                self.assertTrue(self.locks())
                quick = [*COMMANDS[name][:-1], "kept"] if name != "library" else COMMANDS[name]
                if name == "sweep" or name == "data set":
                    # Another run in the folder of one that began: its settings are compared.
                    self.assertIn("found another", self.lamella(*quick, status=2).err)
                else:
                    self.lamella(*quick)
                    self.assertEqual(self.locks(), [])

    def locks(self):
        return [path for path in pathlib.Path(self.folder).rglob("*lamella-lock") if path.is_file()]

    def wait_for_lock(self):
        deadline = time.monotonic() + 60
        while not [path for path in self.locks() if path.read_text()]:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
