"""Several runs at once in one folder, and what killed ones leave behind."""

import json
import signal
import subprocess
import time

from lamella_program import PROGRAM, ProgramTest, check_schema, without, TIMINGS

SWEEP = ["sweep", "sggx_slab", "--set", "layer.0.roughness=0.2:0.8:3", "--walks", "2e4", "--grid", "2x4",
         "--wi", "60", "--estimator", "analog", "-o", "out"]


class RunsAtOnce(ProgramTest):
    def at_once(self, arguments, count=4):
        """Status and stderr of runs that are started together."""
        runs = [subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                 text=True, cwd=self.folder) for _ in range(count)]
        return [(run, run.communicate(timeout=200)[1]) for run in runs]

    def check_statuses(self, runs, folder):
        """One works; the others do nothing and say who does."""
        pids = {run.pid for run, _ in runs}
        self.assertIn(0, [run.returncode for run, _ in runs])
        for run, err in runs:
            with self.subTest(err):
                self.assertIn(run.returncode, (0, 2))
                if run.returncode == 2:
                    self.assertRegex(err, rf"^lamella: {folder}: another run, (pid \d+ on host \S+|which has "
                                          r"just begun), works in this folder; allowed: ")
                    self.assertEqual(err.count("\n"), 1)
                    if "pid" in err:
                        self.assertIn(int(err.split("pid ")[1].split()[0]), pids - {run.pid})
        self.assertEqual([path.name for path in (self.folder / folder).rglob(".*")], [])

    def test_sweeps(self):
        self.check_statuses(self.at_once(SWEEP), "out")
        report = json.loads((self.folder / "out/report.json").read_text())
        check_schema("sweep", report)
        self.assertEqual(len(report["points"]), 3)
        # The next one finds every point done.
        self.assertEqual(self.lamella(*SWEEP).out.count("(was there)"), 3)

    def test_compares_previews_and_reproductions(self):
        self.check_statuses(self.at_once(
            ["compare", "sggx_slab", "--walks", "1000", "--wi", "60", "--quiet", "-o", "compared"]), "compared")
        self.check_statuses(self.at_once(
            ["preview", "hg_slab", "--size", "16", "--model", "lambert", "--quiet", "-o", "seen"]), "seen")

    def test_files_of_their_own_in_one_folder(self):
        # Nobody owns the folder: each file is whole, whoever came last.
        for run, err in self.at_once(["simulate", "sggx_slab", "--walks", "1000", "--wi", "60", "--quiet", "-o",
                                      "one.exr", "--json", "one.json"]):
            self.assertEqual((run.returncode, err), (0, ""))
        self.lamella("rerun", "one.exr")
        check_schema("simulate", json.loads((self.folder / "one.json").read_text()))

    def test_a_killed_run_stops_nobody(self):
        with subprocess.Popen([PROGRAM, *SWEEP, "--seed", "1"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, cwd=self.folder) as run:
            deadline = time.monotonic() + 60
            while not (self.folder / "out/.lamella-lock").exists() and time.monotonic() < deadline:
                time.sleep(0.01)
            run.send_signal(signal.SIGKILL)
        self.lamella(*SWEEP)
        whole = json.loads((self.folder / "out/report.json").read_text())
        self.lamella(*[*SWEEP[:-1], "other"])
        other = json.loads((self.folder / "other/report.json").read_text())
        self.assertEqual(without(whole, TIMINGS), without(other, TIMINGS))
        self.assertFalse((self.folder / "out/.lamella-lock").exists())
