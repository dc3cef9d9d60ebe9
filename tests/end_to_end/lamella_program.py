"""Runs the binary that LAMELLA names, in a temporary folder per test."""

import json
import os
import pathlib
import resource
import signal
import subprocess
import tempfile
import time
import unittest

import jsonschema

PROGRAM = os.environ["LAMELLA"]
# Seconds for one command: of a run that hangs, in any build.
LIMIT = float(os.environ.get("LAMELLA_TEST_TIMEOUT", 200))
# What this build has of libraries that it can do without.
WITH_CAIRO = os.environ["LAMELLA_CAIRO"] == "ON"
WITH_CERES = os.environ["LAMELLA_CERES"] == "ON"
WITH_EMBREE = os.environ["LAMELLA_EMBREE"] == "ON"
WITH_PICTURES = os.environ["LAMELLA_PICTURES"] == "ON"
SCHEMAS = pathlib.Path(os.environ["LAMELLA_SCHEMA"])

# What may differ between equal runs.
TIMINGS = {"seconds", "ns_per_eval", "collisions_per_second_per_core"}


class Answer:
    def __init__(self, arguments, process, out, err):
        self.arguments, self.status, self.out, self.err = arguments, process.returncode, out, err

    def json(self):
        return json.loads(self.out)

    def __str__(self):
        return (f"lamella {' '.join(self.arguments)}\nstatus {self.status}\n"
                f"stdout: {self.out[:2000]}\nstderr: {self.err[:2000]}")


class ProgramTest(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="lamella-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, text):
        (self.folder / name).write_text(text)
        return name

    def run_program(self, *arguments, stdin=""):
        process = subprocess.run([PROGRAM, *arguments], input=stdin, capture_output=True, text=True,
                                 cwd=self.folder, timeout=LIMIT, check=False)
        return Answer(arguments, process, process.stdout, process.stderr)

    def limited(self, size, *arguments):
        """A run that can write files of that size only: a full disk, a short write."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        process = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, cwd=self.folder,
                                 timeout=LIMIT, check=False, preexec_fn=limit)
        return Answer(arguments, process, process.stdout, process.stderr)

    def lamella(self, *arguments, stdin="", status=0):
        """The answer of a run that ends with that status."""
        answer = self.run_program(*arguments, stdin=stdin)
        self.assertEqual(answer.status, status, str(answer))
        return answer

    def json_of(self, *arguments, stdin="", status=0):
        """The JSON of a command that writes it to stdout, held against its schema."""
        answer = self.lamella(*arguments, "--json", "-", stdin=stdin, status=status)
        parsed = answer.json()
        check_schema(arguments[0], parsed)
        return parsed

    def interrupted(self, *arguments, seconds=0.3, limit=30):
        """A run that gets Ctrl-C some time after it began to listen to it."""
        with subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, cwd=self.folder) as process:
            try:
                wait_until_listening(process)
                time.sleep(seconds)
                process.send_signal(signal.SIGINT)
                start = time.monotonic()
                out, err = process.communicate(timeout=limit)
            except BaseException:
                process.kill()
                raise
            return Answer(arguments, process, out, err), time.monotonic() - start


def wait_until_listening(process):
    """Waits until the process has a handler of SIGINT."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
        if int(caught.split()[1], 16) & (1 << (signal.SIGINT - 1)):
            return
        if process.poll() is not None:
            break
        time.sleep(0.01)
    raise AssertionError("the program never listened to Ctrl-C")


def schema_of(name):
    return json.loads((SCHEMAS / f"{name}.json").read_text())


def check_schema(command, answer):
    schema = schema_of(command)
    store = {path.name: json.loads(path.read_text()) for path in SCHEMAS.glob("*.json")}
    resolver = jsonschema.RefResolver(schema["$id"], schema, store=store)
    jsonschema.Draft202012Validator(schema, resolver=resolver).validate(answer)


def without(value, names):
    """The same JSON without the members of those names, at any depth."""
    if isinstance(value, dict):
        return {k: without(v, names) for k, v in value.items() if k not in names}
    if isinstance(value, list):
        return [without(v, names) for v in value]
    return value
