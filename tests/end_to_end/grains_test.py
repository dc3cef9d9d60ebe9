"""Explicit geometry through every command that takes it."""

import json
import unittest

from lamella_program import WITH_CAIRO, WITH_CERES, WITH_EMBREE, ProgramTest

# Small tiles: realisations are cheap.
BED = """
[[layer]]
medium = "sphere_bed"
radius = 0.02
packing = 1
thickness = 0.2
tile = 0.2
albedo = [0.9, 0.6, 0.3]
"""
GRAINS = """
[[layer]]
medium = "micrograins"
tau0 = 0.6
beta = 0.7
tile = 10
albedo = 0.8
[substrate]
albedo = 0.2
"""


@unittest.skipIf(WITH_EMBREE, "built with Embree")
class WithoutEmbree(ProgramTest):
    def test_explicit_geometry_is_refused_in_one_line(self):
        self.write("bed.toml", BED)
        for arguments in (["simulate", "bed.toml", "--walks", "2000"], ["measure", "bed.toml"],
                          ["compare", "micrograins_dust", "--walks", "2000"], ["samples", "bed.toml", "-o", "a.npz"]):
            error = self.lamella(*arguments, status=2).err
            self.assertEqual(len(error.splitlines()), 1, error)
            self.assertIn("LAMELLA_EMBREE=OFF", error)


@unittest.skipUnless(WITH_EMBREE, "built without Embree")
class ExplicitGeometry(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("bed.toml", BED)
        self.write("grains.toml", GRAINS)

    def test_simulate_keeps_a_ledger_and_says_what_leaks_below(self):
        for stack in ("bed.toml", "grains.toml"):
            with self.subTest(stack):
                answer = self.json_of("simulate", stack, "--walks", "4000", "--wi", "40", "--quiet")
                run = answer["runs"][0]
                self.assertNotIn("holes", run)
                for channel in range(len(run["absorbed"])):
                    total = sum(run[key][channel] for key in ("uncollided", "absorbed", "unresolved"))
                    total += sum(run[side]["total"][channel] for side in ("reflected", "transmitted"))
                    self.assertAlmostEqual(total, 1, places=12)

    def test_equal_runs_give_equal_answers_for_any_number_of_threads(self):
        runs = [self.json_of("simulate", "bed.toml", "--walks", "4000", "--wi", "40", "--quiet",
                             "--threads", threads)["runs"][0] for threads in ("1", "2")]
        for run in runs:
            del run["seconds"]
        self.assertEqual(*runs)

    def test_white_furnaces_pass_by_next_event_estimation(self):
        for stack in ("bed.toml", "grains.toml"):
            with self.subTest(stack):
                answer = self.json_of("furnace", stack, "--walks", "4000", "--wi", "60", "--quiet")
                # So few are too noisy to pass by; nothing is lost beyond that noise.
                self.assertEqual(answer["verdict"], "inconclusive")
                [energy], [error] = (answer["runs"][0][key]
                                     for key in ("energy", "energy_standard_error"))
                self.assertLess(abs(energy - 1), 5 * error)
                analog = self.json_of("furnace", stack, "--walks", "4000", "--wi", "60", "--quiet",
                                      "--estimator", "analog")
                self.assertEqual(analog["verdict"], "pass")

    def test_micrograins_stand_on_any_closed_form(self):
        self.write("eon.toml", GRAINS.replace("albedo = 0.2", 'bsdf = "eon"\nroughness = 0.8\n'
                                              "albedo = [0.7, 0.4, 0.2]"))
        answer = self.json_of("compare", "eon.toml", "--walks", "4000", "--wi", "30", "--grid",
                              "4x8", "--quiet", "-o", "eon")
        self.assertEqual(answer["stack"]["substrate"]["bsdf"], "eon")
        self.assertEqual(answer["stack"]["substrate"]["roughness"], 0.8)
        [model] = [m for m in answer["models"] if m["name"] == "micrograin"]
        self.assertEqual(model["parameters"]["bulk"], "eon")
        self.assertEqual(model["parameters"]["bulk_roughness"], 0.8)
        furnace = self.json_of("furnace", "eon.toml", "--walks", "4000", "--wi", "60", "--quiet")
        self.assertNotEqual(furnace["verdict"], "fail")

    def test_a_closed_form_that_is_none_is_an_error_that_says_where(self):
        for name, below, words in (
            ("unknown", 'bsdf = "eno"', ["broken.toml:9", '"bsdf"', '"eno"', "eon"]),
            ("itself", 'bsdf = "micrograin"', ["broken.toml:9", '"micrograin"', "lambert, black"]),
            ("key", 'bsdf = "eon"\nroughnes = 1', ["broken.toml:10", '"roughnes"',
                                                   'did you mean "roughness"?']),
            ("value", 'bsdf = "eon"\nroughness = 2', ["broken.toml:10", '"roughness"', "found 2",
                                                      "[0, 1]"])):
            with self.subTest(name):
                self.write("broken.toml", GRAINS.replace("albedo = 0.2", below))
                answer = self.lamella("simulate", "broken.toml", status=2)
                for word in words:
                    self.assertIn(word, answer.err)

    def test_compare_judges_the_models_that_apply(self):
        answer = self.json_of("compare", "grains.toml", "--walks", "4000", "--wi", "30", "--grid",
                              "4x8", "--quiet")
        self.assertIn("micrograin", [model["name"] for model in answer["models"]])

    def test_truth_at_pairs(self):
        self.write("pairs.csv", "theta_i,phi_i,theta_o,phi_o\n30,0,20,50\n")
        lines = self.lamella("eval", "truth", "stack=bed.toml", "walks=4000", "--pairs",
                             "pairs.csv").out.splitlines()
        f, error = (float(x) for x in lines[1].split(",")[4::3])
        self.assertGreater(f, 5 * error)

    def test_measure_writes_an_equivalent_stack_that_simulates(self):
        answer = self.json_of("measure", "bed.toml", "--walks", "20000", "--quiet", "-o",
                              "medium.toml")
        self.assertEqual(answer["equivalent"]["layer"][0]["medium"], "vmf_flake")
        self.json_of("simulate", "medium.toml", "--walks", "2000", "--wi", "40", "--quiet")
        refused = self.lamella("measure", "sggx_slab", status=2).err
        self.assertIn("allowed: explicit geometry", refused)
        self.assertIn("--fit", self.lamella("measure", "bed.toml", "--wi", "3", status=2).err)

    @unittest.skipUnless(WITH_CERES, "built without Ceres")
    def test_measure_fits_the_roughness_by_lobes(self):
        self.write("deep.toml", BED.replace("thickness = 0.2", "thickness = 0.5").replace("[0.9, 0.6, 0.3]", "0.8"))
        run = ["measure", "deep.toml", "--walks", "20000", "--fit", "--wi", "20", "--wi", "60", "--grid", "4x8",
               "--quiet"]
        answer = self.json_of(*run, "-o", "medium.toml")
        fit = answer["fit"]
        normals, lobes = fit["medium_by_normals"], fit["medium_by_lobes"]
        self.assertEqual(normals["roughness"], answer["measured"]["vmf_roughness"]["value"])
        self.assertLessEqual(lobes["relative_rmse"], normals["relative_rmse"])
        self.assertEqual(lobes["state"], "found")
        self.assertIn(f"roughness = {lobes['roughness']:.6}"[:18], (self.folder / "medium.toml").read_text())
        # A bed of spheres is no medium, but near to one.
        self.assertLess(lobes["relative_rmse_without_noise"], 0.2)
        self.assertLess(fit["vmf_diffuse"]["relative_rmse_without_noise"], 0.25)
        # What fit finds from the same walks: the nearest of the closed form.
        same = self.json_of("fit", "deep.toml", "--model", "vmf_diffuse,albedo=0.8", "--walks", "20000", "--wi", "20",
                            "--wi", "60", "--grid", "4x8", "--quiet")["models"][0]
        self.assertAlmostEqual(same["parameters"][0]["value"], fit["vmf_diffuse"]["roughness"], places=12)
        self.assertIn("--medium", self.lamella("measure", "deep.toml", "--fit", "--walks", "2000", "--medium",
                                               "lambert_sphere", status=2).err)

    def test_reproduce_lists_prints_and_draws(self):
        names = [r["name"] for r in self.json_of("reproduce", "--quiet")["reproductions"]]
        self.assertIn("vmf_figure_6", names)
        answer = self.json_of("reproduce", "micrograin_figure_9", "--walks", "30000", "--quiet", "-o",
                              "figure")
        self.assertEqual(answer["pictures"], ["filling_factor.png"] if WITH_CAIRO else [])
        for picture in answer["pictures"]:
            self.assertTrue((self.folder / "figure" / picture).read_bytes().startswith(b"\x89PNG"))
        zs = [row["z"] for row in answer["rows"]]
        self.assertLess(sum(z * z for z in zs) / len(zs), 2)
        self.assertIn("did you mean", self.lamella("reproduce", "vmf_figur_7", status=2).err)

    def test_explain_says_what_is_traced(self):
        plan = self.json_of("explain", "bed.toml", "--quiet")["plan"]
        self.assertIn("rays are traced", json.dumps(plan))

    def test_grazing_light_and_mirrors_at_points_are_refused_in_words(self):
        self.assertIn("allowed: |mu|", self.lamella("simulate", "bed.toml", "--wi", "90",
                                                    status=2).err)
        self.write("mirror.toml", BED + 'surface = "mirror"\n')
        self.write("pairs.csv", "theta_i,phi_i,theta_o,phi_o\n30,0,20,50\n")
        self.assertIn("allowed: Lambertian grains",
                      self.lamella("eval", "truth", "stack=mirror.toml", "--pairs", "pairs.csv",
                                   status=2).err)


class HeightField(ProgramTest):
    """A rough surface needs no Embree."""

    def setUp(self):
        super().setUp()
        self.write("heights.toml", '[[layer]]\nmedium = "height_field"\nroughness = 0.5\n'
                   'surface = "mirror"\ntile = 16\nresolution = 4\n')

    def test_white_mirrors_keep_the_light_and_stand_beside_facets(self):
        answer = self.json_of("compare", "heights.toml", "--walks", "20000", "--wi", "60", "--quiet", "-o", "out")
        self.assertEqual([model["name"] for model in answer["models"]], 3 * ["microfacet"])
        furnace = self.json_of("furnace", "heights.toml", "--walks", "4000", "--wi", "60", "--quiet",
                               "--estimator", "analog")
        self.assertAlmostEqual(furnace["runs"][0]["energy"][0], 1, delta=1e-12)

    def test_the_text_that_is_shown_is_read_again(self):
        shown = self.lamella("explain", "heights.toml").out.split("colour")[0].split("\n", 1)[1]
        self.write("again.toml", shown)
        self.assertEqual(self.json_of("explain", "again.toml", "--quiet")["stack"]["layer"],
                         self.json_of("explain", "heights.toml", "--quiet")["stack"]["layer"])

    def test_smiths_surface_is_measured_beside_it(self):
        rows = {row["order"]: row for row in self.json_of("measure", "heights.toml", "--walks", "40000", "--wi", "60",
                                                          "--grid", "4x8", "--quiet")["smith"]}
        # White mirrors keep the light, on either surface; 0.869 is the closed form's first order.
        for name in ("height_field", "smith"):
            self.assertAlmostEqual(rows["all"]["energy_" + name], 1, delta=1e-3)
        self.assertAlmostEqual(rows["1"]["energy_smith"], 0.869, delta=4.5 * rows["1"]["energy_smith_error"] + 1e-3)
        # The surfaces are near each other, and not the same.
        self.assertLess(rows["1"]["relative_rmse"], 0.15)
        flat = (self.folder / "heights.toml").read_text().replace("roughness = 0.5", "roughness = 0.05")
        self.write("flat.toml", flat)
        row = self.json_of("measure", "flat.toml", "--walks", "40000", "--wi", "20", "--grid", "4x8", "--quiet")["smith"][0]
        # Facets that hide nothing are the same on both.
        self.assertLess(row["relative_rmse"], max(0.02, row["relative_noise"]))

    def test_what_it_has_not_is_refused(self):
        heights = (self.folder / "heights.toml").read_text()
        self.write("over.toml", heights + "[substrate]\nalbedo = 0.5\n")
        self.assertIn("height_field, which no light passes",
                      self.lamella("simulate", "over.toml", status=2).err)
        self.assertIn("allowed: sphere_bed",
                      self.lamella("measure", "heights.toml", "--medium", "sggx", status=2).err)
        self.write("diffuse.toml", heights.replace("mirror", "lambert"))
        self.assertIn('surface = "mirror"', self.lamella("measure", "diffuse.toml", status=2).err)
        self.write("small.toml", heights.replace("tile = 16", "tile = 2"))
        self.assertIn('key "tile": found 2; allowed: a number in [8, ',
                      self.lamella("simulate", "small.toml", status=2).err)
