import math

from lamella_program import WITH_CAIRO, ProgramTest

QUIET = ["--size", "32", "--quiet"]
SMALL = ["--size", "16"]


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
        self.assertIn("compare --preview", self.lamella("compare", "spongecake_window_shade", "--preview",
                                                        status=2).err)

    def test_what_cannot_be_drawn_is_refused(self):
        for arguments, part in ((["spongecake_window_shade"], "symmetric"),
                                (["sphere_bed_dense"], "explicit geometry"),
                                (["sggx_slab", "--light", "200"], "--light"),
                                (["sggx_slab", "--size", "4"], "16 to 2048")):
            with self.subTest(arguments):
                self.assertIn(part, self.lamella("preview", *arguments, status=2).err)
