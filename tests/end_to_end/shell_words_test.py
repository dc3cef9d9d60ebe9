import os
import pathlib
import shutil
import subprocess
import unittest

from lamella_program import PROGRAM, ProgramTest

COMPLETE = """
source <(lamella completion bash)
COMP_WORDS=({words} '')
COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
COMP_WORDS[COMP_CWORD]='{begun}'
compopt() {{ :; }}
_lamella
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


class ShellsAreToldTheWords(ProgramTest):
    def shell(self, shell, script):
        path = f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"
        process = subprocess.run([*shell, script], capture_output=True, text=True, cwd=self.folder,
                                 timeout=60, check=False, env={**os.environ, "PATH": path})
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        return process.stdout.split()

    def completed(self, words, begun):
        return self.shell(["bash", "--norc", "-c"], COMPLETE.format(words=words, begun=begun))

    def test_bash_completes_commands_options_stacks_models_and_files(self):
        self.write("mine.toml", "")
        commands = self.completed("lamella", "")
        for command in ("compare", "sweep", "completion", "--version"):
            self.assertIn(command, commands)
        self.assertEqual(self.completed("lamella", "fur"), ["furnace"])
        self.assertEqual(self.completed("lamella compare", "--mod"), ["--model"])
        self.assertIn("vmf_sand", self.completed("lamella compare", "vmf_s"))
        self.assertEqual(self.completed("lamella explain", "mine"), ["mine.toml"])
        self.assertIn("eon_approx", self.completed("lamella compare --model", "eon"))
        self.assertEqual(self.completed("lamella simulate --estimator", "next"), ["next-event"])
        self.assertEqual(self.completed("lamella completion", ""), ["bash", "zsh"])

    @unittest.skipUnless(shutil.which("zsh"), "no zsh here")
    def test_zsh_takes_the_script(self):
        self.shell(["zsh", "-f", "-c"], "autoload -Uz compinit && compinit -u -d dump && "
                   "source <(lamella completion zsh) && [[ $_comps[lamella] == _lamella ]]")

    def test_the_manual_page_names_every_command_and_option(self):
        page = self.lamella("man").out
        self.assertTrue(page.startswith(".TH LAMELLA 1"))
        overview = self.lamella("--help").out.split("Subcommands:")[1]
        for line in overview.splitlines():
            if line.startswith("  ") and not line.startswith("   "):
                command = line.split()[0]
                self.assertIn(f".SS lamella {command}\n", page)
                for word in self.lamella(command, "--help").out.replace(",", " ").split():
                    if word.startswith("--") and word.rstrip(".") not in ("--help", "--"):
                        self.assertIn(word.split("=")[0].replace("-", "\\-"), page)
        if shutil.which("mandoc"):
            path = self.folder / "lamella.1"
            path.write_text(page)
            process = subprocess.run(["mandoc", "-T", "lint", "-W", "error", str(path)], capture_output=True,
                                     text=True, check=False)
            self.assertEqual((process.returncode, process.stdout), (0, ""))

    def test_another_shell_is_refused(self):
        self.assertIn("bash, zsh", self.lamella("completion", "fish", status=2).err)
