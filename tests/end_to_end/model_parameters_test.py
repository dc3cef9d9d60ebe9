"""Where a model's parameters come from, and SpongeCake's lobes."""

import unittest

from lamella_program import WITH_CERES, WITH_EMBREE, ProgramTest, check_schema

SHORT = ["--walks", "2e4", "--wi", "60", "--grid", "4x8"]


class FromTheStack(ProgramTest):
    def model(self, *arguments):
        return self.json_of("compare", *arguments, *SHORT, "--quiet")["models"][0]

    def test_what_both_have_a_name_for_is_taken(self):
        for stack, request, key, value in (
                ("lambert_sphere_halfspace", "vmf_diffuse", "albedo", 0.9),
                ("lambert_sphere_halfspace", "lambert", "albedo", 0.9),
                ("sggx_slab", "eon", "roughness", 0.5),
                ("sggx_slab", "eon", "albedo", 0.9),
                *([("micrograins_dust", "lambert", "albedo", 0.8)] if WITH_EMBREE else [])):
            with self.subTest(f"{request} on {stack}: {key}"):
                model = self.model(stack, "--model", request)
                self.assertEqual(model["parameters"][key], value)
                self.assertEqual(model["parameter_sources"][key], "stack")

    def test_explicit_keys_win_and_defaults_are_told(self):
        model = self.model("sggx_slab", "--model", "eon,albedo=0.3")
        self.assertEqual(model["parameters"]["albedo"], 0.3)
        self.assertEqual(model["parameter_sources"]["albedo"], "given")
        model = self.model("lambert_sphere_halfspace", "--model", "eon")
        self.assertEqual(model["parameter_sources"]["roughness"], "default")
        self.assertEqual(set(model["parameters"]), set(model["parameter_sources"]))

    def test_of_several_layers_what_they_agree_on(self):
        model = self.model("spongecake_two_layer", "--model", "eon")
        self.assertEqual(model["parameters"]["albedo"], 0.9)
        self.assertEqual(model["parameter_sources"]["albedo"], "stack: all 2 layers")
        self.assertEqual(model["parameter_sources"]["roughness"],
                         "default; the layers have 0.5, 0.9")

    def test_what_the_model_does_not_allow_is_said(self):
        self.write("stack.toml", '[[layer]]\nmedium = "henyey_greenstein"\ng = 0.5\nalbedo = 0.4\n'
                                 "thickness = inf\n")
        # Dielectric grains are no model's own; names are enough.
        self.write("grains.toml", '[[layer]]\nmedium = "micrograins"\ntau0 = 0.3\nbeta = 0.7\n'
                                  'surface = "dielectric"\nalbedo = 0.6\n\n[substrate]\nalbedo = 0.2\n')
        model = self.model("stack.toml", "--model", "micrograin")
        self.assertEqual(model["parameters"]["albedo"], 0.4)
        if not WITH_EMBREE:
            return
        model = self.model("grains.toml", "--model", "micrograin")
        for key, value in (("tau0", 0.3), ("beta", 0.7), ("surface", "dielectric"),
                           ("albedo", 0.6), ("bulk_albedo", 0.2)):
            self.assertEqual(model["parameters"][key], value)
            self.assertTrue(model["parameter_sources"][key].startswith("stack"), key)

    def test_the_headline_names_every_parameter(self):
        out = self.lamella("compare", "lambert_sphere_halfspace", "--model", "vmf_diffuse", *SHORT).out
        self.assertIn("albedo = 0.9 (stack), roughness = 0.5 (default), sampler = ", out)

    def test_a_furnace_without_a_stack_takes_nothing_from_one(self):
        answer = self.json_of("furnace", "--model", "eon", "--quiet")
        self.assertEqual(answer["models"][0]["parameter_sources"]["roughness"], "default")
        self.assertEqual(answer["models"][0]["parameter_sources"]["albedo"], "white")
        answer = self.json_of("furnace", "spongecake_sheen", "--model", "eon", "--quiet")
        self.assertEqual(answer["models"][0]["parameters"]["roughness"], 0.1)

    @unittest.skipUnless(WITH_EMBREE, "built without Embree")
    def test_keys_of_a_bulk_are_its_own(self):
        model = self.model("micrograins_dust", "--model", "micrograin,bulk=beckmann_diffuse,bulk_alpha=2")
        self.assertEqual(model["parameters"]["bulk_alpha"], 2)
        self.assertNotIn("bulk_sigma", model["parameters"])
        answer = self.lamella("compare", "micrograins_dust", "--model",
                              "micrograin,bulk=eon,bulk_sigma=0.3", *SHORT, status=2)
        self.assertIn('key "bulk_sigma": unknown', answer.err)
        self.assertIn("bulk_roughness", answer.err)
        listed = next(m for m in self.json_of("models", "--quiet")["models"]
                      if m["name"] == "micrograin")
        self.assertEqual(listed["selector"], "bulk")
        self.assertIn("bulk_roughness", [p["name"] for p in listed["selected"]["eon"]])


class Spongecake(ProgramTest):
    def all_orders(self, model):
        return next(l["relative_rmse_without_noise"] for l in model["lobes"]
                    if l["order"] == "all" and l["side"] == "reflect")

    def test_is_fitted_unless_asked_not_to_be(self):
        answer = self.json_of("compare", "sggx_slab", *SHORT, "--quiet", "--model", "spongecake",
                              "--model", "spongecake,lobes=none", "--model", "single_scattering",
                              "--model", "spongecake,lambert_reflect=0.1", "--model", "spongecake,lobes=fit")
        network, none, single, given, fitted = answer["models"]
        self.assertEqual(network["parameters"]["lobes"], "network")
        self.assertEqual(network["parameter_sources"]["second_weight"], "network")
        self.assertLess(self.all_orders(network), 0.5 * self.all_orders(none))
        self.assertEqual(fitted["parameters"]["lobes"], "fit")
        self.assertEqual(fitted["parameter_sources"]["second_weight"], "fit")
        # Orders 2 and up by themselves: nothing stands for them without lobes.
        self.assertEqual([l["order"] for l in none["lobes"] if l["side"] == "reflect"], ["1", "all", "2+"])
        for lobe in none["lobes"]:
            if lobe["order"] == "2+":
                self.assertAlmostEqual(lobe["relative_rmse_without_noise"], 1, places=3)
        self.assertLess(self.all_orders(fitted), 0.5 * self.all_orders(none))
        self.assertAlmostEqual(self.all_orders(none), self.all_orders(single), places=12)
        self.assertEqual((given["parameters"]["lobes"], given["parameters"]["second_weight"]),
                         ("given", 0))

    def test_takes_the_network_of_one_or_two_layers_within_its_ranges_and_says_why_not(self):
        model = self.json_of("compare", "spongecake_two_layer", *SHORT, "--quiet", "--model", "spongecake")["models"][0]
        self.assertEqual(model["parameters"]["lobes"], "network")
        self.assertEqual(model["parameter_sources"]["second_roughness_2"], "network")
        told = self.lamella("compare", "spongecake_two_layer", *SHORT, "--model", "spongecake,lobes=none",
                            "--model", "spongecake").out
        self.assertIn("second_roughness_2", told)
        self.assertNotIn("second_roughness_3", told)
        self.assertEqual(told.count("second_roughness_2"), 1)
        layer = '[[layer]]\nmedium = "sggx"\nshape = "surface"\nroughness = 0.5\nalbedo = 0.3\nthickness = {}\n'
        why = {"deep.toml": "depth 12 of layer 0 is outside of the trained 0.02 to 10",
               "three.toml": "3 layers, and the networks are trained on one and two"}
        self.write("deep.toml", layer.format(12))
        self.write("three.toml", 3 * layer.format(0.3))
        for name, reason in why.items():
            refused = self.lamella("compare", name, *SHORT, "--model", "spongecake,lobes=network", status=2)
            self.assertIn(reason, refused.err)
            model = self.json_of("compare", name, *SHORT, "--quiet", "--model", "spongecake")["models"][0]
            self.assertEqual(model["parameters"]["lobes"], "fit" if WITH_CERES else "none")
            self.assertIn(reason, model["parameter_sources"]["lobes"])

    def test_fit_writes_what_model_reads(self):
        fit = self.json_of("fit", "sggx_slab", "--quiet", "-o", "fit.txt")
        answer = self.json_of("compare", "sggx_slab", *SHORT, "--quiet", "--model", "@fit.txt",
                              "--model", fit["model"], "--model", "spongecake,lobes=fit")
        from_file, given, default = (m["parameters"] for m in answer["models"])
        self.assertEqual(from_file, given)
        # By the key it is what fit finds.
        self.assertEqual({**default, "lobes": "given"}, from_file)

    def test_a_file_that_holds_no_model_is_refused(self):
        self.write("two.txt", "lambert\n# a comment\n\neon\n")
        self.write("none.txt", "# nothing\n")
        for name, words in (("two.txt", ["two.txt:4", "a second model"]),
                            ("none.txt", ["none.txt:1", "no model"]),
                            ("absent.txt", ["absent.txt", "No such file"])):
            with self.subTest(name):
                answer = self.lamella("compare", "sggx_slab", "--model", "@" + name, *SHORT, status=2)
                self.assertEqual(len(answer.err.splitlines()), 1, answer.err)
                for word in words:
                    self.assertIn(word, answer.err)

    def test_no_lobes_beside_lobes(self):
        answer = self.lamella("compare", "sggx_slab", "--model",
                              "spongecake,lobes=none,second_weight=1", *SHORT, status=2)
        self.assertIn('key "lobes"', answer.err)

    def test_where_nothing_can_be_fitted_it_says_so(self):
        self.write("black.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.5\nalbedo = 0\nthickness = 1\n')
        model = self.json_of("compare", "black.toml", *SHORT, "--quiet", "--model", "spongecake")["models"][0]
        self.assertEqual(model["parameters"]["lobes"], "none")
        self.assertIn("not fitted", model["parameter_sources"]["lobes"])

    def test_a_furnace_asks_for_a_stack(self):
        answer = self.lamella("furnace", "--model", "spongecake", status=2)
        self.assertEqual(len(answer.err.splitlines()), 1, answer.err)
        self.assertIn("found no stack", answer.err)
        self.lamella("furnace", "--model", "spongecake,stack=sggx_slab,lobes=none", "--max-error",
                     "1", "--quiet")

    def test_the_key_stack_is_known(self):
        self.json_of("compare", "sggx_slab", *SHORT, "--quiet", "--model",
                     "single_scattering,stack=sggx_slab")
        answer = self.lamella("compare", "sggx_slab", *SHORT, "--model",
                              "single_scattering,stack=hg_slab", status=2)
        self.assertIn('key "stack": found "hg_slab"', answer.err)

    def test_fit_needs_no_number_of_walks(self):
        answer = self.json_of("fit", "hg_slab", "--quiet")
        self.assertLess(answer["noise"], 0.26 * answer["relative_rmse"])
        check_schema("fit", answer)


if __name__ == "__main__":
    unittest.main()
