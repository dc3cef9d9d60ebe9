"""preview --shape: paths on objects, by walks, closed forms and tables."""

import json
import math
import os
import unittest

from lamella_program import WITH_CAIRO, WITH_EMBREE, ProgramTest, check_schema
from exr_writer import Part, exr_bytes

# What a picture of walks refuses: built-in stacks of grids and of explicit geometry.
NO_PICTURES = {"woven_cloth", "settled_dust", "blotchy_layer", "sphere_bed_dilute", "sphere_bed_dense",
               "sphere_bed_packed", "micrograins_dust"}
MANY = 16 if "LAMELLA_SOAK" in os.environ else 1
# Gauss and Legendre's nodes and weights on [0, 1]: albedos over a cosine, which they integrate
# within 1e-5.
GAUSS = [(0.5 + sign * x / 2, w / 2) for x, w in ((0.238619186083197, 0.467913934572691),
                                                  (0.661209386466265, 0.360761573048139),
                                                  (0.932469514203152, 0.171324492379170)) for sign in (-1, 1)]


def loses_light(stack):
    """Whether facets hide light of single scattering in the shadow of others."""
    parts = stack.get("layer", []) + ([stack["substrate"]] if "substrate" in stack else [])
    return any(part.get("scattering") == "single" for part in parts)


class PathsOnAnObject(ProgramTest):
    def traced(self, *arguments):
        answer = self.json_of("preview", *arguments, "--quiet", "-o", "out")
        return {picture["name"]: picture for picture in answer["traced"]["pictures"]}

    def test_see_every_white_stack_as_its_furnace(self):
        names = [stack["name"] for stack in self.json_of("stacks")["stacks"]]
        self.assertLessEqual(NO_PICTURES, set(names))
        seen = []
        for seed, stack in enumerate(names):
            with self.subTest(stack):
                run = ["preview", stack, "--white", "--shape", "sphere", "--light", "none", "--size", "16",
                       "--samples", str(32 * MANY), "--seed", str(seed + 1), "--model", "lambert,albedo=1", "--quiet",
                       "-o", "out"]
                if stack in NO_PICTURES:
                    self.assertIn("homogeneous layers", self.lamella(*run, status=2).err)
                    continue
                answer = self.json_of(*run, "--depth", "64")
                if loses_light(answer["stack"]) and "substrate" not in answer["stack"]:
                    # What passes the sphere would lose more at its other side: it is cut there.
                    answer = self.json_of(*run, "--depth", "1")
                picture, closed = answer["traced"]["pictures"]
                self.assertAlmostEqual(closed["mean_luminance"] + closed["cut"], 1,
                                       delta=4.5 * closed["standard_error"] + 1e-9)
                white, error = 1.0, picture["standard_error"]
                if loses_light(answer["stack"]):
                    # A distant sphere shows the albedo of cosine mu with the weight 2 mu.
                    angles = [word for mu, _ in GAUSS for word in ("--wi", repr(math.degrees(math.acos(mu))))]
                    # Fails by a loss, or is inconclusive where it is small.
                    runs = self.run_program("furnace", stack, *angles, "--walks", str(32768 * MANY), "--estimator",
                                            "analog", "--quiet", "--json", "-").json()["runs"]
                    self.assertLessEqual({run["loss_or_gain"] for run in runs}, {"none", "loss"})
                    white = sum(2 * mu * w * run["energy"][0] for (mu, w), run in zip(GAUSS, runs))
                    error = math.hypot(error, *(2 * mu * w * run["energy_standard_error"][0]
                                                for (mu, w), run in zip(GAUSS, runs)))
                # Long walks of a white half space are thinned: each that is left counts much.
                self.assertLess(error, 0.04 if "inf" in str(answer["stack"]) else 0.01, stack)
                self.assertAlmostEqual(picture["mean_luminance"] + picture["cut"], white, delta=4.5 * error + 1e-5)
                seen.append((picture["mean_luminance"] + picture["cut"] - white) / error)
        # One true stack in 1.5e5 is off by 4.5 standard errors: any of the 55 in one run of 2700.
        self.assertEqual(len(seen), len(names) - len(NO_PICTURES))
        # Errors are as large as they say: the mean of squares is that of chi-square, within 4.5 of
        # its standard deviations.
        self.assertLess(sum(z * z for z in seen) / len(seen), 1 + 4.5 * (2 / len(seen)) ** 0.5)

    @unittest.skipUnless(WITH_EMBREE, "built without Embree")
    def test_lose_no_light_between_folds(self):
        for shape in ("cloth", "knot"):
            with self.subTest(shape):
                picture = self.traced("lambert_sphere_halfspace", "--white", "--shape", shape, "--light", "none",
                                      "--depth", "50", "--size", "24", "--samples", "8", "--model",
                                      "lambert,albedo=1")
                for name in picture:
                    # Light that enters triangles beside their interpolated normals is trapped.
                    self.assertAlmostEqual(picture[name]["mean_luminance"] + picture[name]["cut"], 1,
                                           delta=4.5 * picture[name]["standard_error"] + 1e-3, msg=name)

    def test_say_which_model_gains_light_without_end(self):
        answer = self.lamella("preview", "spongecake_wood", "--white", "--shape", "sphere", "--size", "16",
                              "--samples", "4", "--depth", "64", "--model",
                              "spongecake,lambert_reflect=1e6,lambert_transmit=1e6", "--quiet", "-o", "out",
                              status=2)
        self.assertIn("the model gains light", answer.err)
        self.assertEqual(answer.err.count("\n"), 1)

    def test_see_what_the_table_shows(self):
        pictures = self.traced("lambert_sphere_halfspace", "--shape", "sphere", "--size", "24", "--samples", "64",
                               "--table", "--model", "lambert_sphere_three_term")
        truth = pictures["truth"]
        for name in ("table", "lambert_sphere_three_term"):
            noise = (truth["standard_error"] ** 2 + pictures[name]["standard_error"] ** 2) ** 0.5
            # The three-term form is within 0.2 % of the truth, the interpolation within 1 %.
            self.assertAlmostEqual(pictures[name]["mean_luminance"], truth["mean_luminance"],
                                   delta=4.5 * noise + 0.01 * truth["mean_luminance"])
            self.assertLess(pictures[name]["bias"], 1e-3 + 4.5 * pictures[name]["bias_error"])

    def test_see_order_1_as_its_closed_form_from_both_sides(self):
        self.write("up.obj", "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nf 1 2 3 4\n")
        self.write("down.obj", "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nf 4 3 2 1\n")
        shapes = ["sphere"] + (["up.obj", "down.obj"] if WITH_EMBREE else [])
        for stack in ("isotropic_slab", "spongecake_plant"):
            for shape in shapes:
                with self.subTest(stack=stack, shape=shape):
                    pictures = self.traced(stack, "--max-order", "1", "--shape", shape, "--size", "16", "--samples", "128",
                                           "--environment", "uniform", "--light", "none", "--depth", "16", "--model",
                                           "single_scattering")
                    truth, closed = pictures["truth"], pictures["single_scattering"]
                    noise = (truth["standard_error"] ** 2 + closed["standard_error"] ** 2) ** 0.5
                    self.assertLess(noise, 0.03 * truth["mean_luminance"])
                    self.assertAlmostEqual(truth["mean_luminance"], closed["mean_luminance"], delta=4.5 * noise)

    def test_see_what_is_not_reciprocal_by_walks_of_light(self):
        # A closed form that light and viewer may not exchange, as a ground: walks are of it alone.
        self.write("ground.toml", '[substrate]\nbsdf = "openpbr_diffuse"\nbase_color = 0.5\n')
        # Flakes of one side that lean, in single scattering: a sheet that light passes.
        leaning = ('[[layer]]\nmedium = "vmf_flake"\nroughness = 0.5\nthickness = 0.7\nalbedo = 0.8\n'
                   'flake = "lambert"\naxis = {}\n')
        self.write("leaning.toml", leaning.format("[0.6, 0.3, 1]"))
        normals = [[0.5 + 0.2 * x for x in (-1, 0, 1, 0)] for _ in range(2)]
        half = [[0.5] * 4] * 2
        (self.folder / "normal.exr").write_bytes(exr_bytes(Part({"R": normals, "G": half, "B": [[0.9] * 4] * 2})))
        self.write("mapped.toml", leaning.format('{ map = "normal.exr", encoding = "normal", filter = "nearest" }'))
        for stack, model, more in (("ground", "openpbr_diffuse,base_color=0.5", ["--depth", "3"]),
                                   ("leaning", "single_scattering", ["--max-order", "1", "--depth", "16"]),
                                   ("mapped", "single_scattering", ["--max-order", "1", "--depth", "16"])):
            with self.subTest(stack):
                pictures = self.traced(f"{stack}.toml", "--shape", "sphere", "--size", "16", "--samples", "512",
                                       "--environment", "uniform", "--model", model, *more)
                truth, closed = pictures["truth"], pictures[model.split(",")[0]]
                noise = (truth["standard_error"] ** 2 + closed["standard_error"] ** 2) ** 0.5
                self.assertLess(noise, 0.02 * truth["mean_luminance"])
                self.assertAlmostEqual(truth["mean_luminance"], closed["mean_luminance"], delta=4.5 * noise)
        self.write("smooth.toml", '[[layer]]\ninterface = "smooth"\nior = 1.5\n' + leaning.format("[0.6, 0.3, 1]") +
                   '[substrate]\nbsdf = "lambert"\n')
        self.assertIn("a smooth interface", self.lamella("preview", "smooth.toml", "--shape", "sphere", status=2).err)

    def test_say_no_noise_where_single_samples_do_not_tell_it(self):
        run = ["preview", "sggx_slab", "--shape", "sphere", "--size", "16", "--model", "lambert", "-o", "out"]
        for samples, known in (("1", False), ("2", True)):
            with self.subTest(samples):
                answer = self.lamella(*run, "--samples", samples, "--json", "a.json")
                header, *rows = [line.split() for line in answer.out.splitlines()[1:4]]
                for row, picture in zip(rows, json.loads((self.folder / "a.json").read_text())["traced"]["pictures"]):
                    self.assertEqual(len(row), len(header), answer.out)
                    told = dict(zip(header, row))
                    self.assertEqual([told["+-"] != "-", told["noise"] != "-"], [known, known])
                    self.assertEqual([picture[key] is not None for key in ("standard_error", "noise", "bias")], 3 * [known])
                self.assertEqual([row[header.index("FLIP")] == "-" for row in rows], [True, False])
        check_schema("preview", json.loads((self.folder / "a.json").read_text()))

    def test_give_equal_pictures_on_any_number_of_threads(self):
        files = []
        for threads in ("1", "3"):
            self.traced("sggx_slab", "--shape", "sphere", "--size", "16", "--samples", "4", "--model", "lambert",
                        "--environment", "clear_sky", "--threads", threads)
            files.append((self.folder / "out/picture.exr").read_bytes())
        self.assertEqual(files[0], files[1])

    def test_agree_by_aiming_and_by_following_light(self):
        # The lamp is found by aiming, the same light spread over the sky by following walks: a sky
        # of twice the radiance is twice as bright, with the lamp or without.
        sky = self.traced("sggx_slab", "--shape", "plane", "--size", "16", "--samples", "64", "--light", "none",
                          "--model", "lambert")
        (self.folder / "two.exr").write_bytes(exr_bytes(Part({"Y": [[2.0] * 8] * 4})))
        two = self.traced("sggx_slab", "--shape", "plane", "--size", "16", "--samples", "64", "--light", "none",
                          "--environment", "two.exr", "--model", "lambert", "--seed", "2")
        for name in sky:
            noise = (4 * sky[name]["standard_error"] ** 2 + two[name]["standard_error"] ** 2) ** 0.5
            self.assertAlmostEqual(2 * sky[name]["mean_luminance"], two[name]["mean_luminance"], delta=4.5 * noise)

    def test_see_the_lamp_alone_without_an_environment(self):
        pictures = self.traced("sggx_slab", "--shape", "sphere", "--size", "16", "--samples", "4", "--light", "none",
                               "--environment", "none", "--model", "lambert")
        self.assertEqual([p["mean_luminance"] for p in pictures.values()], [0, 0])
        lit = self.traced("sggx_slab", "--shape", "sphere", "--size", "96", "--samples", "16", "--light", "0",
                          "--environment", "none", "--model", "lambert,albedo=1")["lambert"]
        # A white sphere that faces the lamp: the mean cosine over its disc is 2/3.
        self.assertAlmostEqual(lit["mean_luminance"], 2 / 3, delta=0.02)

    def test_take_maps(self):
        (self.folder / "map.exr").write_bytes(exr_bytes(Part({"Y": [[0.2, 0.8]] * 2})))
        self.write("a.toml", '[substrate]\nbsdf = "lambert"\nalbedo = { map = "map.exr", filter = "nearest" }\n')
        pictures = self.traced("a.toml", "--shape", "sphere", "--size", "24", "--samples", "64", "--light", "none",
                               "--model", "single_scattering")
        # Both halves of the sphere face the viewer in equal parts.
        self.assertAlmostEqual(pictures["truth"]["mean_luminance"], 0.5, delta=0.02)
        # Single scattering of the texel's own ground is all there is.
        closed = pictures["single_scattering"]
        noise = (pictures["truth"]["standard_error"] ** 2 + closed["standard_error"] ** 2) ** 0.5
        self.assertAlmostEqual(closed["mean_luminance"], pictures["truth"]["mean_luminance"], delta=4.5 * noise)
        self.assertLess(closed["bias"], 4.5 * closed["bias_error"])

    def test_take_tables_over_what_maps_move(self):
        (self.folder / "albedo.exr").write_bytes(exr_bytes(Part({"R": [[0.3, 0.9]], "G": [[0.8, 0.5]],
                                                                 "B": [[0.2, 0.6]]})))
        (self.folder / "g.exr").write_bytes(exr_bytes(Part({"Y": [[0.1 * x for x in range(8)]]})))
        text = ('[[layer]]\nmedium = "henyey_greenstein"\nalbedo = "albedo.exr"\n{}\nthickness = 2\n'
                '[substrate]\nbsdf = "lambert"\nalbedo = 0.5\n')
        for more, maps in (("g = 0.3", 1), ('g = "g.exr"', 2), ('g = "g.exr"\ndensity = "albedo.exr"', None)):
            with self.subTest(maps):
                self.write("a.toml", text.format(more))
                if maps is None:
                    error = self.lamella("preview", "a.toml", "--shape", "sphere", "--table", status=2).err
                    self.assertIn("allowed: 1 to 2", error)
                    self.assertEqual(error.count("\n"), 1, error)
                    continue
                answer = self.lamella("preview", "a.toml", "--shape", "sphere", "--size", "16", "--samples", "1024", "--table",
                                      "--environment", "uniform", "--json", "out.json", "-o", "out")
                self.assertIn("layer.0.albedo from 0.2 to 0.9" if maps == 1 else "layer.0.g from", answer.out)
                pictures = {p["name"]: p for p in json.loads((self.folder / "out.json").read_text())["traced"]["pictures"]}
                truth, table = pictures["truth"], pictures["table"]
                noise = (truth["standard_error"] ** 2 + table["standard_error"] ** 2) ** 0.5
                # Between nodes the table is within 1 %, as that of one stack.
                self.assertAlmostEqual(table["mean_luminance"], truth["mean_luminance"],
                                       delta=4.5 * noise + 0.01 * truth["mean_luminance"])
                # Pixels of the silhouette, which few samples meet, are the rest of this: the table
                # of a stack without maps has up to 5e-3 here.
                self.assertLess(table["bias"], 0.01 + 4.5 * table["bias_error"])
        self.write("a.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.5\nthickness = 1\n'
                             'axis = { map = "g.exr", encoding = "angle" }\n[substrate]\nbsdf = "lambert"\n')
        self.assertIn("a map of directions, layer.0.axis",
                      self.lamella("preview", "a.toml", "--shape", "sphere", "--table", status=2).err)

    def test_give_closed_forms_the_parameters_of_the_place(self):
        (self.folder / "map.exr").write_bytes(exr_bytes(Part({"Y": [[0.3, 0.9]] * 2})))
        self.write("a.toml", '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\n'
                             'albedo = { map = "map.exr", filter = "nearest" }\n')
        pictures = self.traced("a.toml", "--shape", "sphere", "--size", "24", "--samples", "256", "--model",
                               "lambert_sphere_three_term", "--model", "lambert_sphere_three_term,albedo=0.6")
        own, same = pictures["lambert_sphere_three_term_0"], pictures["lambert_sphere_three_term_1"]
        # The three-term form is within 0.2 % of the truth; one albedo everywhere is far off.
        self.assertLess(own["bias"], 1e-4 + 4.5 * own["bias_error"])
        self.assertGreater(same["bias"], 0.05)
        self.assertEqual(pictures["truth"]["flip"], 0)
        self.assertLess(own["flip"], 0.5 * same["flip"])
        self.assertEqual(same["label"], "lambert_sphere_three_term, albedo=0.6")

    def test_give_spongecake_the_networks_lobes_of_the_place(self):
        (self.folder / "map.exr").write_bytes(exr_bytes(Part({"Y": [[0.3, 0.9]] * 2})))
        self.write("a.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.8\nthickness = 3\n'
                             'albedo = { map = "map.exr", filter = "nearest" }\n')
        pictures = self.traced("a.toml", "--shape", "sphere", "--size", "16", "--samples", "256", "--model",
                               "spongecake", "--model", "spongecake,lobes=none")
        network, none = pictures["spongecake_0"], pictures["spongecake_1"]
        self.assertEqual(none["label"], "spongecake, lobes=none")
        self.assertLess(network["bias"], 0.1 * none["bias"])

    def test_compare_speed_with_error(self):
        pictures = self.traced("lambert_sphere_halfspace", "--shape", "sphere", "--size", "16", "--equal-time", "0.4",
                               "--model", "lambert")
        for picture in pictures.values():
            self.assertGreater(len(picture["checkpoints"]), 1)
        self.assertGreater(pictures["lambert"]["bias"], 4.5 * pictures["lambert"]["bias_error"])
        if WITH_CAIRO:
            self.assertTrue((self.folder / "out/error.png").read_bytes().startswith(b"\x89PNG"))

    @unittest.skipUnless(WITH_EMBREE, "built without Embree")
    def test_read_obj_files(self):
        self.write("square.obj", "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                 "f 1/1 2/2 3/3 4/4\n")
        picture = self.traced("sggx_slab", "--white", "--shape", "square.obj", "--size", "16", "--samples", "16",
                              "--light", "none", "--model", "lambert,albedo=1")["truth"]
        self.assertAlmostEqual(picture["mean_luminance"] + picture["cut"], 1, delta=4.5 * picture["standard_error"])
        for text, part in (("f 1 2 3\n", "square.obj:1: found the index"), ("v 1 x 2\n", "found \"x\""),
                           ("v 1 2 3\nf 1 1\n", "2 vertices"), ("", "no faces")):
            self.write("square.obj", text)
            self.assertIn(part, self.lamella("preview", "sggx_slab", "--shape", "square.obj", status=2).err)

    def test_are_refused_where_they_mean_nothing(self):
        for arguments, part in ((["sggx_slab", "--time", "1"], "--shape"), (["sggx_slab", "--equal-time", "1"], "--shape"),
                                (["sggx_slab", "--samples", "4"], "--shape"), (["sggx_slab", "--table"], "--shape"),
                                (["sphere_bed_dense", "--shape", "sphere"], "explicit geometry"),
                                (["sggx_slab", "--shape", "sphere", "--table"], "reflection alone"),
                                (["sggx_slab", "--shape", "cube"], "--shape"),
                                (["sggx_slab", "--shape", "sphere", "--environment", "none.exr"], "none.exr"),
                                (["sggx_slab", "--shape", "sphere", "--light", "x"], "--light")):
            with self.subTest(arguments):
                error = self.lamella("preview", *arguments, status=2).err
                self.assertIn(part, error)
                self.assertEqual(error.count("\n"), 1, error)


if __name__ == "__main__":
    unittest.main()
