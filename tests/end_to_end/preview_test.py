import math

from lamella_program import WITH_CAIRO, ProgramTest

QUIET = ["--size", "32", "--quiet"]
SMALL = ["--size", "16"]
SMOOTH = '[[layer]]\ninterface = "smooth"\nior = 1.5\n'
ROUGH = '[[layer]]\ninterface = "ggx"\nior = 1.5\nroughness = 0.3\n'
LAMBERT = '[substrate]\nbsdf = "lambert"\nalbedo = 0.8\n'


class APreviewShowsStackAndModelsUnderLight(ProgramTest):
    def views(self, *arguments):
        answer = self.json_of("preview", *arguments, *QUIET, "-o", "out")
        return {(v["scene"], v["light"]): {p["name"]: p["mean_luminance"] for p in v["pictures"]}
                for v in answer["views"]}

    def test_as_exr_and_png_with_truth_and_models_side_by_side(self):
        views = self.views("lambert_sphere_halfspace")
        self.assertEqual(len(views), 4)
        for (scene, light), means in views.items():
            name = f"out/{scene}_{light}"
            if WITH_CAIRO:
                self.assertTrue((self.folder / f"{name}.png").read_bytes().startswith(b"\x89PNG"))
            channels = {c["name"]: c["mean"] for c in self.json_of("show", f"{name}.exr", "--quiet")["channels"]}
            for model in means:
                self.assertIn(f"{model}.R", channels)
            self.assertEqual(channels["R"], channels["truth.R"])
            # lambert_sphere_three_term is within 0.2 % of the truth away from grazing, and the
            # table's interpolation within 1 %.
            self.assertAlmostEqual(means["lambert_sphere_three_term"] / means["truth"], 1, delta=0.012)

    def test_white_lambert_under_uniform_light_is_1_everywhere_and_under_the_lamp_a_cosine(self):
        views = self.views("lambert_sphere_halfspace", "--model", "lambert,albedo=1", "--light", "0")
        self.assertAlmostEqual(views["sphere", "environment"]["lambert"], 1, delta=1e-9)
        self.assertAlmostEqual(views["plane", "environment"]["lambert"], 1, delta=1e-9)
        # The mean of the cosine over the disc is 2/3; 32 pixels across leave 1 % of it at the rim.
        self.assertAlmostEqual(views["sphere", "lamp"]["lambert"], 2 / 3, delta=0.01)
        self.assertAlmostEqual(views["plane", "lamp"]["lambert"], math.cos(math.radians(70)), delta=1e-9)

    def test_white_half_space_under_uniform_light_is_seen_as_1(self):
        self.write("white.toml", '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\n')
        means = self.views("white.toml", "--model", "lambert")["sphere", "environment"]
        self.assertAlmostEqual(means["truth"], 1, delta=0.01)

    def test_white_stacks_and_models_are_seen_as_1_at_every_roughness(self):
        models = ["--model", "eon,roughness=1,albedo=1", "--model", "lambert,albedo=1"]
        # Walks for the narrow ones, of which the solver cannot have enough modes; both for 0.5.
        for roughness, by in ((0.02, ["--walks", "200"]), (0.05, ["--walks", "200"]),
                              (0.5, ["--walks", "200"]), (0.5, [])):
            self.write("white.toml", f'[[layer]]\nmedium = "sggx"\nroughness = {roughness}\nthickness = inf\n')
            views = self.views("./white.toml", *models, *by)
            for scene in ("sphere", "plane"):
                for name, mean in views[scene, "environment"].items():
                    with self.subTest(roughness=roughness, scene=scene, name=name, by=by):
                        self.assertAlmostEqual(mean, 1, delta=0.005)
                # So is every pixel (of the sphere: tests/compare/preview; around it is nothing).
                shown = self.json_of("show", f"out/{scene}_environment.exr", "--quiet")["channels"]
                for channel in shown:
                    self.assertLess(channel["greatest"], 1.005, (roughness, scene, channel["name"]))
                    if scene == "plane":
                        self.assertGreater(channel["least"], 0.995, (roughness, channel["name"]))

    def test_equal_runs_are_equal_whatever_the_number_of_threads(self):
        self.write("rough.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.2\nthickness = 3\nalbedo = [1, 0.8, 0.5]\n')
        self.lamella("preview", "lambert_sphere_halfspace", *QUIET, "--model", "lambert", "-o", "light")
        files = []
        for threads in ("1", "2", "5"):
            self.lamella("preview", "./rough.toml", *QUIET, "--model", "single_scattering", "--walks", "200",
                         "--environment", "light/sphere_lamp.exr", "--threads", threads, "-o", threads)
            files.append((self.folder / threads / "sphere_environment.exr").read_bytes())
        self.assertEqual(files[1], files[0])
        self.assertEqual(files[2], files[0])

    def test_walks_and_the_solver_show_the_same(self):
        solved = self.views("sggx_slab", "--model", "lambert")
        walked = self.views("sggx_slab", "--model", "lambert", "--estimator", "next-event", "--walks", "4000")
        for view, means in solved.items():
            self.assertAlmostEqual(walked[view]["truth"] / means["truth"], 1, delta=0.02)

    def test_an_environment_is_a_lat_long_exr(self):
        # Any EXR with R, G, B will do: one that shines like a preview.
        self.lamella("preview", "spongecake_copper", *QUIET, "--model", "lambert", "-o", "light")
        self.views("sggx_slab", "--model", "lambert", "--environment", "light/sphere_lamp.exr")
        self.write("no.exr", "no")
        self.assertIn("no.exr", self.lamella("preview", "sggx_slab", "--environment", "no.exr",
                                             status=2).err)

    def test_compare_has_one_too(self):
        answer = self.json_of("compare", "lambert_sphere_halfspace", "--wi", "60", "--walks", "3000",
                              "--preview", "--quiet", "--model", "lambert_sphere", "-o", "out")
        alone = self.json_of("preview", "lambert_sphere_halfspace", "--model", "lambert_sphere", "--quiet")
        self.assertEqual(answer["previews"], alone["views"])
        for view in answer["previews"]:
            for end in ("exr", "png") if WITH_CAIRO else ("exr",):
                self.assertTrue((self.folder / f"out/preview_{view['scene']}_{view['light']}.{end}").exists())
        self.assertEqual(self.json_of("compare", "lambert_sphere_halfspace", "--wi", "60", "--walks", "3000",
                                      "--quiet", "--model", "lambert_sphere", "-o", "none").get("previews"), None)
        self.assertIn("compare --preview", self.lamella("compare", "sphere_bed_dense", "--preview",
                                                        status=2).err)

    def test_coats_are_drawn_with_their_mirror_images(self):
        # Lambert's ground under a smooth coat, beside the closed form that is exact there.
        self.write("coat.toml", SMOOTH + LAMBERT)
        views = self.views("./coat.toml", "--model",
                           "coated,roughness=0,layering=saunderson,base=lambert,base.albedo=0.8")
        for view, means in views.items():
            with self.subTest(view):
                self.assertAlmostEqual(means["coated"] / means["truth"], 1, delta=2e-3)
        # What a mirror shows of a lamp that faces it, F times the lamp's irradiance, is in the
        # mean.
        self.write("black.toml", SMOOTH + LAMBERT.replace("0.8", "0"))
        answer = self.json_of("preview", "./black.toml", "--model", "lambert", "--light", "0",
                              "--size", "512",
                              "--quiet", "-o", "out")
        # Mirrors send a lamp's light evenly everywhere: the radiance has the mean F / 4.
        self.assertAlmostEqual(answer["views"][0]["pictures"][0]["mean_luminance"], 0.04 / 4, delta=0.04 / 4 * 0.03)

    def test_white_stacks_under_coats_are_seen_as_1(self):
        spheres = '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\n'
        for name, text, by in (("smooth", SMOOTH + spheres, []),
                               ("two", SMOOTH + SMOOTH.replace("1.5", "1.2") + spheres, []),
                               ("smooth over white", SMOOTH + LAMBERT.replace("0.8", "1"), []),
                               ("multiple", ROUGH + 'scattering = "multiple"\n' + LAMBERT.replace("0.8", "1"),
                                ["--walks", "300"])):
            self.write("white.toml", text)
            means = self.views("./white.toml", "--model", "lambert,albedo=1", *by)
            for scene in ("sphere", "plane"):
                with self.subTest(name=name, scene=scene):
                    self.assertAlmostEqual(means[scene, "environment"]["truth"], 1, delta=0.005)

    def test_rough_coats_and_metals_are_drawn_by_solver_and_walks(self):
        self.write("rough.toml", ROUGH + LAMBERT)
        model = ["--model", "coated,roughness=0.3,layering=saunderson,base=lambert,base.albedo=0.8"]
        solved = self.views("./rough.toml", *model)
        # Tables of 1000 walks a direction scatter by 3 %.
        walked = self.views("./rough.toml", *model, "--walks", "16000")
        for view, means in solved.items():
            with self.subTest(view):
                self.assertAlmostEqual(means["coated"] / means["truth"], 1, delta=5e-3)
                self.assertAlmostEqual(walked[view]["truth"] / means["truth"], 1, delta=0.03)
        metal = self.views("rough_metal", "--model",
                           "microfacet,distribution=ggx,roughness=0.3,eta=0.2,0.92,1.1,k=3.91,2.45,2.14")
        for view, means in metal.items():
            with self.subTest(view):
                self.assertAlmostEqual(means["microfacet"] / means["truth"], 1, delta=2e-3)

    def test_surfaces_too_smooth_for_a_lobe_are_drawn_as_smooth(self):
        self.write("smooth.toml", SMOOTH + LAMBERT)
        self.write("nearly.toml", ROUGH.replace("0.3", "0.001") + LAMBERT)
        answer = self.json_of("preview", "./nearly.toml", "--model", "lambert", *QUIET, "-o", "nearly")
        self.assertIn("drawn as smooth", answer["truth"])
        nearly = [v["pictures"][0]["mean_luminance"] for v in answer["views"]]
        smooth = [means["truth"] for means in self.views("./smooth.toml", "--model", "lambert").values()]
        self.assertEqual(nearly, smooth)

    def test_what_cannot_be_drawn_is_refused(self):
        self.write("unequal.toml", SMOOTH + '[substrate]\nbsdf = "openpbr_diffuse"\n')
        self.write("leaning.toml", '[[layer]]\nmedium = "vmf_flake"\naxis = [1, 0, 1]\nroughness = 0.5\n'
                   "thickness = 1\n")
        for arguments, part in ((["./leaning.toml"], "flakes that lean"),
                                (["sphere_bed_dense"], "explicit geometry"),
                                (["./unequal.toml"], "not reciprocal"),
                                (["sggx_slab", "--light", "200"], "--light"),
                                (["sggx_slab", "--size", "4"], "16 to 2048")):
            with self.subTest(arguments):
                self.assertIn(part, self.lamella("preview", *arguments, status=2).err)
