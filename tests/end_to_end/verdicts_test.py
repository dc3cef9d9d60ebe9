"""What verdicts mean, and what they may not say: cut walks, noise, loss and gain."""

import unittest

from lamella_program import WITH_CERES, WITH_EMBREE, ProgramTest

WHITE = '[[layer]]\nmedium = "henyey_greenstein"\nalbedo = 1\nthickness = inf\n'
HALF = WHITE.replace("albedo = 1", "albedo = 0.9")


class CutWalks(ProgramTest):
    def compared(self, *arguments):
        return self.json_of("compare", *arguments, "--wi", "60", "--grid", "4x8", "--quiet")

    def all_orders(self, answer, model=0):
        [lobe] = [l for l in answer["models"][model]["lobes"]
                  if l["order"] == "all" and l["side"] == "reflect"]
        return lobe

    def test_an_exact_half_space_is_not_off_by_what_was_cut(self):
        self.write("white.toml", WHITE)
        for order in ("3", "20", "100"):
            with self.subTest(order):
                answer = self.compared("white.toml", "--model", "chandrasekhar", "--walks", "2e5",
                                       "--max-order", order)
                lobe = self.all_orders(answer)
                self.assertEqual(lobe["verdict"], "insufficient")
                [missing] = lobe["energy_missing"]
                self.assertGreater(missing, 0.05)
                # A white half space sends everything back: what is missing is what was cut.
                self.assertAlmostEqual(lobe["energy_truth"][0] + missing, 1, delta=0.01)
                self.assertEqual(lobe["relative_rmse_range"][0], 0)
                self.assertGreater(lobe["relative_rmse_range"][1],
                                   lobe["relative_rmse_without_noise"])

    def test_single_scattering_is_not_all_orders_because_the_others_were_cut(self):
        self.write("half.toml", HALF)
        answer = self.compared("half.toml", "--model", "single_scattering", "--walks", "2e5",
                               "--max-order", "1")
        lobes = {l["order"]: l for l in answer["models"][0]["lobes"]}
        self.assertEqual(lobes["1"]["verdict"], "agrees")
        self.assertEqual(lobes["1"]["energy_missing"], [0])
        self.assertEqual(lobes["all"]["verdict"], "insufficient")

    def test_a_difference_beyond_what_was_cut_is_one(self):
        self.write("white.toml", WHITE)
        answer = self.compared("white.toml", "--model", "lambert,albedo=0.3", "--walks", "2e5",
                               "--max-order", "100")
        lobe = self.all_orders(answer)
        self.assertEqual(lobe["verdict"], "differs")
        least, most = lobe["relative_rmse_range"]
        self.assertTrue(0 < least < lobe["relative_rmse_without_noise"] < most)

    def test_little_that_was_cut_leaves_the_verdict(self):
        self.write("half.toml", HALF)
        answer = self.compared("half.toml", "--model", "chandrasekhar", "--walks", "1e6",
                               "--max-order", "100")
        lobe = self.all_orders(answer)
        self.assertEqual(lobe["verdict"], "agrees")
        self.assertTrue(0 < lobe["energy_missing"][0] < 1e-4)

    def test_table_and_footer_say_so(self):
        self.write("white.toml", WHITE)
        cut = self.lamella("compare", "white.toml", "--model", "chandrasekhar", "--walks", "2e4",
                           "--max-order", "100", "--wi", "60", "--grid", "4x8").out
        self.assertIn("missing", cut.splitlines()[4])
        self.assertIn("walks were cut after 100 events", cut)
        self.assertIn("could hide none above 10 %", cut)
        whole = self.lamella("compare", "sggx_slab", "--model", "single_scattering", "--walks",
                             "2e4", "--wi", "60", "--grid", "4x8").out
        self.assertNotIn("missing", whole)
        self.assertIn("could hide none above 10 %", whole)

    def test_large_differences_are_plain_numbers(self):
        self.write("dark.toml", HALF.replace("0.9", "0.1"))
        out = self.lamella("compare", "dark.toml", "--model", "lambert,albedo=1", "--walks", "2e5",
                           "--wi", "60", "--grid", "4x8").out
        self.assertRegex(out, r"differs by \d{3,} %")
        self.assertNotRegex(out, r"differs by [0-9.]*e")


    def test_values_at_pairs_carry_what_was_cut(self):
        self.write("white.toml", WHITE)
        self.write("p.csv", "theta_i,phi_i,theta_o,phi_o\n60,0,30,50\n")
        first = ["eval", "truth", "stack=white.toml", "walks=2e4", "--pairs", "p.csv", "--max-order", "1"]
        answer = self.lamella(*first)
        f, se = (float(x) for x in answer.out.splitlines()[1].split(",")[4:])
        whole = self.lamella("eval", "truth", "stack=white.toml", "--pairs", "p.csv").out
        exact = float(whole.splitlines()[1].split(",")[4])
        self.assertGreater(exact, 2 * f)
        self.assertLess(exact, f + 3 * se)
        self.assertIn("walks that were cut after 1 events hold", answer.err)
        self.assertIn("--max-order", answer.err)

    @unittest.skipUnless(WITH_CERES, "without Ceres nothing is fitted")
    def test_fits_say_what_their_truth_lacks(self):
        few = ["--walks", "1e5", "--quiet"]
        cut = self.json_of("fit", "sggx_slab", *few, "--max-order", "3")
        whole = self.json_of("fit", "sggx_slab", *few)
        for residue in cut["residues"]:
            self.assertGreater(residue["energy_missing"], 0.005)
            self.assertGreater(residue["noise"], residue["energy_missing"])
        self.assertLess(max(r["energy_missing"] for r in whole["residues"]), 1e-3)
        self.assertIn("walks were cut after 3 events", self.lamella("fit", "sggx_slab", "--walks", "1e4",
                                                                    "--max-order", "3").out)

    def test_a_sweep_ends_as_its_comparisons_do(self):
        # All of the difference may be what was cut: by the certain part no model is off.
        few = ["--model", "chandrasekhar", "--walks", "2e5", "--max-order", "20", "--wi", "60", "--grid", "4x8",
               "--max-error", "0.05", "--quiet"]
        self.write("white.toml", WHITE)
        self.lamella("compare", "white.toml", *few, "-o", "one")
        self.lamella("sweep", "white.toml", "--set", "layer.0.albedo=1", *few, "-o", "many")
        self.lamella("sweep", "white.toml", "--set", "layer.0.albedo=1", *few, "-o", "many")


@unittest.skipUnless(WITH_EMBREE, "built without Embree")
class SideBySide(ProgramTest):
    def test_one_pair_has_one_error_in_both_tables(self):
        answer = self.json_of("compare", "sphere_bed_dense", "--model", "lambert_sphere,albedo=0.9",
                              "--walks", "8000", "--wi", "30", "--grid", "4x8", "--quiet")
        for order in ("1", "all"):
            rows = {r["relative_rmse_of_both"] for r in answer["side_by_side"]
                    if r["order"] == order and r.get("model") == "lambert_sphere"}
            lobes = {l["relative_rmse_without_noise"] for l in answer["models"][0]["lobes"]
                     if l["order"] == order and l["side"] == "reflect"}
            self.assertEqual(len(lobes), 1)
            for row in rows:
                self.assertAlmostEqual(row, *lobes, places=10)
        self.assertTrue(rows)


class Furnaces(ProgramTest):
    def test_noise_beyond_the_limit_says_nothing(self):
        for stack in ("spongecake_window_shade", "lambert_sphere_white"):
            with self.subTest(stack):
                few = self.json_of("furnace", stack, "--walks", "2000", "--wi", "60", "--quiet")
                self.assertEqual(few["verdict"], "inconclusive")
                self.assertGreater(max(few["runs"][0]["energy_standard_error"]), 1e-3)
                self.assertIn("0.001", few["criterion"])
        many = self.json_of("furnace", "spongecake_window_shade", "--walks", "1e6", "--wi", "60",
                            "--quiet")
        self.assertEqual(many["verdict"], "pass")
        self.assertLess(max(many["runs"][0]["energy_standard_error"]), 1e-3)

    def test_the_criterion_is_printed(self):
        for arguments in (["hg_slab", "--walks", "2000"], ["hg_slab", "--tolerance", "1e-3"],
                          ["--model", "lambert"]):
            out = self.lamella("furnace", *arguments, "--wi", "30").out
            self.assertIn("pass: the energy is 1 within", out)
            self.assertIn("a loss or a gain", out)

    def test_a_failure_says_loss_or_gain(self):
        lost = self.json_of("furnace", "--model", "fon,roughness=1", "--wi", "60", "--quiet",
                            status=1)
        self.assertEqual(lost["runs"][0]["loss_or_gain"], "loss")
        self.assertIn("fail: loss", self.lamella("furnace", "--model", "fon,roughness=1", "--wi",
                                                 "60", status=1).out)
        # Lobes that are short of energy at normal incidence have too much at grazing.
        both = self.json_of("furnace", "--model", "fujii_qualitative,sigma=0.3", "--wi", "0", "--wi",
                            "80", "--quiet", status=1)
        self.assertEqual([r["loss_or_gain"] for r in both["runs"]], ["loss", "gain"])
        self.assertLess(both["runs"][0]["energy"][0], 1)
        self.assertGreater(both["runs"][1]["energy"][0], 1)


if __name__ == "__main__":
    unittest.main()
