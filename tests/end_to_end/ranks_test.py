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


class Samples(Ranks):
    def test_are_those_of_one_process(self):
        # Several pieces of a million walks, each direction's last one shorter.
        for arguments in (["samples", "sggx_slab", "--wi", "60", "--wi", "10", "--walks", "1200000"],
                          ["samples", "hg_slab", "--wi-distribution", "cosine", "--walks", "2100000"],
                          ["samples", "coated_lambert", "--wi", "60", "--walks", "2000"]):
            with self.subTest(arguments):
                self.lamella(*arguments, "-o", "one.npz", "--quiet")
                self.ranks(3, *arguments, "-o", "many.npz", "--quiet")
                self.assertEqual(self.bytes_of("one.npz"), self.bytes_of("many.npz"))

    def test_of_a_data_set_that_goes_on(self):
        arguments = ["samples", "sggx_slab", "--per-bsdf", "--set", "layer.0.albedo=0.1:0.9:5", "--walks", "2000",
                     "--wi", "60", "--quiet"]
        self.lamella(*arguments, "-o", "one")
        self.ranks(4, *arguments, "-o", "many")
        (self.folder / "many/0002.npz").unlink()
        self.ranks(2, *arguments, "-o", "many")
        index = {folder: json.loads(self.bytes_of(f"{folder}/index.json")) for folder in ("one", "many")}
        self.assertEqual(index["one"]["entries"], index["many"]["entries"])
        self.assertEqual(len(index["one"]["entries"]), 5)
        for entry in index["one"]["entries"]:
            self.assertEqual(self.bytes_of("one/" + entry["file"]), self.bytes_of("many/" + entry["file"]))
        self.assertIn("stdin", self.ranks(2, "samples", "-", "-o", "a.npz", status=2).stderr)

    def test_a_folder_that_ranks_do_not_share_is_refused(self):
        (self.folder / "other").mkdir()
        arguments = ["samples", "sggx_slab", "--per-bsdf", "--set", "layer.0.albedo=0.1:0.9:4", "--walks", "2000",
                     "--wi", "60", "--quiet", "-o", "set"]
        (self.folder / "other/set").mkdir()
        process = subprocess.run([*mpirun(1), *arguments, ":", "-n", "1", "-wdir", str(self.folder / "other"), PROGRAM,
                                  *arguments], capture_output=True, text=True, cwd=self.folder, timeout=LIMIT,
                                 check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(process.returncode, 2, process.stdout + process.stderr)
        self.assertIn("allowed: a folder that all processes share", process.stderr)

    def test_a_file_that_cannot_be_written_ends_all(self):
        process = self.ranks(2, "samples", "sggx_slab", "--walks", "2000", "-o", "none/a.npz", status=2)
        self.assertIn("cannot write none", process.stderr)
        self.assertEqual(process.stderr.count("lamella: "), 1, process.stderr)


class RanksThatDiffer(Ranks):
    """Rank 1 in another folder, or with another program: the line names what differs."""

    def two(self, first, second, *, program=PROGRAM, environment=()):
        """Two ranks, each with its arguments, the second in the folder other/."""
        (self.folder / "other").mkdir(exist_ok=True)
        words = [*mpirun(1), *first, ":", *environment, "-n", "1", "-wdir",
                 str(self.folder / "other"), program, *second]
        process = subprocess.run(words, capture_output=True, text=True, cwd=self.folder, timeout=LIMIT, check=False,
                                 stdin=subprocess.DEVNULL)
        return process

    def refused(self, part, *arguments, second=None, program=PROGRAM):
        process = self.two(arguments, second or arguments, program=program)
        self.assertEqual(process.returncode, 2, process.stdout + process.stderr)
        self.assertIn("rank 1: found another run than that of rank 0: " + part, process.stderr)
        self.assertEqual(process.stderr.count("lamella: "), 1, process.stderr)
        self.assertEqual(process.stdout, "")

    def write_both(self, name, one, other):
        self.write(name, one)
        (self.folder / "other").mkdir(exist_ok=True)
        self.write("other/" + name, other)

    def test_files_of_other_content(self):
        layer = '[[layer]]\nmedium = "henyey_greenstein"\nalbedo = {}\nthickness = 1\n'
        self.write_both("a.toml", layer.format(0.5), layer.format(0.6))
        self.refused("its stack differs", "simulate", "a.toml", *QUICK)
        self.refused("its stack differs", "sweep", "a.toml", "--set", "layer.0.g=0:0.5:2", *QUICK, "-o", "out")
        self.assertFalse((self.folder / "out").exists())
        pairs = "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,{}\n"
        self.write_both("pairs.csv", pairs.format(0), pairs.format(1))
        self.refused("its input differs", "eval", "truth", "stack=sggx_slab", "walks=2000", "--pairs", "pairs.csv")
        plugin = pathlib.Path(os.environ["LAMELLA_PLUGINS"], "minnaert.so").read_bytes()
        for folder, tail in (("", b""), ("other/", b"\0")):
            (self.folder / folder).mkdir(exist_ok=True)
            (self.folder / folder / "mine.so").write_bytes(plugin + tail)
        self.refused("its files differs", "sweep", "sggx_slab", "--set", "layer.0.albedo=0.5,0.6", *QUICK, "--model",
                     "./mine.so", "-o", "out")

    def test_another_command_or_program(self):
        run = ["simulate", "sggx_slab", *QUICK]
        self.refused("its seed is 2 instead of 1", *run, second=[*run, "--seed", "2"])
        self.refused('its command is "furnace" instead of "simulate"', *run,
                     second=["furnace", "sggx_slab", "--walks", "2000", "--wi", "60", "--wi", "10,30"])
        # Another build: a copy with a byte more, which runs the same.
        other = self.folder / "lamella"
        other.write_bytes(pathlib.Path(PROGRAM).read_bytes() + b"\0")
        other.chmod(0o755)
        self.refused("its program file differs", *run, program=str(other))

    def test_a_rank_without_the_file_tells_so(self):
        self.write("a.toml", '[[layer]]\nmedium = "henyey_greenstein"\nalbedo = 0.5\nthickness = 1\n')
        arguments = ["simulate", "a.toml", *QUICK]
        process = self.two(arguments, arguments)
        self.assertEqual(process.returncode, 2, process.stdout + process.stderr)
        self.assertRegex(process.stderr, "lamella: rank 1: a.toml: ")


class FurnacesAndTruths(Ranks):
    def test_are_those_of_one_process(self):
        furnace = ["furnace", "sggx_slab", "--walks", "4000", "--wi", "60", "--wi", "10", "--estimator", "analog"]
        one = self.json_of(*furnace)
        many = json.loads(self.ranks(3, *furnace, "--json", "-").stdout)
        self.assertEqual(without(many, TIMINGS | {"threads"}), without(one, TIMINGS | {"threads"}))
        # A furnace that fails ends with its status under ranks, too.
        failing = ["furnace", "coated_lambert", "--walks", "4000", "--wi", "60", "--estimator", "analog", "--quiet"]
        self.assertEqual(self.lamella(*failing, status=1).out, self.ranks(2, *failing, status=1).stdout)
        # More ranks than incident directions: some have nothing to do.
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n0.5,0,-0.8,0\n0.7,0,0.2,40\n")
        for more in (["walks=2000"], ["estimator=deterministic"]):
            arguments = ["eval", "truth", "stack=hg_slab", *more, "--pairs", "pairs.csv"]
            self.assertEqual(self.lamella(*arguments).out, self.ranks(5, *arguments).stdout)
            self.ranks(5, *arguments, "-o", "many.csv")
            self.lamella(*arguments, "-o", "one.csv")
            self.assertEqual(self.bytes_of("one.csv"), self.bytes_of("many.csv"))

    def test_go_on_from_checkpoints_of_ranks_that_were_killed(self):
        arguments = ["compare", "hg_slab", "--model", "lambert,albedo=0.3", "--walks", "1e6", "--wi", "60", "--grid",
                     "2x4", "--isa", "scalar", "--quiet", "-o", "many", "--checkpoint", "kept", "--checkpoint-every",
                     "0.1"]
        with subprocess.Popen([*mpirun(2), *arguments], cwd=self.folder, stderr=subprocess.PIPE, text=True) as run:
            deadline = time.monotonic() + LIMIT
            while not all((self.folder / f"kept.{k}-of-2").exists() for k in (1, 2)):
                self.assertIsNone(run.poll(), "the run ended before its checkpoints were seen")
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.01)
            os.kill(child_with(run.pid, "OMPI_COMM_WORLD_RANK=0"), signal.SIGKILL)
            run.communicate(timeout=LIMIT)
        self.assertNotEqual(run.returncode, 0)
        told = self.ranks(2, *(word for word in arguments if word != "--quiet")).stderr
        self.assertIn("goes on from kept.1-of-2", told)
        self.lamella(*arguments[:arguments.index("-o")], "-o", "one")
        for name in ("truth.exr", "lambert.exr"):
            self.assertEqual(self.bytes_of("one/" + name), self.bytes_of("many/" + name))


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
