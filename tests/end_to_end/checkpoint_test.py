"""Runs that are killed, or cannot write, and go on: the same bytes as a run that nothing ended."""

import os
import pathlib
import random
import signal
import subprocess
import time

from lamella_program import PROGRAM, Answer, ProgramTest, wait_until_listening

def run_of(walks):
    return ["simulate", "spongecake_plant", "--grid", "4x8", "--wi", "10", "--wi", "60", "--walks", walks,
            "--estimator", "next-event", "--threads", "1", "--quiet"]


# Some 1.5 seconds.
RUN = run_of("300000")
OFTEN = ["--checkpoint", "a.checkpoint", "--checkpoint-every", "0.02"]
KILLS = 100 if "LAMELLA_SOAK" in os.environ else 20


class ARunGoesOn(ProgramTest):
    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def killed(self, *arguments, seconds):
        """Whether the run was killed before its end."""
        with subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              cwd=self.folder) as process:
            try:
                process.wait(seconds)
            except subprocess.TimeoutExpired:
                process.kill()
            out, err = process.communicate()
            if process.returncode not in (0, -signal.SIGKILL):
                self.fail(str(Answer(arguments, process, out, err)))
            return process.returncode != 0

    def left_over(self):
        """Temporary names that nobody will rename, and locks that nobody holds."""
        for path in self.folder.iterdir():
            if path.name.startswith(".lamella-"):
                path.unlink()

    def test_after_kills_at_random_moments(self):
        start = time.monotonic()
        self.lamella(*RUN, "-o", "whole.exr")
        whole = time.monotonic() - start
        draw = random.Random(3)
        kills, ends = 0, 0
        while kills < KILLS:
            if self.killed(*RUN, *OFTEN, "-o", "out.exr", seconds=draw.uniform(0.01, whole / 6)):
                kills += 1
                self.left_over()
            else:
                ends += 1
                self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("out.exr"))
                self.assertFalse((self.folder / "a.checkpoint").exists())
                (self.folder / "out.exr").unlink()
        self.lamella(*RUN, *OFTEN, "-o", "out.exr")
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("out.exr"))

    def interrupted_once(self, *arguments):
        answer, _ = self.interrupted(*arguments, seconds=0.3)
        self.assertTrue((self.folder / "a.checkpoint").exists(), str(answer))
        return answer

    def test_after_ctrl_c_on_other_threads_and_tells_so(self):
        run = [word for word in RUN if word != "--quiet"]
        self.lamella(*run, "-o", "whole.exr")
        answer = self.interrupted_once(*run, *OFTEN, "-o", "out.exr")
        self.assertIn("the same command goes on from a.checkpoint", answer.err)
        answer = self.lamella(*("7" if word == "1" else word for word in run), *OFTEN, "-o", "out.exr")
        self.assertIn("goes on from a.checkpoint", answer.err)
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("out.exr"))
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["out.exr", "whole.exr"])

    def test_of_a_part(self):
        # Half of a run is over soon.
        run = run_of("1500000")
        for k in (1, 2):
            self.lamella(*run, "--shard", f"{k}/2", "-o", f"{k}.part")
        shard = [*run, *OFTEN, "--shard", "2/2", "-o", "again.part"]
        answer = self.interrupted_once(*shard)
        self.assertEqual(answer.status, 2)
        self.assertFalse((self.folder / "again.part").exists())
        self.lamella(*shard)
        self.lamella("merge", "1.part", "2.part", "-o", "whole.exr", "--quiet")
        self.lamella("merge", "1.part", "again.part", "-o", "out.exr", "--quiet")
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("out.exr"))

    def test_of_compare(self):
        run = ["compare", *RUN[1:], "--model", "lambert,albedo=0.3"]
        self.lamella(*run, "-o", "whole")
        self.interrupted_once(*run, *OFTEN, "-o", "out")
        self.lamella(*run, *OFTEN, "-o", "out")
        for name in ("truth.exr", "lambert.exr"):
            self.assertEqual(self.bytes_of(f"whole/{name}"), self.bytes_of(f"out/{name}"))

    def test_of_a_part_of_a_sweep(self):
        run = ["sweep", "spongecake_plant", "--set", "layer.1.g=0.1:0.8:8", "--walks", "200000", "--wi", "60", "--grid",
               "2x4", "--model", "lambert,albedo=0.3", "--threads", "1"]
        shard = [*run, *OFTEN, "--shard", "1/2", "-o", "1.part"]
        # Killed once a point is done and lies in the checkpoint.
        with subprocess.Popen([PROGRAM, *shard], stdout=subprocess.PIPE, text=True, cwd=self.folder) as process:
            while not (self.folder / "a.checkpoint").exists() and process.poll() is None:
                time.sleep(0.002)
            process.kill()
            process.communicate()
        self.left_over()
        self.assertTrue((self.folder / "a.checkpoint").exists())
        self.assertIn("goes on from a.checkpoint: ", self.lamella(*shard).err)
        self.lamella(*run, "--shard", "2/2", "-o", "2.part", "--quiet")
        self.lamella("merge", "1.part", "2.part", "-o", "merged", "--quiet")
        self.assertEqual(len(list((self.folder / "merged/points").glob("*.json"))), 8)
        self.assertIn("goes on in its folder", self.lamella(*run, *OFTEN, "-o", "out", status=2).err)

    def test_with_the_solver(self):
        run = ["simulate", "sggx_slab", "--estimator", "deterministic", "--grid", "4x8", "--wi", "60", "--quiet"]
        self.lamella(*run, "-o", "whole.exr")
        self.lamella(*run, *OFTEN, "-o", "out.exr")
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("out.exr"))

    def test_another_run_is_refused(self):
        self.interrupted_once(*RUN, *OFTEN, "-o", "out.exr")
        for more, reason in ((["--seed", "2"], "seed is 1 instead of 2"), (["--shard", "1/2"], "part"),
                             (["--max-order", "50"], "max_order")):
            output = "out.part" if "--shard" in more else "out.exr"
            answer = self.lamella(*RUN, *OFTEN, *more, "-o", output, status=2)
            self.assertIn("another run", answer.err)
            self.assertIn(reason, answer.err)
        answer = self.lamella("merge", "a.checkpoint", "-o", "x.exr", status=2)
        self.assertIn("checkpoint of a run that did not end", answer.err)

    def test_a_damaged_checkpoint_is_named(self):
        self.interrupted_once(*RUN, *OFTEN, "-o", "out.exr")
        raw = self.bytes_of("a.checkpoint")
        for damaged in (raw[:len(raw) // 2], raw[:-1], b"", raw[:5000] + b"\xff" + raw[5001:]):
            (self.folder / "a.checkpoint").write_bytes(damaged)
            answer = self.lamella(*RUN, *OFTEN, "-o", "out.exr", status=2)
            self.assertEqual(answer.err.count("\n"), 1)
            self.assertIn("a.checkpoint", answer.err)


class WhatCannotBeWritten(ProgramTest):
    def test_a_full_disk_leaves_the_last_checkpoint_whole(self):
        self.lamella(*RUN, "-o", "whole.exr")
        self.interrupted(*RUN, *OFTEN, "-o", "out.exr", seconds=0.2)
        before = (self.folder / "a.checkpoint").read_bytes()
        # Neither checkpoint nor image fits.
        answer = self.limited(4096, *RUN, *OFTEN, "-o", "out.exr")
        self.assertEqual(answer.status, 2, str(answer))
        self.assertRegex(answer.err, "no checkpoint: cannot write [^ ]*a.checkpoint: File too large")
        self.assertRegex(answer.err.splitlines()[-1], "cannot write [^ ]*out.exr: File too large")
        self.assertEqual((self.folder / "a.checkpoint").read_bytes(), before)
        self.assertFalse([p.name for p in self.folder.iterdir() if p.name.endswith(".tmp")])
        self.lamella(*RUN, *OFTEN, "-o", "out.exr")
        self.assertEqual((self.folder / "whole.exr").read_bytes(), (self.folder / "out.exr").read_bytes())

    def test_a_part_is_whole_or_not_there(self):
        answer = self.limited(4096, *RUN, "--shard", "1/2", "-o", "a.part")
        self.assertEqual(answer.status, 2, str(answer))
        self.assertIn("cannot write a.part: File too large", answer.err)
        answer = self.limited(4096, *RUN, "--checkpoint", "a.checkpoint", "-o", "a.exr")
        self.assertEqual(answer.status, 2, str(answer))
        self.assertIn("cannot write a.exr: File too large", answer.err.splitlines()[-1])
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_folder_that_takes_no_files_is_told_before_the_work(self):
        for place in ("none/a.checkpoint", "/proc/a.checkpoint"):
            start = time.monotonic()
            answer = self.lamella(*run_of("1e9"), "--checkpoint", place, "-o", "out.exr", status=2)
            self.assertIn(f"cannot write {pathlib.Path(place).parent}/", answer.err)
            self.assertLess(time.monotonic() - start, 30)
        if os.geteuid() != 0:
            folder = self.folder / "closed"
            folder.mkdir(mode=0o500)
            answer = self.lamella(*RUN, "--checkpoint", "closed/a", "-o", "out.exr", status=2)
            self.assertIn("Permission denied", answer.err)

    def test_two_runs_at_one_file(self):
        long = run_of("1e9")
        for mine, other in ((["--checkpoint", "a.checkpoint", "-o", "b.exr"],
                             ["--checkpoint", "a.checkpoint", "-o", "c.exr"]),
                            (["--shard", "1/2", "-o", "a.part"], ["--shard", "2/2", "-o", "a.part"])):
            with subprocess.Popen([PROGRAM, *long, *mine], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                  cwd=self.folder) as process:
                try:
                    wait_until_listening(process)
                    self.wait_for_lock()
                    answer = self.lamella(*long, *other, status=2)
                    self.assertIn(f"pid {process.pid} on host", answer.err)
                    self.assertIn("works on this file", answer.err)
                finally:
                    process.kill()
            # What a killed run left behind stops nobody.
            self.lamella(*run_of("200"), *other)

    def wait_for_lock(self):
        deadline = time.monotonic() + 60
        while not [p for p in pathlib.Path(self.folder).iterdir() if p.name.endswith("lamella-lock") and p.read_text()]:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)

    def test_an_interval_needs_a_checkpoint(self):
        answer = self.lamella(*RUN, "--checkpoint-every", "1", status=2)
        self.assertIn("--checkpoint", answer.err)
