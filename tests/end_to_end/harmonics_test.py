"""Stacks without symmetry about the normal, solved in spherical harmonics."""
import unittest

from lamella_program import ProgramTest

FABRIC = """[[layer]]
medium = "sggx"
shape = "fiber"
axis = [1, 0.2, 0.1]
roughness = 0.7
albedo = [0.9, 0.5, 0.5]
thickness = 1
"""
NARROW = FABRIC.replace("roughness = 0.7", "roughness = 0.1")


class Harmonics(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("fabric.toml", FABRIC)

    def test_auto_solves_what_walks_answer_too(self):
        quick = ("fabric.toml", "--wi", "45,30", "--grid", "4x8", "--quiet")
        solved = self.json_of("simulate", *quick, "--tolerance", "1e-2")
        self.assertEqual(solved["estimator"], "deterministic")
        self.assertIn("spherical harmonics of degree", solved["estimator_reason"])
        [run] = solved["runs"]
        self.assertGreaterEqual(run["accuracy"]["harmonics"], 12)
        self.assertLessEqual(run["accuracy"]["error"], 1e-2)
        [walked] = self.json_of("simulate", *quick, "--walks", "2e5")["runs"]
        for side in ("reflected", "transmitted"):
            for c in range(3):
                error = walked[side]["standard_error"][c] + run[side]["standard_error"][c]
                self.assertLess(abs(run[side]["total"][c] - walked[side]["total"][c]), 5 * error)

    def test_what_it_does_not_take_is_said(self):
        self.write("narrow.toml", NARROW)
        answer = self.lamella("explain", "narrow.toml").out
        self.assertIn("narrowly", answer)
        self.write("coated.toml", '[[layer]]\ninterface = "ggx"\nior = 1.5\n'
                   'roughness = [0.1, 0.2]\n' + FABRIC)
        self.assertIn("differs along x and y", self.lamella("explain", "coated.toml").out)
        self.write("wide.toml", '[[layer]]\ninterface = "ggx"\nior = 1.5\n'
                   'roughness = [0.4, 0.5]\n' + FABRIC)
        self.assertIn("spherical harmonics", self.lamella("explain", "wide.toml").out)
        self.write("coated.toml", '[[layer]]\ninterface = "ggx"\nior = 1.5\nroughness = 0.2\n'
                   'scattering = "multiple"\n' + FABRIC)
        answer = self.lamella("simulate", "coated.toml", "--estimator", "deterministic", status=2)
        self.assertIn("multiple scattering", answer.err)
        self.assertEqual(len(answer.err.splitlines()), 1)

    def test_a_coat_is_solved_with_what_lies_under_it(self):
        self.write("coated.toml", '[[layer]]\ninterface = "ggx"\nior = 1.5\nroughness = 0.4\n' +
                   FABRIC + '[substrate]\nbsdf = "lambert"\nalbedo = 0.5\n')
        quick = ("coated.toml", "--wi", "45,30", "--grid", "3x6", "--quiet")
        [run] = self.json_of("simulate", *quick, "--tolerance", "2e-2", "--estimator",
                             "deterministic")["runs"]
        [walked] = self.json_of("simulate", *quick, "--walks", "2e5")["runs"]
        errors = walked["reflected"]["standard_error"]
        for c in range(3):
            allowed = 5 * errors[c] + 1e-4
            self.assertLess(abs(run["lost"][c] - walked["lost"][c]),
                            5 * walked["lost_standard_error"][c] + 1e-4)
            self.assertLess(abs(run["absorbed"][c] - walked["absorbed"][c]), 2 * allowed)
            self.assertLess(abs(run["reflected"]["total"][c] - walked["reflected"]["total"][c]),
                            allowed)
            for order in ("0", "1", "2"):
                x, y = (r["reflected"]["orders"][order]["total"][c] for r in (run, walked))
                self.assertLess(abs(x - y), allowed, order)

    def test_values_at_pairs_are_those_of_walks(self):
        self.write("fabric.toml", FABRIC)
        pairs = self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.7,50\n")

        def value(*settings):
            out = self.lamella("eval", "truth", "stack=fabric.toml", *settings, "--pairs",
                               pairs).out.splitlines()
            names, numbers = out[0].split(","), [float(x) for x in out[1].split(",")]
            row = dict(zip(names, numbers))
            return [row[n] for n in names if n.startswith("f")], \
                [row[n] for n in names if n.startswith("se")]

        solved, bound = value("estimator=deterministic", "tolerance=1e-3")
        walked, error = value("walks=1e5")
        for f, b, g, e in zip(solved, bound, walked, error):
            self.assertLessEqual(b, 1e-3 * f)
            self.assertLess(abs(f - g), b + 5 * e)

    def test_a_run_is_repeated_to_the_degree_where_it_ended(self):
        self.lamella("simulate", "fabric.toml", "--wi", "30", "--grid", "2x4", "--tolerance", "2e-2",
                     "--quiet", "-o", "first.exr")
        self.assertIn("modes", self.lamella("show", "first.exr").out)
        answer = self.json_of("rerun", "first.exr", "--quiet", "--threads", "1")
        self.assertEqual((answer["same"], answer["differences"]), (True, []))


if __name__ == "__main__":
    unittest.main()
