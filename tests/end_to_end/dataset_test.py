"""Data sets of random SpongeCake stacks with their orders 2 and up, and SpongeCake's accuracy."""

import hashlib
import math
import unittest

from lamella_program import WITH_CAIRO, WITH_CERES, ProgramTest
from samples_test import Npz

SMALL = ["--stacks", "60", "--walks", "512", "--directions", "2", "--grid", "4x8", "--quiet"]


class Dataset(ProgramTest):
    def files(self, folder):
        return {p.name: p.read_bytes() for p in sorted((self.folder / folder).glob("block_*.npz"))}

    def test_is_the_same_in_one_go_in_parts_and_continued(self):
        whole = self.json_of("dataset", "--layers", "2", *SMALL, "-o", "whole")
        self.assertEqual((whole["files"], whole["of_files"], whole["made"]), (2, 2, 60))
        for i in (1, 2):
            self.lamella("dataset", "--layers", "2", *SMALL, "--shard", f"{i}/2", "-o", "parts")
        again = self.json_of("dataset", "--layers", "2", *SMALL, "-o", "parts")
        self.assertEqual((again["made"], again["sha256"]), (0, whole["sha256"]))
        self.assertEqual(self.files("parts"), self.files("whole"))
        (self.folder / "whole/block_00001.npz").unlink()
        again = self.json_of("dataset", "--layers", "2", *SMALL, "-o", "whole")
        self.assertEqual((again["made"], again["sha256"]), (10, whole["sha256"]))
        sums = hashlib.sha256("".join(hashlib.sha256(b).hexdigest() for b in self.files("whole").values()).encode())
        self.assertEqual(sums.hexdigest(), whole["sha256"])

    def test_other_settings_want_another_folder(self):
        self.lamella("dataset", *SMALL, "-o", "set")
        answer = self.lamella("dataset", *SMALL, "--seed", "2", "-o", "set", status=2)
        self.assertIn("seed", answer.err)
        self.assertEqual(answer.err.count("\n"), 1, answer.err)
        self.assertIn("-o", self.lamella("dataset", *SMALL, status=2).err)

    def test_holds_what_simulate_finds(self):
        # Of a stack with enough light in orders 2 and up, written out as a stack file.
        self.lamella("dataset", "--stacks", "8", "--walks", "2e5", "--directions", "1", "--grid", "2x4", "--quiet",
                     "-o", "set")
        file = Npz(self.folder / "set/block_00000.npz")
        parameters, w_i = file["parameters"], file["w_i"]
        values = [v for row in file["f"] for v in row]
        per_stack = len(values) // 8
        solid_angle = 3.141592653589793 / 8
        compared = 0
        for k in range(8):
            r, ar, ag, ab, depth, fr, fg, fb, kind, x, y, z = parameters[k]
            self.write("one.toml", f"""[[layer]]
medium = "sggx"
shape = "{'fiber' if kind else 'surface'}"
roughness = {r}
axis = [{x}, {y}, {z}]
albedo = [{ar}, {ag}, {ab}]
f0 = [{fr}, {fg}, {fb}]
thickness = {depth}
""")
            theta = math.degrees(math.acos(w_i[k][2]))
            phi = math.degrees(math.atan2(w_i[k][1], w_i[k][0])) % 360
            run = self.json_of("simulate", "one.toml", "--wi", f"{theta},{phi}", "--walks", "2e5", "--seed", "9",
                               "--quiet")["runs"][0]
            for side, name in enumerate(("reflected", "transmitted")):
                for c in range(3):
                    own = values[k * per_stack + side * per_stack // 2:][:per_stack // 2][c::3]
                    multiple = run[name]["multiple"]
                    total, error = multiple["total"][c], multiple["standard_error"][c]
                    self.assertAlmostEqual(sum(own) * solid_angle, total, delta=5 * 1.5 * error + 1e-7)
                    orders = sum(run[name]["orders"][o]["total"][c] for o in ("2", "3", "4+"))
                    self.assertAlmostEqual(total, orders, delta=1e-12)
                    compared += total > 20 * error
        self.assertGreater(compared, 20)


class AccuracyOfSpongecake(ProgramTest):
    def test_tells_the_forms_error_from_the_networks(self):
        pictures = ["-o", "worst"] if WITH_CAIRO else []
        answer = self.json_of("accuracy", "--spongecake", "--quick", "--walks", "16384", "--quiet", *pictures)
        names = [row["name"] for row in answer["spongecake"]]
        self.assertEqual([name.rpartition("_")[0] for name in names], 8 * ["one_layer"] + 8 * ["two_layer"])
        network = [row["network"]["multiple"] for row in answer["spongecake"]]
        for row in answer["spongecake"]:
            self.assertAlmostEqual(row["nothing"]["multiple"], 1, places=9)
            self.assertLessEqual(row["nothing"]["all"], 1)
            if WITH_CERES:
                # The best of the form on these cells; both have the same noise taken off.
                self.assertLessEqual(row["fit"]["multiple"], row["network"]["multiple"] + 1e-3)
                # That of other directions is no better on these.
                self.assertLessEqual(row["fit"]["multiple"], row["fit_elsewhere"]["multiple"] + 1e-3)
        self.assertLess(sum(network) / len(network), 0.8)
        if not WITH_CAIRO:
            return
        # The five where the network is worst are among those drawn.
        worst = [name for _, name in sorted(zip(network, names), reverse=True)[:5]]
        self.assertLessEqual({name + ".png" for name in worst}, {p.name for p in (self.folder / "worst").iterdir()})
        for picture in (self.folder / "worst").iterdir():
            self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))

    def test_pictures_are_of_spongecakes_stacks(self):
        answer = self.lamella("accuracy", "--quick", "-o", "worst", status=2)
        self.assertIn("allowed: beside --spongecake", answer.err)


class FiguresOfSpongecake(ProgramTest):
    def test_the_furnace_of_two_layers(self):
        answer = self.json_of("reproduce", "spongecake_figure_21", "--walks", "3e5", "--quiet", "-o", "figure")
        for row in answer["rows"]:
            self.assertLess(row["delta"], row["single"])
            self.assertLess(row["single"], row["truth"])
            # Order 1 is summed over 36 points of a cell.
            self.assertAlmostEqual(row["truth"], 1, delta=5 * row["standard_error"] + 5e-3)
            self.assertLess(abs(row["network"] - 1), abs(row["single"] - 1))
            if WITH_CERES:
                self.assertLess(abs(row["fit"] - 1), abs(row["single"] - 1))

    def test_lobes_of_fibers(self):
        answer = self.json_of("reproduce", "spongecake_figure_22", "--walks", "1e6", "--quiet", "-o", "figure")
        self.assertEqual(len(answer["rows"]), 4)
        for row in answer["rows"]:
            self.assertLess(row["network"]["all"], row["nothing"]["all"] + 0.05)
        if WITH_CAIRO:
            self.assertTrue(any(p.endswith("_matrix.png") for p in answer["pictures"]))
            for name in answer["pictures"]:
                self.assertTrue((self.folder / "figure" / name).read_bytes().startswith(b"\x89PNG"))


if __name__ == "__main__":
    unittest.main()
