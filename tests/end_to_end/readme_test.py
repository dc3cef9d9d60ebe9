"""The examples of the root README: what they print must be what stands there."""

import os
import pathlib
import re
import subprocess
import unittest

from lamella_program import LIMIT, PROGRAM, ProgramTest

README = pathlib.Path(__file__).parents[2] / "README.md"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# A time differs from run to run.
TIME = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)? ?(ns|us|ms|s|seconds)\b")


def transcripts(text):
    """The indented blocks that begin with "$ ": [(command, [lines that it prints])]."""
    found = []
    for block in re.findall(r"(?:^    .*\n|^\n(?=    ))+", text, re.MULTILINE):
        for line in block.splitlines():
            line = line[4:]
            if line.startswith("$ "):
                found.append((line[2:], []))
            elif found and line and block.lstrip().startswith("$ "):
                found[-1][1].append(line.rstrip())
    return found


def differs(printed, quoted):
    """Whether a printed line is not the quoted one; numbers may differ by one in the last quoted
    digit, times by anything."""
    printed, quoted = (TIME.sub("TIME", line.rstrip()) for line in (printed, quoted))
    if re.sub(r" +", " ", NUMBER.sub("#", printed)) != re.sub(r" +", " ", NUMBER.sub("#", quoted)):
        return True
    for a, b in zip(NUMBER.findall(printed), NUMBER.findall(quoted)):
        mantissa, _, exponent = b.partition("e")
        decimals = len(mantissa.partition(".")[2])
        unit = 10.0 ** (-decimals + int(exponent or 0))
        if abs(float(a) - float(b)) > 1.01 * unit:
            return True
    return False


class ReadmeExamplesPrintWhatStandsThere(ProgramTest):
    def test_transcripts(self):
        path = f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"
        found = transcripts(README.read_text())
        self.assertGreaterEqual(len(found), 3)
        for command, quoted in found:
            with self.subTest(command):
                process = subprocess.run(["sh", "-ec", command], capture_output=True, text=True,
                                         cwd=self.folder, timeout=LIMIT, check=False,
                                         env={**os.environ, "PATH": path})
                self.assertEqual(process.returncode, 0, process.stderr)
                lines = [line for line in process.stdout.splitlines() if line.strip()]
                at = 0
                for line in quoted:
                    if line == "...":  # any number of lines
                        at = None
                        continue
                    where = range(at, at + 1) if at is not None else range(len(lines))
                    hit = next((k for k in where if k < len(lines) and not differs(lines[k], line)),
                               None)
                    self.assertIsNotNone(hit, f"README says:\n{line}\nprinted:\n{process.stdout}")
                    at = hit + 1

    def test_the_comparison_of_lines_sees_a_digit(self):
        self.assertFalse(differs("energy 0.28846 (190 ns)", "energy  0.28845 (20 ns)"))
        self.assertTrue(differs("energy 0.28846", "energy 0.28842"))
        self.assertTrue(differs("energy 0.28846 agrees", "energy 0.28846 differs"))
        self.assertFalse(differs("1.3e-188", "1.4e-188"))
        self.assertTrue(differs("1.3e-188", "1.3e-187"))


if __name__ == "__main__":
    unittest.main()
