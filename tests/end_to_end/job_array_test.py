"""Job scripts of compare/MACHINES.md by variables of schedulers, and by Slurm where it is there."""

import os
import pathlib
import re
import shutil
import socket
import subprocess
import time
import unittest

from lamella_program import LIMIT, PROGRAM, SCHEMAS, ProgramTest

TASKS = 3
GUIDE = (SCHEMAS.parent / "MACHINES.md").read_text()
WHOLE = ["simulate", "vmf_sand", "--wi", "45", "--walks", "1000", "--quiet", "-o", "whole.exr"]
SLURM = ("munged", "slurmctld", "slurmd", "sbatch")


def shortened(script):
    """A script of the guide with few tasks and walks, on whatever set and cores the machine has."""
    script = re.sub(r"\b16\b", str(TASKS), script).replace("1e10", "1000").replace(" --isa avx2", "")
    return re.sub(r"cpus-per-task=8|ncpus=8|smp 8", lambda m: m[0].replace("8", "1"), script)


def script_of(scheduler):
    """The code below the line that begins with the scheduler's name."""
    block = re.search(rf"\n{scheduler} \(.*?:\n\n((?:    .*\n|\n)+)", GUIDE)[1]
    return shortened(re.sub(r"^    ", "", block, flags=re.M))


class JobArray(ProgramTest):
    def merged_is_whole(self):
        self.lamella(*WHOLE)
        parts = sorted(path.name for path in self.folder.glob("sand-*.part"))
        self.assertEqual(len(parts), TASKS)
        self.lamella("merge", *parts, "-o", "sand.exr", "--quiet")
        self.assertEqual((self.folder / "whole.exr").read_bytes(), (self.folder / "sand.exr").read_bytes())

    def environment(self, **variables):
        return {**os.environ, "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}", **variables}


class ByVariables(JobArray):
    def run_tasks(self, script, variables_of):
        for task in range(1, TASKS + 1):
            process = subprocess.run(["bash", "-ec", script], cwd=self.folder, capture_output=True, text=True,
                                     timeout=LIMIT, check=False,
                                     env=self.environment(**{k: str(v) for k, v in variables_of(task).items()}))
            self.assertEqual(process.returncode, 0, process.stderr)
        self.merged_is_whole()

    def test_of_slurm_by_its_variables(self):
        self.run_tasks(script_of("Slurm"), lambda task: {
            "SLURM_ARRAY_TASK_ID": task, "SLURM_ARRAY_TASK_MIN": 1, "SLURM_ARRAY_TASK_MAX": TASKS,
            "SLURM_ARRAY_TASK_STEP": 1, "SLURM_ARRAY_TASK_COUNT": TASKS, "SLURM_CPUS_PER_TASK": 1})

    def test_of_pbs_by_its_variables(self):
        self.run_tasks(script_of("PBS"), lambda task: {"PBS_ARRAY_INDEX": task, "PBS_O_WORKDIR": self.folder})

    def test_of_grid_engine_by_its_variables(self):
        self.run_tasks(script_of("Grid Engine"), lambda task: {
            "SGE_TASK_ID": task, "SGE_TASK_FIRST": 1, "SGE_TASK_LAST": TASKS, "SGE_TASK_STEPSIZE": 1, "NSLOTS": 1})

    def test_of_kubernetes_by_its_variable(self):
        args = script_of("Kubernetes").split("args:\n")[1].replace("- lamella", "lamella").replace("\n", " ")
        self.run_tasks(args, lambda task: {"JOB_COMPLETION_INDEX": task - 1})

    def test_variables_that_contradict_are_named(self):
        for variables, parts in (({}, ["no task of a job array"]),
                                 ({"SLURM_ARRAY_TASK_ID": "3", "SLURM_ARRAY_TASK_MIN": "1", "SLURM_ARRAY_TASK_MAX": "9",
                                   "SLURM_ARRAY_TASK_COUNT": "2"}, ["SLURM_ARRAY_TASK_COUNT = 2", "are 9"]),
                                 ({"PBS_ARRAY_INDEX": "1"}, ["PBS", "auto/N"])):
            process = subprocess.run([PROGRAM, *WHOLE[:-1], "a.part", "--shard", "auto"], cwd=self.folder,
                                     capture_output=True, text=True, timeout=LIMIT, check=False,
                                     env=self.environment(**variables))
            self.assertEqual(process.returncode, 2)
            self.assertEqual(process.stderr.count("\n"), 1)
            for part in parts:
                self.assertIn(part, process.stderr)


@unittest.skipUnless(all(shutil.which(name) for name in SLURM) and os.geteuid() == 0,
                     "no Slurm: it takes the Debian packages slurm-wlm and munge, and root")
class SlurmOnThisMachine(JobArray):
    """munged, slurmctld and slurmd with all of their files in the test's folder."""

    def setUp(self):
        super().setUp()
        (self.folder / "slurm").mkdir()
        self.daemons = []
        self.addCleanup(self.end_daemons)

    def end_daemons(self):
        for process in reversed(self.daemons):
            process.terminate()
        for process in self.daemons:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()

    def start(self, *arguments, **variables):
        with open(self.folder / f"slurm/{arguments[0]}.out", "w", encoding="ascii") as out:
            self.daemons.append(subprocess.Popen(arguments, stdout=out, stderr=out, env=self.environment(**variables)))

    def test_runs_the_script_of_the_guide(self):
        folder, host = self.folder / "slurm", socket.gethostname().split(".")[0]
        (folder / "munge.key").write_bytes(os.urandom(128))
        (folder / "munge.key").chmod(0o600)
        ports = []
        for _ in range(2):
            with socket.socket() as s:
                s.bind(("127.0.0.1", 0))
                ports.append(s.getsockname()[1])
        (folder / "slurm.conf").write_text(f"""
ClusterName=lamella
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
ReturnToService=2
SelectType=select/cons_tres
StateSaveLocation={folder}
SlurmdSpoolDir={folder}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        configuration = {"SLURM_CONF": str(folder / "slurm.conf")}
        self.start("munged", "--foreground", "--force", f"--key-file={folder}/munge.key",
                   f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
                   f"--log-file={folder}/munged.log", f"--seed-file={folder}/munged.seed")
        deadline = time.monotonic() + 20
        while not (folder / "munge.socket").exists():
            self.assertLess(time.monotonic(), deadline, (folder / "munged.out").read_text())
            time.sleep(0.1)
        self.start("slurmctld", "-D", **configuration)
        self.start("slurmd", "-D", **configuration)
        (self.folder / "job.sh").write_text(script_of("Slurm"))
        process = subprocess.run(["sbatch", "--wait", "job.sh"], cwd=self.folder, capture_output=True, text=True,
                                 timeout=90, check=False, env=self.environment(**configuration))
        said = process.stdout + process.stderr
        for path in (*sorted(self.folder.glob("slurm-*.out")), folder / "slurmctld.out", folder / "slurmd.out"):
            said += f"\n{path.name}: {path.read_text()[-2000:]}"
        self.assertEqual(process.returncode, 0, said)
        self.merged_is_whole()

