import os
import pathlib
import subprocess

from lamella_program import LIMIT, PROGRAM, WITH_CERES, WITH_EMBREE, ProgramTest

COMMANDS = ["", "simulate", "compare", "furnace", "samplers", "check", "fit", "invert", "eval", "tabulate", "bench", "sweep", "samples",
            "preview", "show", "rerun", "completion", "man", "explain", "models", "media", "stacks",
            "grid", "export", "import", "merge", "library", "scaling", "soak", "homogenise", "measure", "reproduce", "accuracy",
            "dataset"]


class ExamplesOfHelpWorkAsPrinted(ProgramTest):
    def test_through_the_shell(self):
        path = f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"
        for command in COMMANDS:
            if command == "grid" and os.environ["LAMELLA_OPENVDB"] != "ON":
                continue
            if command == "fit" and not WITH_CERES or command in ("measure", "reproduce") and not WITH_EMBREE:
                continue
            with self.subTest(command):
                text = self.lamella(*command.split(), "--help").out
                examples = [line.removeprefix("Example: ") for line in text.splitlines()
                            if line.startswith("Example: ")]
                self.assertEqual(len(examples), 1)
                process = subprocess.run(["sh", "-ec", examples[0]], capture_output=True, text=True,
                                         cwd=self.folder, timeout=LIMIT, check=False,
                                         env={**os.environ, "PATH": path})
                self.assertEqual(process.returncode, 0, examples[0] + process.stderr)
                self.assertNotEqual(process.stdout, "")
                self.assertIn("lamella " + command, examples[0])

    def test_the_list_of_commands_is_whole(self):
        overview = self.lamella("--help").out.split("Subcommands:")[1]
        names = [line.split()[0] for line in overview.splitlines() if line.startswith("  ")
                 and not line.startswith("   ")]
        self.assertEqual(sorted(names), sorted(COMMANDS[1:]))
