"""lamella fit --model: closed forms with the parameters that come nearest to a target."""

import json
import unittest

from lamella_program import WITH_CERES, ProgramTest, without

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
