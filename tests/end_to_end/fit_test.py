"""lamella fit --model: closed forms with the parameters that come nearest to a target."""

import json
import unittest

from lamella_program import WITH_CERES, ProgramTest, check_schema, without

SAND = ["--grid", "8x16"]


@unittest.skipUnless(WITH_CERES, "built without Ceres")
class FitsOfModels(ProgramTest):
    def test_rank_models_of_a_stack(self):
        answer = self.json_of("fit", "vmf_sand", "--model", "oren_nayar,eon,vmf_diffuse,lambert_sphere", *SAND, "--quiet",
                              "-o", "sand")
        self.assertEqual([m["name"] for m in answer["models"]],
                         [m["name"] for m in sorted(answer["models"], key=lambda m: m["misfit"])])
        # The stack is a half space of VMF flakes: its own closed form is nearest, with the stack's
        # parameters, as near as that form is good.
        best = answer["models"][0]
        self.assertEqual(best["name"], "vmf_diffuse")
        self.assertLess(best["relative_rmse"], 0.05)
        stack = answer["stack"]["layer"][0]
        found = {p["name"]: p["value"] for p in best["parameters"]}
        self.assertAlmostEqual(found["roughness"], stack["roughness"], delta=0.05)
        for channel, albedo in zip("rgb", stack["albedo"]):
            self.assertAlmostEqual(found[f"albedo.{channel}"], albedo, delta=0.02)
        # Half way between the directions of the fit it is about as near.
        self.assertTrue(answer["held_out"])
        fitted = {lobe["mu_i"] for lobe in best["residues"]}
        self.assertFalse(fitted & {wi["mu_i"] for wi in answer["held_out"]})
        self.assertLess(best["held_out_relative_rmse"], 0.05)
        self.assertGreater(best["held_out_relative_rmse"], 1e-4)
        # The page's numbers are those of a comparison with the model as --model has it.
        report = json.loads((self.folder / "sand/report.json").read_text())
        self.assertEqual(without(json.loads((self.folder / "sand/fit.json").read_text()), {"threads"}),
                         without(answer, {"threads"}))
        lobes = [l for l in report["models"][0]["lobes"] if l["order"] == "all"]
        for lobe, residue in zip(lobes, best["residues"]):
            self.assertAlmostEqual(lobe["relative_rmse"], residue["relative_rmse"], delta=2e-4)
        compared = self.json_of("compare", "vmf_sand", "--model", best["model"], *SAND, "--quiet", "-o", "again")
        again = [l["relative_rmse"] for l in compared["models"][0]["lobes"] if l["order"] == "all"]
        self.assertEqual(again, [l["relative_rmse"] for l in lobes])
        self.assertIn("<html", (self.folder / "sand/report.html").read_text())

    def test_find_the_parameters_of_a_coat_by_quick_tables(self):
        answer = self.json_of("fit", "coated,base=lambert,base.albedo=0.6,roughness=0.3", "--model",
                              "coated,base=lambert,color=1", "--grid", "8x16", "--wi", "20", "--wi", "60", "--quiet")
        found = {p["name"]: p["value"] for p in answer["models"][0]["parameters"]}
        # Exact tables correct the answer: what is left is the projection's 1e-4.
        self.assertAlmostEqual(found["roughness"], 0.3, delta=1e-3)
        self.assertAlmostEqual(found["base.albedo"], 0.6, delta=1e-3)
        self.assertLess(answer["models"][0]["relative_rmse"], 1e-3)

    def test_equal_commands_give_equal_answers(self):
        words = ["fit", "lambert_sphere,albedo=0.9,0.6,0.3", "--model", "eon", "--norm", "log", "--grid", "6x8", "--quiet"]
        one, two = (self.json_of(*words, "--threads", str(n)) for n in (1, 2))
        self.assertEqual(without(one, {"threads"}), without(two, {"threads"}))

    def test_take_lobes_materials_and_closed_forms(self):
        model = "oren_nayar,albedo=0.7,0.5,0.3,sigma=0.4"
        truth = {"albedo.r": 0.7, "albedo.g": 0.5, "albedo.b": 0.3, "sigma": 0.4}
        self.lamella("export", model, "--to", "merl", "-o", "paint.binary", "--quiet")
        self.lamella("import", "paint.binary", "-o", "paint.exr", "--grid", "8x16", "--quiet")
        # What MERL's bins cost of f (0.5 %, formats.md), or what floats of an EXR file do.
        for target, delta in ((model, 1e-3), ("paint.binary", 0.02), ("paint.exr", 0.02)):
            with self.subTest(target):
                grid = [] if target.endswith("exr") else ["--grid", "8x16"]
                answer = self.json_of("fit", target, "--model", "oren_nayar", *grid, "--quiet")
                for p in answer["models"][0]["parameters"]:
                    self.assertAlmostEqual(p["value"], truth[p["name"]], delta=delta)
        fixed = self.json_of("fit", "paint.exr", "--model", "oren_nayar,sigma=0.1", "--quiet")["models"][0]
        self.assertEqual([p["name"] for p in fixed["parameters"]], ["albedo.r", "albedo.g", "albedo.b"])
        self.assertIn("sigma=0.1", fixed["model"])

    def test_count_the_noise_of_walks(self):
        words = ["fit", "lambert_sphere_halfspace", "--wi", "30", "--wi", "70", "--grid", "6x8", "--walks", "20000",
                 "--model", "lambert_sphere", "--quiet"]
        model = self.json_of(*words)["models"][0]
        self.assertGreater(model["noise"], 0.003)
        self.assertLess(model["relative_rmse_without_noise"], model["relative_rmse"])
        [albedo] = model["parameters"]
        # The form is within 1 % of its medium (analytic/ACCURACY.md).
        self.assertLess(abs(albedo["value"] - 0.9), 5 * albedo["of_truth"] + 0.02)

    def test_refuse_what_makes_no_sense(self):
        (self.folder / "cut.binary").write_bytes(b"\x5a\x00\x00\x00")
        for words, parts in ((["sggx_slab", "--model", "spongecake"], ["from a stack"]),
                             (["sggx_slab", "--norm", "log"], ["--norm", "--model"]),
                             (["sggx_slab", "--wi", "30"], ["--wi", "--model"]),
                             (["sggx_slab", "--model", "eon", "--sampling", "eon"], ["--sampling"]),
                             (["cut.binary", "--model", "eon"], ["cut.binary"]),
                             (["none.exr", "--model", "eon"], ["none.exr"]),
                             (["lambert", "--model", "eon", "--walks", "1000"], ["--walks"]),
                             (["lambert,albedo=0", "--model", "eon"], ["no light"])):
            with self.subTest(" ".join(words)):
                answer = self.lamella("fit", *words, status=2)
                self.assertEqual(answer.err.count("\n"), 1, answer.err)
                for part in parts:
                    self.assertIn(part, answer.err)


if __name__ == "__main__":
    unittest.main()


@unittest.skipUnless(WITH_CERES, "built without Ceres")
class FitsOfStacks(ProgramTest):
    SPHERES = ('[[layer]]\nmedium = "lambert_sphere"\nalbedo = %s\nthickness = %g\n\n'
               '[substrate]\nbsdf = "lambert"\nalbedo = 0.3\n')
    VARY = ["--vary", "layer.0.albedo=0:1", "--vary", "layer.0.thickness=0.1:5:log"]
    SHORT = ["--wi", "10", "--wi", "60", "--grid", "4x8", "--quiet"]

    def values(self, answer):
        return {p["name"]: p["value"] for p in answer["models"][0]["parameters"]}

    def test_write_the_page_of_a_comparison(self):
        self.write("truth.toml", self.SPHERES % ("0.8", 0.7))
        self.write("start.toml", self.SPHERES % ("0.8", 2))
        for how, within in ([], 1e-3), (["--walks", "4000"], 0.1):
            answer = self.json_of("fit", "truth.toml", "--stack", "start.toml", "--vary", "layer.0.thickness=0.1:5:log",
                                  *how, *self.SHORT, "-o", "out")
            names = {path.name for path in (self.folder / "out").iterdir()}
            self.assertLessEqual({"report.html", "report.json", "fit.json", "stack.toml", "summary.txt", "truth.exr",
                                  "start.exr"}, names)
            report = json.loads((self.folder / "out/report.json").read_text())
            check_schema("compare", report)
            [model] = report["models"]
            self.assertEqual(model["parameters"], self.values(answer))
            self.assertIsNone(model["ns_per_eval"])
            # The orders apart, as both have them, and the same energies as those of the fit.
            self.assertEqual({lobe["order"] for lobe in model["lobes"]}, {"1", "2", "3", "4+", "2+", "all"})
            for lobe in model["lobes"]:
                self.assertLess(lobe["relative_rmse_without_noise"], within, lobe["order"])
                self.assertNotEqual(lobe["verdict"], "differs", lobe)
            self.assertEqual((self.folder / "out/stack.toml").read_text(), answer["models"][0]["stack"])
        self.assertIn("--pictures", self.lamella("fit", "truth.toml", "--stack", "start.toml", "--vary",
                                                 "layer.0.thickness=0.1:5", "--pictures", "svg", status=2).err)

    def test_find_a_stacks_own_numbers_by_the_solver(self):
        self.write("truth.toml", self.SPHERES % ("[0.9, 0.6, 0.3]", 0.7))
        self.write("start.toml", self.SPHERES % ("0.5", 2))
        answer = self.json_of("fit", "truth.toml", "--stack", "start.toml", *self.VARY, *self.SHORT, "-o", "found.toml")
        fit = answer["models"][0]
        found = self.values(answer)
        # The solver's tolerance is 1e-4 of f, and f changes about as much as these numbers do.
        for name, value in (("layer.0.albedo.r", 0.9), ("layer.0.albedo.g", 0.6), ("layer.0.albedo.b", 0.3),
                            ("layer.0.thickness", 0.7)):
            self.assertAlmostEqual(found[name], value, delta=2e-3)
        self.assertLess(fit["relative_rmse"], 1e-3)
        self.assertIn("solved with", fit["lobes_by"])
        # Along other directions as well, of which none was fitted to.
        self.assertEqual(len(answer["held_out"]), 1)
        self.assertLess(fit["held_out_relative_rmse"], 1e-3)
        text = (self.folder / "found.toml").read_text()
        self.assertEqual(text, fit["stack"])
        lobes = self.json_of("simulate", "found.toml", "--wi", "60", "--quiet")
        truth = self.json_of("simulate", "truth.toml", "--wi", "60", "--quiet")
        for a, b in zip(*(run["runs"][0]["reflected"]["total"] for run in (lobes, truth))):
            self.assertAlmostEqual(a, b, delta=1e-3)

    def test_find_them_by_walks_with_the_same_numbers_at_every_step(self):
        self.write("truth.toml", self.SPHERES % ("0.8", 0.7))
        words = ["fit", "truth.toml", "--stack", "truth.toml", "--vary", "layer.0.albedo=0.1:1", *self.SHORT]
        answer = self.json_of(*words, "--walks", "2e4", "--seed", "3")
        fit = answer["models"][0]
        # Truth and stack have the same seed and walks: what is left over is nothing.
        self.assertAlmostEqual(self.values(answer)["layer.0.albedo"], 0.8, delta=2e-3)
        self.assertIn("20000 walks per direction with the same random numbers", fit["lobes_by"])
        self.assertGreater(fit["noise"], 0)
        # Held out, both have walks of their own: what is left is noise, which is taken off.
        self.assertLess(fit["held_out_relative_rmse"], fit["noise"])

    def test_judge_stacks_of_another_kind_along_other_directions(self):
        # Isotropic scattering is no Lambert sphere: off where it was fitted and where it was not.
        self.write("truth.toml", self.SPHERES % ("0.8", 0.7))
        self.write("start.toml", '[[layer]]\nmedium = "henyey_greenstein"\ng = 0\nthickness = 1\n'
                                 '[substrate]\nbsdf = "lambert"\nalbedo = 0.3\n')
        words = ["fit", "truth.toml", "--stack", "start.toml", *self.VARY, "--grid", "4x8"]
        fit = self.json_of(*words, "--wi", "10", "--wi", "60", "--quiet")["models"][0]
        self.assertGreater(fit["relative_rmse"], 0.02)
        self.assertGreater(fit["held_out_relative_rmse"], 0.5 * fit["relative_rmse"])
        self.assertIn("held out: without noise", self.lamella(*words, "--wi", "60").out)

    def test_answer_a_material_and_closed_forms(self):
        # Lambert's law of albedo 0.4 below spheres that are as good as not there.
        answer = self.json_of("fit", "lambert,albedo=0.4", "--stack", self.write(
            "thin.toml", self.SPHERES % ("0.5", 1e-6)), "--vary", "substrate.albedo=0.1:0.9", *self.SHORT)
        self.assertAlmostEqual(self.values(answer)["substrate.albedo"], 0.4, delta=1e-3)

    def test_say_what_is_wrong_in_a_line(self):
        for words, text in ((["--vary", "layer.0.albedo=0:1"], "--stack"),
                            (["--stack", "sggx_slab"], "--vary"),
                            (["--stack", "sggx_slab", "--model", "eon", "--vary", "layer.0.albedo=0:1"], "--model"),
                            (["--stack", "sggx_slab", "--vary", "layer.0.albedo=1:0"], "FROM:TO"),
                            (["--stack", "sggx_slab", "--vary", "layer.0.albedo=0:2"], "albedo"),
                            (["--stack", "sggx_slab", "--vary", "layer.3.albedo=0:1"], "layer.3.albedo"),
                            (["--stack", "sggx_slab", "--vary", "layer.0.albedo=0:1", "--vary",
                              "layer.0.albedo=0:1"], "twice")):
            answer = self.lamella("fit", "vmf_sand", *words, status=2)
            self.assertEqual(answer.err.count("\n"), 1, str(answer))
            self.assertIn(text, answer.err)
