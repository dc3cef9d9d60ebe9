"""Interfaces in stack files: what a user reads, and what is refused."""

import unittest

from lamella_program import ProgramTest

COAT = '[[layer]]\ninterface = "ggx"\nior = 1.5\nroughness = 0.3\n'
LAMBERT = '[substrate]\nbsdf = "lambert"\nalbedo = 0.8\n'
SPHERES = '[[layer]]\nmedium = "lambert_sphere"\nthickness = 1\n'
COPPER = '[substrate]\nbsdf = "conductor"\neta = [0.2, 0.92, 1.1]\nk = [3.91, 2.45, 2.14]\n'


class Interfaces(ProgramTest):
    def run_of(self, text, *arguments):
        self.write("stack.toml", text)
        return self.json_of("simulate", "stack.toml", "--wi", "45", "--quiet", *arguments)

    def test_order_0_and_what_is_lost_are_in_the_ledger(self):
        for estimator in ("analog", "next-event"):
            with self.subTest(estimator):
                answer = self.run_of(COAT + LAMBERT, "--walks", "2e4", "--estimator", estimator)
                [run] = answer["runs"]
                self.assertGreater(run["lost"][0], 0.01)
                parts = [run["reflected"]["total"][0], run["transmitted"]["total"][0],
                         run["uncollided"][0], run["absorbed"][0], run["unresolved"][0],
                         run["lost"][0]]
                self.assertAlmostEqual(sum(parts), 1, delta=1e-9)
                orders = run["reflected"]["orders"]
                self.assertAlmostEqual(sum(o["total"][0] for o in orders.values()),
                                       run["reflected"]["total"][0], delta=1e-9)
                self.assertEqual(answer["stack"]["layer"][0]["interface"], "ggx")

    def test_smooth_interfaces_give_a_specular_part(self):
        [run] = self.run_of(COAT.replace("ggx", "smooth").replace("roughness = 0.3\n", "") + LAMBERT,
                            "--walks", "2e5", "--estimator", "analog")["runs"]
        self.assertAlmostEqual(run["reflected"]["specular"][0], 0.0502399, delta=0.005)
        self.assertNotIn("lost", run)

    def test_conductors_are_coloured(self):
        [run] = self.run_of(COPPER, "--walks", "1000", "--estimator", "analog")["runs"]
        r, g, b = run["reflected"]["specular"]
        self.assertTrue(r > g > b)
        self.assertAlmostEqual(r, 0.9516, delta=0.002)

    def test_exr_has_the_lobes_of_order_0_and_of_the_others(self):
        self.write("stack.toml", COAT + LAMBERT)
        self.lamella("simulate", "stack.toml", "--walks", "1e4", "-o", "out.exr", "--quiet")
        names = self.lamella("show", "out.exr").out
        self.assertIn("order0", names)

    def test_what_an_interface_may_not_have_is_named(self):
        for text, line, parts in (
            (COAT.replace("ggx", "gxx") + LAMBERT, 2, ['"interface"', 'did you mean "ggx"?']),
            (COAT + "albedo = 0.5\n" + LAMBERT, 5, ['"albedo"', "unknown in layer 0, a ggx"]),
            (COAT.replace("ggx", "smooth") + LAMBERT, 4, ['"roughness"', "a smooth interface"]),
            (COAT.replace("ior = 1.5\n", "") + LAMBERT, 1, ['"ior"', "found nothing"]),
            (COAT.replace("1.5", "0") + LAMBERT, 3, ['"ior"', "found 0", "[0.1, 10]"]),
            (COAT.replace("0.3", "[0.3, -1]") + LAMBERT, 4, ['"roughness"', "[along x, along y]"]),
            (COAT + 'medium = "sggx"\n' + LAMBERT, 5, ['"medium"', 'beside "interface"']),
            (SPHERES + "ior = 1.5\n", 4, ['"ior"', "unknown in layer 0"]),
            (COAT + SPHERES + 'grid = "builtin:dust"\nsize = [1, 1]\n', 8, ['"grid"', "interface"]),
            (COAT + COPPER + "roughness = 0.2\n", 9, ['"roughness"', 'distribution = "smooth"']),
            (COAT + COPPER.replace("k =", "kk ="), 8, ['"kk"', "unknown in substrate"]),
            (COAT + LAMBERT.replace("lambert", "lamber"), 6, ['"bsdf"', 'did you mean "lambert"?']),
            (COAT + 'scattering = "multiple"\nmasking = "separable"\n' + LAMBERT, 6, ['"masking"']),
        ):
            with self.subTest(text):
                self.write("broken.toml", text)
                message = self.lamella("simulate", "broken.toml", status=2).err.strip()
                self.assertEqual(len(message.splitlines()), 1, message)
                self.assertIn(f"broken.toml:{line}: ", message)
                for part in parts:
                    self.assertIn(part, message)

    def test_closed_forms_of_plain_layers_refuse_them(self):
        self.write("stack.toml", COAT + LAMBERT)
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,90\n")
        message = self.lamella("eval", "single_scattering", "stack=stack.toml", "--pairs",
                               "pairs.csv", status=2).err
        self.assertIn("interfaces", message)

    def test_media_lists_them(self):
        names = {m["name"]: m["entry"] for m in self.json_of("media", "--quiet")["media"]}
        self.assertEqual(names["ggx"], "interface")
        self.assertEqual(names["conductor"], "substrate")
        self.assertEqual(names["sggx"], "medium")


if __name__ == "__main__":
    unittest.main()
