"""Runs that mpirun shares: the bytes of one process, and what is left where a rank dies."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from lamella_program import LIMIT, PROGRAM, TIMINGS, ProgramTest, without

MPIRUN = shutil.which("mpirun")
WITH_MPI = os.environ["LAMELLA_MPI"] == "ON"
REASON = "this build has no MPI (-DLAMELLA_MPI=ON)" if not WITH_MPI else "mpirun is not installed (openmpi-bin)"
QUICK = ["--walks", "2000", "--wi", "60", "--wi", "10,30", "--grid", "2x4"]


def mpirun(ranks):
    return [MPIRUN, "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), PROGRAM]


@unittest.skipUnless(WITH_MPI and MPIRUN, REASON)
class Ranks(ProgramTest):
    def ranks(self, count, *arguments, status=0):
        process = subprocess.run([*mpirun(count), *arguments], capture_output=True, text=True, cwd=self.folder,
                                 timeout=LIMIT, check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(process.returncode, status, process.stdout + process.stderr)
        return process

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()


class TheBytesOfOneProcess(Ranks):
    def test_of_simulate_with_4_and_16_ranks(self):
        for stack, ranks, estimator in (("sggx_slab", 4, "analog"), ("coated_lambert", 16, "next-event")):
            with self.subTest(stack):
                arguments = ["simulate", stack, *QUICK, "--estimator", estimator, "--quiet"]
                self.lamella(*arguments, "-o", "one.exr")
                self.ranks(ranks, *arguments, "-o", "many.exr")
                self.assertEqual(self.bytes_of("one.exr"), self.bytes_of("many.exr"))

    def test_of_the_solver_tables_and_json(self):
        arguments = ["simulate", "sggx_slab", "--estimator", "deterministic", "--wi", "60", "--grid", "2x4"]
        one = self.json_of(*arguments)
        many = self.ranks(2, *arguments, "--json", "-")
        self.assertEqual(without(json.loads(many.stdout), TIMINGS | {"threads"}), without(one, TIMINGS | {"threads"}))
        self.assertIn("lamella: 2 ranks: ", many.stderr)

    def test_of_compare_and_eval(self):
        arguments = ["compare", "lambert_sphere_halfspace", *QUICK, "--model", "lambert,albedo=0.3", "--quiet"]
        self.lamella(*arguments, "-o", "one")
        self.ranks(3, *arguments, "-o", "many")
        for name in ("truth.exr", "lambert.exr"):
            self.assertEqual(self.bytes_of("one/" + name), self.bytes_of("many/" + name))
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n0.7,0,0.2,40\n0.9,0,0.95,10\n")
        arguments = ["eval", "truth", "stack=sggx_slab", "walks=2000", "--pairs", "pairs.csv"]
        self.assertEqual(self.lamella(*arguments).out, self.ranks(2, *arguments).stdout)

    def test_of_a_sweep_that_goes_on(self):
        arguments = ["sweep", "sggx_slab", "--set", "layer.0.albedo=0.1:0.9:5", "--walks", "500", "--wi", "60",
                     "--grid", "2x4", "--quiet"]
        self.lamella(*arguments, "-o", "one")
        self.ranks(4, *arguments, "-o", "many")
        self.ranks(2, *arguments, "-o", "many")
        for path in sorted((self.folder / "one").rglob("*.*")):
            name = str(path.relative_to(self.folder / "one"))
            if name.endswith(".json"):
                one, many = (json.loads(self.bytes_of(f"{folder}/{name}")) for folder in ("one", "many"))
                self.assertEqual(without(one, TIMINGS | {"threads"}), without(many, TIMINGS | {"threads"}), name)
            elif name.endswith(".toml"):
                self.assertEqual(path.read_bytes(), self.bytes_of("many/" + name))


class Errors(Ranks):
    def test_are_told_once(self):
        for arguments, part in ((["simulate", "nonsense", *QUICK], "nonsense"),
                                (["simulate", "sggx_slab"], "mpirun: found no number of walks"),
                                (["simulate", "-", *QUICK], "stdin, which it gives to one rank"),
                                (["simulate", "sggx_slab", *QUICK, "--shard", "1/2", "-o", "x.part"], "--shard"),
                                (["stacks"], "which ranks cannot share"),
                                (["eval", "lambert", "--pairs", "none.csv"], "none.csv")):
            with self.subTest(arguments):
                process = self.ranks(2, *arguments, status=2)
                self.assertEqual(process.stderr.count("lamella: "), 1, process.stderr)
                self.assertIn(part, process.stderr)
                self.assertEqual(process.stdout, "")


class ARankThatDies(Ranks):
    def test_ends_the_run_with_a_message_and_what_was_found_is_kept(self):
        arguments = ["simulate", "hg_slab", "--walks", "1e6", "--wi", "60", "--wi", "10", "--grid", "2x4", "--isa",
                     "scalar", "--quiet", "-o", "many.exr", "--checkpoint", "kept", "--checkpoint-every", "0.1"]
        with subprocess.Popen([*mpirun(3), *arguments], cwd=self.folder, stderr=subprocess.PIPE, text=True) as run:
            # Once every rank has a checkpoint; the last of them is killed.
            deadline = time.monotonic() + LIMIT
            names = [f"kept.{k}-of-3" for k in (1, 2, 3)]
            while not all((self.folder / name).exists() for name in names):
                self.assertIsNone(run.poll(), "the run ended before its checkpoints were seen")
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.01)
            os.kill(child_with(run.pid, "OMPI_COMM_WORLD_RANK=2"), signal.SIGKILL)
            _, told = run.communicate(timeout=LIMIT)
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("rank 2", told)
        self.assertFalse((self.folder / "many.exr").exists())
        answer = self.run_program("simulate", "hg_slab", "--walks", "1e6", "--checkpoint", "kept.1-of-3")
        self.assertIn("found the checkpoint of another run", answer.err)
        told = self.ranks(3, *(word for word in arguments if word != "--quiet")).stderr
        self.assertIn("goes on from kept.1-of-3", told)
        self.assertEqual([path.name for path in self.folder.glob("kept*")], [])
        self.lamella(*arguments[:arguments.index("-o")], "-o", "one.exr")
        self.assertEqual(self.bytes_of("one.exr"), self.bytes_of("many.exr"))


def child_with(parent, variable):
    """The process below another that has this in its environment."""
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            status = (folder / "stat").read_text()
            if int(status.rsplit(")", 1)[1].split()[1]) != parent:
                continue
            if variable.encode() in (folder / "environ").read_bytes().split(b"\0"):
                return int(folder.name)
        except (OSError, ValueError):
            continue
    raise AssertionError(f"no process below {parent} has {variable}")


@unittest.skipIf(WITH_MPI, "this build has MPI")
class WithoutMpi(ProgramTest):
    def test_several_processes_are_refused(self):
        process = subprocess.run([PROGRAM, "stacks"], env={**os.environ, "OMPI_COMM_WORLD_SIZE": "2"},
                                 capture_output=True, text=True, timeout=LIMIT, check=False)
        self.assertEqual(process.returncode, 2)
        self.assertIn("this build has no MPI", process.stderr)


class Scaling(ProgramTest):
    def test_counts_and_models(self):
        answer = self.json_of("scaling", "sggx_slab", "--wi", "60", "--wi", "30", "--walks", "1e9", "--grid", "2x4")
        counted = answer["counted"]
        self.assertEqual([row["ranks"] for row in counted], [1, 2, 4, 8, 16, 32, 64])
        self.assertEqual([row["messages"] for row in counted], [4 * (row["ranks"] - 1) for row in counted])
        self.assertEqual(counted[0]["bytes"], 0)
        # All sums but those of rank 0, and some 100 bytes for each of the others.
        self.assertAlmostEqual(counted[-1]["bytes"] / counted[1]["bytes"], (63 / 64) / (1 / 2), delta=0.1)
        model = {row["ranks"]: row for row in answer["model"]}
        self.assertEqual(model[1]["efficiency"], 1)
        self.assertGreater(model[64]["efficiency"], 0.9)
        # 2 directions of 128 batches keep 256 of 1000 ranks at work.
        self.assertLess(model[1000]["efficiency"], 0.256)
