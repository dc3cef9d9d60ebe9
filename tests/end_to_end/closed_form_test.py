import math
import os
import shutil

from lamella_program import WITH_CERES, ProgramTest


class ClosedFormCommands(ProgramTest):
    def test_samplers_of_eon_keep_the_albedo_and_save_variance_at_grazing(self):
        answer = self.json_of("samplers", "--samples", "20000", "--wo", "80", "--quiet",
                              "--model", "eon,roughness=1,sampler=cosine",
                              "--model", "eon,roughness=1,sampler=mis")
        cosine, mis = (m["rows"][0] for m in answer["models"])
        for row in (cosine, mis):
            self.assertLess(abs(row["mean"] - row["albedo"]), 5 * row["standard_error"])
        self.assertLess(mis["variance"], 0.2 * cosine["variance"])
        self.assertLess(mis["max_weight"], 2)

    def test_samplers_without_a_model_makes_the_figures_and_the_timing_table(self):
        answer = self.json_of("samplers", "--samples", "200", "--wo", "60", "--quiet")
        self.assertEqual([m["request"] for m in answer["models"][:5]],
                         [f"eon,roughness=1,sampler={s}"
                          for s in ("uniform", "cosine", "ltc", "cltc", "mis")])
        self.assertIn("eon", [t["model"] for t in answer["times"]])

    def test_invert_finds_the_albedo_of_a_model(self):
        answer = self.json_of("invert", "eon", "color=0.8,0.4,0.1", "roughness=1", "--quiet")
        for target, reached in zip(answer["color"], answer["reached"]):
            self.assertAlmostEqual(target, reached, delta=1e-8)
        r, g, b = answer["albedo"]
        pairs = self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n1,0,1,0\n")
        rows = self.lamella("eval", "eon.albedo", "roughness=1", f"albedo={r!r},{g!r},{b!r}",
                            "--pairs", pairs).out.splitlines()
        for value, target in zip(rows[1].split(",")[4:], answer["color"]):
            self.assertAlmostEqual(float(value), target, delta=1e-8)

    def test_invert_finds_the_albedo_of_a_stack_and_its_error(self):
        answer = self.json_of("invert", "lambert_sphere_halfspace", "color=0.5", "--bond",
                              "--walks", "1e5", "--quiet")
        # The Bond albedo 0.5 of a half space of Lambert spheres: eq. 46 of d'Eon 2021 gives 0.8733
        # with a stated error of 0.0063.
        k = 1 - 0.5
        published = (1 - k ** 2.73556) / (1 - 0.184096 * k ** 2.48423)
        self.assertLess(abs(answer["albedo"][0] - published),
                        0.0063 + 5 * answer["albedo_standard_error"][0])

    def test_invert_takes_the_colour_of_a_measured_material(self):
        model = ["vmf_diffuse", "roughness=0.5"]
        self.lamella("export", "vmf_diffuse,roughness=0.5,albedo=0.9,0.5,0.2", "--to", "merl",
                     "-o", "paint.binary", "--quiet")
        answer = self.json_of("invert", *model, "albedo=paint.binary", "--wi", "40", "--quiet")
        self.assertEqual(answer["files"][0]["name"], "paint.binary")
        # A reader of the file gets f back within 0.04 % of its root mean square.
        for found, given in zip(answer["albedo"], (0.9, 0.5, 0.2)):
            self.assertAlmostEqual(found, given, delta=1e-3)
        (self.folder / "cut.binary").write_bytes(b"\x5a\x00\x00\x00")
        self.assertIn("cut.binary", self.lamella("invert", *model, "albedo=cut.binary", status=2).err)

    def test_invert_says_which_colours_can_be_had(self):
        answer = self.lamella("invert", "fon", "roughness=1", "color=0.95", status=2)
        self.assertIn('key "color": found 0.95; allowed: from 0', answer.err)
        self.assertIn("albedo 1", answer.err)
        self.lamella("invert", "fon", status=2)
        self.lamella("invert", "fon", "color=0.5", "albedo=1", status=2)
        self.lamella("invert", "no_such_thing", "color=0.5", status=2)

    def test_fit_gives_a_model_that_is_nearer_to_the_truth(self):
        if not WITH_CERES:
            self.skipTest("built without Ceres")
        answer = self.json_of("fit", "sggx_slab", "--walks", "1e5", "--quiet", "-o", "fit.txt")
        self.assertLess(answer["relative_rmse"], 0.5)
        request = (self.folder / "fit.txt").read_text().strip()
        self.assertEqual(request, answer["model"])
        compared = self.json_of("compare", "sggx_slab", "--walks", "1e5", "--quiet", "--wi", "30",
                                "--model", "spongecake,lobes=none", "--model", request)
        before, after = ([l["relative_rmse_without_noise"] for l in m["lobes"]
                          if l["order"] == "all" and l["side"] == "reflect"][0]
                         for m in compared["models"])
        self.assertLess(after, 0.5 * before)

    def test_furnace_sweep(self):
        answer = self.json_of("furnace", "--sweep", "--quiet", "--model", "eon", "--model", "fon")
        eon, fon = answer["sweep"]
        self.assertEqual(eon["configurations"], 5)
        for extreme in (eon["least"], eon["most"]):
            self.assertAlmostEqual(extreme["energy"], 1, delta=1e-12)
        self.assertAlmostEqual(fon["least"]["energy"], 0.7764, delta=1e-3)
        self.assertEqual(fon["least"]["parameters"], "roughness=1")
        for sweep in (eon, fon):
            self.assertTrue(0 < sweep["worst_error"] < 1e-6)
        table = self.lamella("furnace", "--sweep", "--model", "eon").out.splitlines()
        self.assertEqual(table[0].split(" | ")[-1], "error |")
        self.assertRegex(table[2], r"\| [0-9]e-[0-9]+ \|$")

    def test_furnaces_of_models_name_no_stack_that_they_know_nothing_of(self):
        self.assertNotIn("stack", self.json_of("furnace", "--model", "eon", "--wi", "60", "--quiet"))
        named = self.json_of("furnace", "sggx_slab", "--model", "eon", "--wi", "60", "--quiet")
        self.assertEqual(named["stack"]["name"], "sggx_slab")
        own = self.json_of("furnace", "--model", "single_scattering,stack=hg_slab", "--wi", "60", "--max-error", "9",
                           "--quiet")
        self.assertEqual(own["stack"]["name"], "hg_slab")

    def test_samplers_tell_the_error_of_the_albedo(self):
        answer = self.json_of("samplers", "--model", "vmf_diffuse,roughness=0.5", "--samples", "1000", "--quiet")
        for row in answer["models"][0]["rows"]:
            self.assertTrue(0 <= row["albedo_error"] < 1e-6)

    def test_stochastic_models_give_their_standard_error(self):
        pairs = self.write("pairs.csv", "theta_i,phi_i,theta_o,phi_o\n60,0,30,50\n")
        out = self.lamella("eval", "beckmann_diffuse", "alpha=1", "--pairs", pairs).out
        header, row = out.splitlines()
        self.assertTrue(header.endswith(",f,se"))
        f, se = (float(x) for x in row.split(",")[4:])
        self.assertTrue(0 < se < 0.1 * f)
        repeat = self.lamella("eval", "beckmann_diffuse", "alpha=1", "--pairs", pairs).out
        self.assertEqual(out, repeat)
        for part in ("f1", "f2", "f3", "fm", "albedo"):
            header, row = self.lamella("eval", f"beckmann_diffuse.{part}", "alpha=1", "albedo=0.5",
                                       "--pairs", pairs).out.splitlines()
            self.assertTrue(header.endswith(",f,se"), part)
            self.assertGreater(float(row.split(",")[5]), 0, part)


class AClosedFormAsTheTruth(ProgramTest):
    def test_models_are_compared_with_it(self):
        answer = self.json_of("compare", "--truth", "eon,albedo=0.8,roughness=0.5", "--model", "lambert,albedo=0.8",
                              "--model", "eon,albedo=0.8,roughness=0.5", "--wi", "30", "--grid", "4x8", "--quiet", "-o", "models")
        lambert, same = (m["lobes"][0] for m in answer["models"])
        # EON's own albedo, by quadrature in the tests of its room; cells project within 1e-4.
        self.assertAlmostEqual(same["relative_rmse"], 0, delta=1e-4)
        self.assertEqual(same["verdict"], "agrees")
        self.assertEqual(lambert["verdict"], "differs")
        self.assertAlmostEqual(lambert["energy_model"][0], 0.8, delta=1e-4)
        # Transmission, too, from both sides.
        glass = self.json_of("compare", "--truth", "microfacet,material=dielectric,roughness=0.5", "--model",
                             "microfacet,material=dielectric,roughness=0.5", "--wi", "30", "--wi", "150", "--grid", "4x8",
                             "--quiet", "-o", "glass")
        lobes = glass["models"][0]["lobes"]
        self.assertEqual([(l["side"], l["verdict"]) for l in lobes], 2 * [("reflect", "agrees"), ("transmit", "agrees")])
        self.assertIn("nothing to", self.lamella("rerun", "glass/truth.exr", status=2).err)

    def test_what_makes_no_sense_is_refused(self):
        for words, told in ((["--truth", "eon"], "--model"), (["sggx_slab", "--truth", "eon", "--model", "lambert"], "sggx_slab"),
                            (["--truth", "nonsense", "--model", "lambert"], "nonsense"),
                            (["--truth", "eon", "--model", "lambert", "--shard", "1/2", "-o", "a.part"], "--truth"),
                            (["--truth", "eon", "--model", "lambert", "--preview"], "--preview")):
            self.assertIn(told, self.lamella("compare", *words, status=2).err)


class Tables(ProgramTest):
    def test_series_and_albedos_are_tabulated(self):
        legendre = self.json_of("tabulate", "media.henyey_greenstein", "g=0.7", "--of", "legendre", "--terms", "3")
        self.assertEqual(legendre["columns"], ["l", "chi", "error"])
        for l, chi, error in legendre["rows"]:
            self.assertAlmostEqual(chi, 0.7**l, delta=1e-12)
        self.lamella("tabulate", "lambert", "albedo=0.9,0.5,0.1", "--mu-i", "0.5", "--mu-o", "1", "--terms", "2", "-o", "l.csv")
        header, first, second = (self.folder / "l.csv").read_text().splitlines()
        self.assertEqual(header, "mu_i,mu_o,m,value_r,value_g,value_b,error")
        self.assertAlmostEqual(float(first.split(",")[4]), 0.5 / math.pi, delta=1e-15)
        self.assertAlmostEqual(float(second.split(",")[4]), 0, delta=1e-15)
        albedo = self.json_of("tabulate", "eon", "roughness=0.5", "albedo=1", "--of", "albedo", "--mu-i", "0.3")
        self.assertAlmostEqual(albedo["rows"][0][1], 1, delta=1e-7)

    def test_what_cannot_be_tabulated_is_refused(self):
        for words in (["media.sggx", "axis=1,0,0"], ["media.sggx", "--of", "legendre"], ["eon", "--of", "legendre"],
                      ["media.sggx", "--of", "albedo"], ["eon", "--mu-i", "0"], ["eon", "--mu-o", "-0.5"], ["nonsense"],
                      ["media.nonsense"], ["eon", "--terms", "0"]):
            self.assertIn("allowed:", self.lamella("tabulate", *words, status=2).err)


class ModelsOfOnesOwn(ProgramTest):
    def test_the_example_is_judged_like_any_other(self):
        shutil.copy(os.path.join(os.environ["LAMELLA_PLUGINS"], "minnaert.so"), self.folder)
        answer = self.json_of("compare", "lambert_sphere_halfspace", "--walks", "2e4", "--quiet",
                              "--wi", "60", "--model", "./minnaert.so,albedo=0.6,k=0.8")
        self.assertEqual(answer["models"][0]["name"], "minnaert")
        pairs = self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n1,0,1,0\n")
        rows = self.lamella("eval", "./minnaert.so.pdf", "k=1", "--pairs", pairs).out.splitlines()
        self.assertAlmostEqual(float(rows[1].split(",")[4]), 0.3183098861837907, places=12)
        self.lamella("furnace", "--model", "./minnaert.so,k=1", "--quiet")
        self.lamella("furnace", "--model", "./minnaert.so,k=0.5", "--quiet", status=1)

    def test_single_precision_ends_with_its_error(self):
        folder = os.environ["LAMELLA_PLUGINS"]
        keys = "alpha=0.3,roughness=0.7,albedo=0.8"
        runs = {}
        for name in ("single_precision", "double_precision"):
            answer = self.json_of("furnace", "--as-is", "--quiet", "--max-error", "10", "--model",
                                  f"{folder}/{name}.so,{keys}")
            runs[name] = answer["runs"]
        for one, right in zip(runs["single_precision"], runs["double_precision"]):
            self.assertEqual(right["ended_by"], "tolerance")
            for e, error, exact, bound in zip(one["energy"], one["energy_error"],
                                              right["energy"], right["energy_error"]):
                self.assertLess(error, 1e-4)
                self.assertLessEqual(abs(e - exact), error + bound)
        pairs = self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,1,0\n")
        answer = self.lamella("eval", f"{folder}/single_precision.so.albedo", "alpha=0.3",
                              "--pairs", pairs)
        header, row = answer.out.splitlines()
        self.assertTrue(header.endswith(",f,se"))
        self.assertGreater(float(row.split(",")[5]), 0)
        self.assertEqual(answer.err.count("\n"), 1)
        self.assertIn("ended by noise", answer.err)

    def test_whatever_its_values_a_furnace_ends(self):
        folder = os.environ["LAMELLA_PLUGINS"]
        for kind, ended, status in ((0, "noise", 0), (1, "limit", 1), (2, "limit", 1),
                                    (7, "noise", 0)):
            with self.subTest(kind):
                answer = self.json_of("furnace", "--quiet", "--wi", "40", "--model",
                                      f"{folder}/hostile.so,kind={kind}", status=status)
                self.assertEqual(answer["runs"][0]["ended_by"], ended)
                # Noise, and a checkerboard that looks like it, leave errors above the tolerance.
                self.assertEqual(answer["verdict"], "fail" if status else "inconclusive")
        for kind in (4, 5, 6):
            with self.subTest(kind):
                answer = self.lamella("furnace", "--quiet", "--model",
                                      f"{folder}/hostile.so,kind={kind}", status=3)
                self.assertEqual(len(answer.err.splitlines()), 1)

    def test_a_projection_that_stays_open_is_told(self):
        # A checkerboard far finer than the panels of a cell: its cells are known to the last change
        # of their quadrature, which the comparison leaves out of its verdict and tells in a line.
        model = os.environ["LAMELLA_PLUGINS"] + "/hostile.so,kind=7"
        arguments = ("compare", "lambert_sphere_halfspace", "--walks", "2e4", "--wi", "60", "--grid",
                     "2x4", "--model", model)
        text = self.lamella(*arguments).out
        line = [line for line in text.splitlines() if "leaves open up to" in line]
        self.assertEqual(len(line), 1, text)
        lobes = self.json_of(*arguments, "--quiet")["models"][0]["lobes"]
        share = max(lobe["projection_open"] for lobe in lobes)
        self.assertGreater(share, 1e-4)
        # A smooth form leaves nothing open.
        smooth = self.json_of(*arguments[:-1], "eon,albedo=0.5,roughness=0.5", "--quiet")
        for lobe in smooth["models"][0]["lobes"]:
            self.assertEqual(lobe["projection_open"], 0)

    def test_broken_ones_are_refused(self):
        folder = os.environ["LAMELLA_PLUGINS"]
        for name, status in (("no_symbol", 2), ("wrong_version", 2), ("no_eval", 2),
                             ("not_a_number", 3), ("negative", 3), ("silent", 3)):
            with self.subTest(name):
                answer = self.lamella("compare", "sggx_slab", "--walks", "1000", "--quiet",
                                      "--model", f"{folder}/{name}.so", status=status)
                self.assertIn(f"{name}.so: ", answer.err)
                self.assertEqual(len(answer.err.splitlines()), 1)
