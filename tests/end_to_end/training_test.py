"""The guide to training SpongeCake's networks again (analytic/SPONGECAKE.md), at a tiny size."""

import hashlib
import json
import re
import shlex
import struct
import subprocess
import sys
import unittest
import zlib

from lamella_program import LIMIT, SCHEMAS, ProgramTest

ROOT = SCHEMAS.parents[1]
SCRIPT = ROOT / "analytic/spongecake_network/train.py"
# In the place of the guide's sizes.
DATA = {"--stacks": "60", "--directions": "2", "--walks": "512"}
STEPS = ["--steps", "6", "--checks", "2"]

HAS_TORCH = subprocess.run([sys.executable, "-c", "import torch"], capture_output=True, check=False).returncode == 0


def guide():
    """The commands of the section "Made again": lists of words."""
    text = (ROOT / "analytic/SPONGECAKE.md").read_text()
    section = text[text.index("### Made again"):]
    block = re.search(r"\n\n((?:    .+\n)+)", section)[1]
    return [shlex.split(line, comments=True) for line in block.splitlines()]


def smaller(words):
    """A command of `lamella dataset` with the sizes of DATA."""
    rest = [w for k, w in enumerate(words) if w not in DATA and (k == 0 or words[k - 1] not in DATA)]
    return [*rest, *(word for pair in DATA.items() for word in pair)]


class Training(ProgramTest):
    def python(self, *arguments):
        return subprocess.run([sys.executable, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=LIMIT, check=False)

    @unittest.skipUnless(HAS_TORCH, f"{sys.executable} has no PyTorch (Debian: python3-torch), which training needs")
    def test_the_guide_to_the_letter(self):
        trained = 0
        for words in guide():
            if words[0] == "lamella":
                self.assertEqual(words[1], "dataset")
                self.lamella(*smaller(words[1:]), "--quiet")
                continue
            self.assertEqual(words[:2], ["python3", "analytic/spongecake_network/train.py"])
            rest = list(words[2:])
            if "--steps" in rest:
                del rest[rest.index("--steps"):][:2]
            answer = self.python(str(SCRIPT), *rest, *STEPS)
            self.assertEqual(answer.returncode, 0, answer.stderr)
            name = rest[rest.index("--weights") + 1]
            self.check_weights(name, layers=int(name[-len("1.weights")]))
            trained += 1
        self.assertEqual(trained, 2)
        # The same again is the same network.
        before = (self.folder / name).read_bytes()
        self.python(str(SCRIPT), *rest, *STEPS)
        self.assertEqual((self.folder / name).read_bytes(), before)

    def check_weights(self, name, layers):
        file = self.folder / name
        weights = file.read_bytes()
        # 128 x 128 numbers twice, and what leads there and from there.
        inputs, outputs = 8 * layers + (2 if layers == 2 else 0), 4 * layers + 2
        numbers = 128 * (inputs + 1) + 2 * 128 * 129 + outputs * 129
        self.assertEqual(len(weights), 4 + 4 + 4 + 4 * 8 + 4 * numbers + 4)
        self.assertEqual(weights[:4], b"LMSC")
        self.assertEqual(struct.unpack("<II", weights[4:12]), (1, layers))
        self.assertEqual(struct.unpack("<I", weights[-4:])[0], zlib.crc32(weights[:-4]))
        made = json.loads(file.with_suffix(".json").read_text())
        self.assertEqual(made["weights_sha256"], hashlib.sha256(weights).hexdigest())
        self.assertEqual((made["training_stacks"], made["held_out_stacks"]), (54, 6))
        self.assertEqual(made["data"]["layers"], layers)
        self.assertGreater(made["validation"]["relative_rmse_mean"], 0)
        self.assertEqual(len(file.with_suffix(".csv").read_text().splitlines()), 3)

    def test_says_what_is_missing(self):
        # As where PyTorch is not installed.
        answer = self.python("-c", "import sys, runpy; sys.modules['torch'] = None; sys.argv = ['train.py', 'set']; "
                             f"runpy.run_path({str(SCRIPT)!r}, run_name='__main__')")
        self.assertEqual(answer.returncode, 1)
        self.assertIn("found no torch; allowed: ", answer.stderr)
        self.assertEqual(answer.stderr.count("\n"), 1, answer.stderr)


if __name__ == "__main__":
    unittest.main()
