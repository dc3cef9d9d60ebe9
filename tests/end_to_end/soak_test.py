"""Walks of four stacks against the solver: the table of deviations, and that a run goes on."""

import csv
import os

from lamella_program import ProgramTest

MANY = "1e9" if "LAMELLA_SOAK" in os.environ else "2e6"


class Soak(ProgramTest):
    def test_deviations_are_those_of_noise(self):
        answer = self.json_of("soak", "--collisions", MANY, "-o", "soaked", "--quiet")
        self.assertEqual(answer["verdict"], "pass")
        self.assertAlmostEqual(answer["collisions"] / float(MANY), 1, delta=0.1)
        self.assertEqual(len(answer["stacks"]), 4)
        with open(self.folder / "soaked/z.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        counted = [row for row in rows if row["z"]]
        self.assertEqual(len(counted), sum(lobe["cells"] for lobe in answer["lobes"]))
        # The cells of a lobe share their walks: lobes, not cells, are independent, nearly.
        squares = sum(lobe["cells"] * lobe["rms_z"] ** 2 for lobe in answer["lobes"])
        self.assertAlmostEqual(squares / len(counted), 1, delta=0.15)
        for row in counted[:50]:
            error = (float(row["se"]) ** 2 + float(row["bound"]) ** 2) ** 0.5
            self.assertAlmostEqual(float(row["z"]), (float(row["f_walks"]) - float(row["f_solver"])) / error, delta=0.02)
        if "LAMELLA_SOAK" not in os.environ:
            return
        again = self.json_of("soak", "--collisions", MANY, "-o", "soaked", "--quiet")
        self.assertEqual(again["lobes"], answer["lobes"])
