import csv
import io
import math

from lamella_program import ProgramTest

ANGLES = "theta_i,phi_i,theta_o,phi_o"
COSINES = "mu_i,phi_i,mu_o,phi_o"


class EvalAnswersInCsv(ProgramTest):
    def eval(self, *words, header=COSINES, rows=("0.5,0,0.8,90",)):
        """The columns and rows of the answer to those pairs."""
        self.write("pairs.csv", "\n".join([header, *rows]) + "\n")
        text = self.lamella("eval", *words, "--pairs", "pairs.csv").out
        table = list(csv.reader(io.StringIO(text)))
        for given, row in zip(rows, table[1:], strict=True):
            self.assertEqual(",".join(row[:4]), given)
        self.assertEqual(",".join(table[0][:4]), header)
        return table[0][4:], [[float(x) for x in row[4:]] for row in table[1:]]

    def test_lambert_is_albedo_over_pi_with_17_digits(self):
        columns, values = self.eval("lambert", "albedo=0.7")
        self.assertEqual((columns, values), (["f"], [[0.7 / math.pi]]))
        text = self.lamella("eval", "lambert", "--pairs", "pairs.csv").out
        self.assertEqual(text, COSINES + ",f\n0.5,0,0.8,90,0.31830988618379069\n")

    def test_angles_and_cosines_mean_the_same(self):
        words = ("single_scattering", "stack=spongecake_two_layer")
        by_angle = self.eval(*words, header=ANGLES, rows=("60,10,0,0", "90,0,60,30"))[1]
        by_cosine = self.eval(*words, rows=("0.5,10,1,0", "0,0,0.5,30"))[1]
        for a, b in zip(by_angle, by_cosine):
            self.assertAlmostEqual(a[0] / b[0], 1, delta=1e-14)

    def test_a_colour_gives_three_columns_in_every_part(self):
        for part in ("", ".diffuse", ".albedo", ".pdf"):
            with self.subTest(part):
                columns, _ = self.eval("lambert" + part, "albedo=0.9,0.5,0.2")
                self.assertEqual(columns, ["f_r", "f_g", "f_b"])
        self.assertEqual(self.eval("lambert.albedo", "albedo=0.9,0.5,0.2")[1], [[0.9, 0.5, 0.2]])
        columns, values = self.eval("single_scattering", "stack=vmf_sand")
        self.assertEqual(columns, ["f_r", "f_g", "f_b"])
        self.assertGreater(values[0][0], values[0][2])

    def test_parts_of_a_model(self):
        stack = "stack=spongecake_sheen"
        whole = self.eval("single_scattering", stack)[1][0]
        parts = [self.eval(f"single_scattering.{lobe}", stack)[1][0]
                 for lobe in ("layers", "substrate")]
        for c in range(3):
            self.assertAlmostEqual(parts[0][c] + parts[1][c], whole[c], delta=1e-15)
        self.assertAlmostEqual(self.eval("lambert.pdf")[1][0][0], 0.5 / math.pi, delta=1e-16)

    def test_spongecake_is_single_scattering_where_it_applies(self):
        rows = ("0.5,0,0.8,90", "0.3,20,-0.7,10", "-0.4,0,0.6,0")
        _, a = self.eval("spongecake", "stack=spongecake_two_layer", "lobes=none", rows=rows)
        _, b = self.eval("single_scattering", "stack=spongecake_two_layer", rows=rows)
        for x, y in zip(a, b):
            self.assertAlmostEqual(x[0] / y[0], 1, delta=1e-12)

    def test_both_cosines_at_zero_are_refused_or_the_limit(self):
        self.write("grazing.csv", COSINES + "\n0,0,0,0\n")
        self.write("tiny.csv", COSINES + "\n1e-300,0,5e-324,0\n")
        for model in ("chandrasekhar", "eon", "eon_approx", "fon", "oren_nayar_full", "oren_nayar",
                      "oren_nayar_footnote", "fujii_qualitative", "lambert_sphere",
                      "lambert_sphere_fast", "lambert_sphere_three_term",
                      "lambert_sphere_three_term_pure", "hapke_lambert_sphere", "vmf_diffuse",
                      "vmf_diffuse_printed", "beckmann_diffuse"):
            for name in ("grazing.csv", "tiny.csv"):
                with self.subTest(model, pairs=name):
                    answer = self.lamella("eval", model, "--pairs", name, status=2)
                    self.assertIn(f"{name}:2", answer.err)
                    self.assertIn("both cosines are 0", answer.err)
        for words in (("lambert",), ("eon", "roughness=0"), ("vmf_diffuse", "roughness=0"),
                      ("micrograin",)):
            _, values = self.eval(*words, rows=("0,0,0,0",))
            self.assertAlmostEqual(values[0][0], 1 / math.pi, delta=1e-14)
        self.assertEqual(self.eval("chandrasekhar", "albedo=0", rows=("0,0,0,0",))[1], [[0.0]])
        _, values = self.eval("eon.ms", rows=("0,0,0,0",))
        self.assertLess(values[0][0], 1e-100)
        for model in ("eon", "lambert_sphere", "chandrasekhar", "vmf_diffuse"):
            _, values = self.eval(model, rows=("0,0,0.5,30", "1e-300,0,0.5,30",
                                               "5e-324,0,0.5,30", "1e-12,0,0.5,30"))
            self.assertEqual(values[0], values[1])
            self.assertEqual(values[0], values[2])
            self.assertAlmostEqual(values[0][0], values[3][0], delta=1e-4)

    def test_media_by_closed_forms(self):
        _, sigma = self.eval("media.sggx.sigma", "roughness=0.5", rows=("0.6,0,1,0",))
        self.assertAlmostEqual(sigma[0][0], math.sqrt(0.36 + 0.25 * 0.64), delta=1e-15)
        _, phase = self.eval("media.sggx.phase", "roughness=1")
        self.assertAlmostEqual(phase[0][0], 1 / (4 * math.pi), delta=1e-15)
        _, sigma = self.eval("media.vmf_flake.sigma", "alpha=inf")
        self.assertAlmostEqual(sigma[0][0], 0.25, delta=1e-15)
        _, phase = self.eval("media.henyey_greenstein.phase", "g=0.5", "albedo=0.3",
                             rows=("1,0,1,0",))
        self.assertAlmostEqual(phase[0][0], 0.75 / (4 * math.pi * 1.5**3), delta=1e-15)
        _, phase = self.eval("media.lambert_sphere.phase", rows=("1,0,1,0",))
        self.assertAlmostEqual(phase[0][0], 2 / (3 * math.pi), delta=1e-15)

    def test_truth_adds_standard_errors_and_agrees_with_single_scattering(self):
        rows = ("0.5,0,0.8,90", "0.8,30,0.5,0", "0.7,0,-0.6,10", "0,0,0.5,0", "1,0,1,0")
        columns, truth = self.eval("truth", "stack=sggx_slab", "walks=4000", "--max-order", "1",
                                   rows=rows)
        self.assertEqual(columns, ["f", "se"])
        _, exact = self.eval("single_scattering", "stack=sggx_slab", rows=rows)
        for (value, error), (f,) in zip(truth, exact):
            # Five values of 4000 walks, whose standard errors are some percent. What is given as
            # the error has the light of the walks that were cut, spread over one side, besides.
            self.assertLess(abs(value - f), 0.2 * f)
            self.assertTrue(0.01 < error < 1 / math.pi)
        columns, _ = self.eval("truth", "stack=vmf_sand", "walks=200")
        self.assertEqual(columns, ["f_r", "f_g", "f_b", "se_r", "se_g", "se_b"])

    def test_the_solver_of_truth_takes_a_time(self):
        columns, rows = self.eval("truth", "stack=lambert_sphere_halfspace", "time=60",
                                  "estimator=deterministic", "tolerance=1e-6")
        self.assertIn("se", " ".join(columns))
        for value, error in rows:
            self.assertLess(error, 2e-6 * value)

    def test_truth_at_thousands_of_pairs_is_that_at_each_of_them(self):
        pairs = [f"{0.05 + 0.9 * (k * 0.618034 % 1):.6f},0,{0.05 + 0.9 * (k * 0.754878 % 1):.6f},{k % 360}"
                 for k in range(5000)]

        def values(rows):
            self.write("many.csv", "\n".join(["mu_i,phi_i,mu_o,phi_o", *rows, ""]))
            out = self.lamella("eval", "truth", "stack=lambert_sphere_halfspace", "estimator=deterministic",
                               "--pairs", "many.csv").out
            return [list(map(float, line.split(",")[4:])) for line in out.splitlines()[1:]]

        for (many, bound), (alone, own) in zip(values(pairs), values(pairs[:40])):
            self.assertLessEqual(abs(many - alone), bound + own)
            self.assertLess(bound, 1e-4 * many)

    def test_truth_takes_walks_and_seed_as_keys_or_options(self):
        def values(*words):
            return self.eval("truth", "stack=sggx_slab", *words)[1]
        self.assertEqual(values("walks=500", "seed=7"), values("--walks", "500", "--seed", "7"))
        self.assertNotEqual(values("walks=500", "seed=7"), values("walks=500", "seed=8"))

    def test_truth_does_not_depend_on_the_number_of_threads(self):
        rows = ("0.5,0,0.8,90", "0.8,30,-0.5,0")
        one, two, seven = (self.eval("truth", "stack=sggx_slab", "walks=1000", "--threads", n,
                                     rows=rows) for n in ("1", "2", "7"))
        self.assertEqual(one, two)
        self.assertEqual(one, seven)

    def test_below_an_opaque_stack_is_dark(self):
        for model in ("truth", "single_scattering"):
            _, values = self.eval(model, "stack=lambert_sphere_halfspace", rows=("0.5,0,-0.8,0",))
            self.assertEqual(values[0][0], 0)

    def test_pairs_come_from_stdin_with_blanks_and_empty_lines(self):
        text = "\ufeffmu_i, phi_i, mu_o, phi_o\r\n\r\n 0.5, +0, 0.8, 90\r\n"
        answer = self.lamella("eval", "lambert", "--pairs", "-", stdin=text)
        self.assertEqual(answer.out.count("\n"), 2)

    def test_no_pairs_give_the_header_alone(self):
        self.assertEqual(self.eval("lambert", rows=()), (["f"], []))

    def test_both_cosines_may_be_0_where_a_model_is_finite(self):
        self.assertEqual(self.eval("lambert", rows=("0,0,0,0",))[1], [[1 / math.pi]])
