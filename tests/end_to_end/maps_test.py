"""Stacks with pictures among their values: at a place, over the whole map, and what is refused."""

import math
import unittest

from exr_writer import Part, exr_bytes
from lamella_program import WITH_PICTURES, ProgramTest
from picture_writer import GREY_JPEG, png

SLAB = '[[layer]]\nmedium = "sggx"\nthickness = 1\n'
LAMBERT = '[substrate]\nbsdf = "lambert"\nalbedo = {}\n'


def linear(byte):
    x = byte / 255
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


class MapsTest(ProgramTest):
    def bytes(self, name, content):
        (self.folder / name).write_bytes(content)
        return name

    def grey_exr(self, name, rows):
        return self.bytes(name, exr_bytes(Part({"Y": rows})))

    def at(self, text, u, v):
        """The resolved stack of a place."""
        self.write("a.toml", text)
        return self.json_of("simulate", "a.toml", "--at", f"{u},{v}", "--wi", "0", "--walks", "128",
                            "--quiet")["stack"]

    def refusal(self, text, *arguments, command=("explain",)):
        self.write("a.toml", text)
        error = self.lamella(*command, "a.toml", *arguments, status=2).err
        self.assertEqual(error.count("\n"), 1, error)
        return error


class AMapGivesAValueToEveryPlace(MapsTest):
    def test_texels_are_squares_with_v_upwards(self):
        self.grey_exr("map.exr", [[0.1, 0.2], [0.3, 0.4]])
        for u, v, value in ((0.25, 0.25, 0.3), (0.75, 0.25, 0.4), (0.25, 0.75, 0.1), (0.75, 0.75, 0.2),
                            (0.5, 0.5, 0.25), (0.25, 0.5, 0.2), (0, 0, 0.25)):
            with self.subTest(u=u, v=v):
                stack = self.at(SLAB + 'roughness = "map.exr"\n', u, v)
                self.assertAlmostEqual(stack["layer"][0]["roughness"], value, places=7)
        self.assertEqual(self.at(SLAB + 'roughness = "map.exr"\n', 0.25, 0.5)["name"], "a@0.25,0.5")

    def test_filter_and_wrap_are_keys(self):
        self.grey_exr("map.exr", [[0.2, 0.4]])
        text = SLAB + 'roughness = {{ map = "map.exr", filter = "{}", wrap = "{}" }}\n'
        for kind, wrap, u, value in (("nearest", "repeat", 0.4, 0.2), ("nearest", "repeat", 0.6, 0.4),
                                     ("linear", "repeat", 0, 0.3), ("linear", "clamp", 0, 0.2),
                                     ("linear", "mirror", 0, 0.2), ("linear", "clamp", 1, 0.4)):
            with self.subTest(kind=kind, wrap=wrap, u=u):
                stack = self.at(text.format(kind, wrap), u, 0.5)
                self.assertAlmostEqual(stack["layer"][0]["roughness"], value, places=7)

    @unittest.skipUnless(WITH_PICTURES, "built without libpng and libjpeg")
    def test_colours_of_whole_numbers_are_srgb_and_numbers_are_linear(self):
        self.bytes("colour.png", png([[(200, 100, 50)]]))
        self.bytes("grey.png", png([[13107]], bits=16))
        self.bytes("grey.jpg", GREY_JPEG)
        stack = self.at(SLAB + 'albedo = "colour.png"\nroughness = { map = "grey.png", scale = [0.1, 0.6] }\n', 0.5, 0.5)
        for value, byte in zip(stack["layer"][0]["albedo"], (200, 100, 50)):
            self.assertAlmostEqual(value, linear(byte), places=6)
        self.assertAlmostEqual(stack["layer"][0]["roughness"], 0.1 + 0.5 * 13107 / 65535, places=6)
        stack = self.at(SLAB + 'albedo = { map = "colour.png", color_space = "linear" }\nroughness = "grey.jpg"\n', 0, 0)
        self.assertAlmostEqual(stack["layer"][0]["albedo"][1], 100 / 255, places=6)
        self.assertAlmostEqual(stack["layer"][0]["roughness"], 128 / 255, places=6)
        self.bytes("alpha.png", png([[(10, 20, 30, 40)]]))
        for channel, byte in (("r", 10), ("g", 20), ("b", 30), ("a", 40)):
            stack = self.at(SLAB + f'roughness = {{ map = "alpha.png", channel = "{channel}", scale = [0, 5] }}\n', 0, 0)
            self.assertAlmostEqual(stack["layer"][0]["roughness"], 5 * byte / 255, places=6)

    def test_directions_are_vectors_of_the_tangent_space_or_angles(self):
        third = 1 / math.sqrt(3)
        self.bytes("normal.exr", exr_bytes(Part({c: [[0.5 + third / 2]] for c in "RGB"})))
        self.grey_exr("angle.exr", [[0.25]])
        text = SLAB + 'roughness = 0.3\naxis = {{ map = "{}", encoding = "{}" }}\n'
        for value in self.at(text.format("normal.exr", "normal"), 0, 0)["layer"][0]["axis"]:
            self.assertAlmostEqual(value, third, places=6)
        axis = self.at(text.format("angle.exr", "angle"), 0, 0)["layer"][0]["axis"]
        for value, expected in zip(axis, (0, 1, 0)):
            self.assertAlmostEqual(value, expected, places=6)

    def test_every_part_of_a_stack_takes_maps(self):
        self.grey_exr("map.exr", [[0.3]])
        stack = self.at('[[layer]]\ninterface = "ggx"\nior = { map = "map.exr", scale = [1, 2] }\nroughness = "map.exr"\n'
                        '[[layer]]\nmedium = "henyey_greenstein"\ng = "map.exr"\nthickness = "map.exr"\ndensity = "map.exr"\n'
                        '[substrate]\nbsdf = "eon"\nalbedo = "map.exr"\nroughness = "map.exr"\n', 0, 0)
        self.assertAlmostEqual(stack["layer"][0]["ior"], 1.3, places=6)
        for part, keys in ((stack["layer"][0], ["roughness"]), (stack["layer"][1], ["g", "thickness", "density"]),
                           (stack["substrate"], ["albedo", "roughness"])):
            for key in keys:
                self.assertAlmostEqual(part[key], 0.3, places=6, msg=key)


class AStackAtAPlaceIsAPlainStack(MapsTest):
    def test_with_its_numbers(self):
        self.grey_exr("map.exr", [[0.2, 0.4]])
        self.write("mapped.toml", SLAB + 'albedo = "map.exr"\nroughness = 0.5\n')
        self.write("plain.toml", SLAB + f'albedo = {0.2:.9g}\nroughness = 0.5\n')
        run = ["--wi", "30", "--walks", "2000", "--quiet"]
        mapped = self.json_of("simulate", "mapped.toml", "--at", "0.25,0.5", *run)["runs"][0]
        plain = self.json_of("simulate", "plain.toml", *run)["runs"][0]
        self.assertAlmostEqual(mapped["absorbed"][0] if isinstance(mapped["absorbed"], list) else
                               mapped["absorbed"]["value"][0],
                               plain["absorbed"][0] if isinstance(plain["absorbed"], list) else
                               plain["absorbed"]["value"][0], places=6)

    def test_for_eval_export_and_fit(self):
        self.grey_exr("map.exr", [[0.2, 0.4]])
        text = '[[layer]]\nmedium = "sggx"\nthickness = 1\nroughness = 0.5\nalbedo = {}\n'
        self.write("mapped.toml", text.format('"map.exr"'))
        # As the picture holds it, in single precision.
        self.write("plain.toml", text.format("0.20000000298023224"))
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,90\n")
        for model in (["truth", "walks=2000", "estimator=next-event"], ["single_scattering"], ["spongecake"]):
            found = [self.lamella("eval", model[0], f"stack=./{name}.toml", *model[1:], *at, "--pairs", "pairs.csv").out
                     for name, at in (("mapped", ["--at", "0.25,0.5"]), ("plain", []))]
            self.assertEqual(*found)
        for name, at in (("mapped", ["--at", "0.25,0.5"]), ("plain", [])):
            self.lamella("export", f"./{name}.toml", *at, "--to", "npz", "--wi", "30", "--walks", "2000", "--quiet", "-o",
                         name + ".npz")
            self.lamella("export", f"single_scattering,stack=./{name}.toml", *at, "--to", "csv", "--wi", "30", "--quiet",
                         "-o", name + ".csv")
        self.assertEqual((self.folder / "mapped.csv").read_text().replace("mapped@0.25,0.5", "plain"),
                         (self.folder / "plain.csv").read_text())
        fits = [self.json_of("fit", f"./{name}.toml", *at, "--model", "lambert", "--wi", "30", "--tolerance", "1e-3",
                             "--quiet")["models"] for name, at in (("mapped", ["--at", "0.25,0.5"]), ("plain", []))]
        self.assertEqual(*[fit[0]["parameters"] for fit in fits])

    def test_so_the_content_of_a_picture_identifies_a_run(self):
        self.write("a.toml", SLAB + 'albedo = "map.exr"\nroughness = 0.5\n')
        run = ["simulate", "a.toml", "--at", "0.5,0.5", "--wi", "30", "--walks", "2000", "--quiet"]
        self.grey_exr("map.exr", [[0.2]])
        self.lamella(*run, "--shard", "1/2", "-o", "1.part")
        self.grey_exr("map.exr", [[0.3]])
        self.lamella(*run, "--shard", "2/2", "-o", "2.part")
        self.assertIn("stack", self.lamella("merge", "1.part", "2.part", "-o", "whole.exr", status=2).err)


class TheMeanOverAMap(MapsTest):
    def test_is_the_mean_of_its_texels_with_their_error(self):
        self.grey_exr("map.exr", [[0.2, 0.6], [0.6, 0.2]])
        self.write("a.toml", LAMBERT.format('"map.exr"'))
        answer = self.json_of("simulate", "a.toml", "--at", "mean", "--wi", "30", "--walks", "25600", "--quiet")
        self.assertEqual(answer["texels"], 256)
        self.assertEqual(answer["stack"]["name"], "a@mean")
        reflected = answer["runs"][0]["reflected"]
        value, error = reflected["total"][0], reflected["standard_error"][0]
        # Lambert's ground absorbs without chance: texels that differ are all the noise there is. A
        # texel's square has values within 0.4 / 8 along each axis: errors are below 0.1 / 16.
        self.assertGreater(error, 1e-5)
        self.assertLess(error, 0.1 / 16)
        self.assertAlmostEqual(value, 0.4, delta=4.5 * error)

    def test_is_what_closed_forms_are_judged_by_texel_by_texel(self):
        self.grey_exr("map.exr", [[0.5, 0.9], [0.9, 0.5]])
        self.write("a.toml", '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\nalbedo = "map.exr"\n')
        run = ["compare", "a.toml", "--at", "mean", "--wi", "30", "--walks", "3e5", "--quiet", "-o", "out",
               "--grid", "4x8"]
        answer = self.json_of(*run, "--model", "lambert_sphere_three_term", "--model",
                              "lambert_sphere_three_term,albedo=0.5")
        verdicts = [[lobe["verdict"] for lobe in model["lobes"] if lobe["order"] == "all"] for model in answer["models"]]
        self.assertEqual(verdicts, [["agrees"], ["differs"]])
        self.assertAlmostEqual(answer["models"][0]["parameters"]["albedo"], 0.7, delta=0.01)
        # The files have the texels: they repeat without the picture.
        (self.folder / "map.exr").unlink()
        for file in ("truth", "lambert_sphere_three_term_0", "lambert_sphere_three_term_1"):
            self.assertTrue(self.json_of("rerun", f"out/{file}.exr", "--quiet")["same"], file)

    def test_has_a_furnace(self):
        self.grey_exr("map.exr", [[0.2, 0.6]])
        self.write("a.toml", SLAB + 'albedo = "map.exr"\nroughness = "map.exr"\n')
        answer = self.json_of("furnace", "a.toml", "--at", "mean", "--wi", "60", "--walks", "1e6", "--quiet")
        self.assertEqual(answer["verdict"], "pass")

    def test_stops_at_a_target_error(self):
        self.grey_exr("map.exr", [[0.5, 0.51]])
        self.write("a.toml", SLAB + 'roughness = 0.5\nalbedo = "map.exr"\n')
        run = ["simulate", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8"]

        def error_of(answer):
            # As --target-error has it: of the energies above a thousandth.
            parts = [p for p in (answer["reflected"], answer["transmitted"])]
            return max(se / e for p in parts for e, se in zip(p["total"], p["standard_error"]) if e > 1e-3)

        found = self.json_of(*run, "--target-error", "0.02", "--estimator", "analog", "--quiet", "-o", "mean.exr")
        walks = found["walks"]
        self.assertLess(walks, 1000000)
        # Rounds double: the walks are 128 times a power of two for each of 256 texels.
        self.assertEqual((walks // (128 * 256)).bit_count(), 1)
        self.assertLessEqual(error_of(found["runs"][0]), 0.02)
        # The answer is that of as many walks.
        named = self.json_of(*run, "--walks", str(walks), "--estimator", "analog", "--quiet")
        self.assertEqual(named["runs"][0]["reflected"], found["runs"][0]["reflected"])
        self.assertTrue(self.json_of("rerun", "mean.exr", "--quiet")["same"])
        # Texels that differ leave an error that no walks take away.
        self.grey_exr("map.exr", [[0.05, 0.95]])
        answer = self.lamella(*run, "--target-error", "1e-3", "--walks", "3e5", "--estimator", "analog")
        self.assertIn("differences between texels leave", answer.err)

    HAZE = '[[layer]]\nmedium = "henyey_greenstein"\ng = 0.3\nthickness = 2\nalbedo = {}\n'

    def test_is_solved_texel_by_texel_with_bounds_and_the_error_of_the_sample_apart(self):
        self.grey_exr("map.exr", [[0.2, 0.6], [0.6, 0.2]])
        self.write("a.toml", self.HAZE.format('{ map = "map.exr", filter = "nearest" }'))
        answer = self.json_of("simulate", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8", "--quiet")
        # Two different texels: auto solves them.
        self.assertEqual(answer["estimator"], "deterministic")
        self.assertIn("2 of them different", answer["estimator_reason"])
        run = answer["runs"][0]
        total = 0
        for albedo in (0.2, 0.6):
            self.write("plain.toml", self.HAZE.format(f"{albedo:.9g}"))
            plain = self.json_of("simulate", "plain.toml", "--wi", "30", "--grid", "4x8", "--quiet")["runs"][0]
            total += plain["reflected"]["total"][0] / 2
        self.assertAlmostEqual(run["reflected"]["total"][0], total, delta=run["reflected"]["standard_error"][0])
        # Squares of the sample lie within texels: the sample has the map's mean.
        self.assertEqual(run["map_error"]["reflected"], [0])

    def test_by_the_solver_is_that_by_walks(self):
        self.grey_exr("ramp.exr", [[0.1 + 0.1 * x for x in range(8)]])
        self.write("a.toml", self.HAZE.format('"ramp.exr"'))
        run = ["simulate", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8", "--quiet"]
        solved = self.json_of(*run, "--estimator", "deterministic", "--tolerance", "1e-2", "-o", "a.exr")["runs"][0]
        walked = self.json_of(*run, "--walks", "256000")
        self.assertEqual(walked["estimator"], "analog")
        walked = walked["runs"][0]
        # Both are of the same texels; walks leave 1 / sqrt(256000) of the light at most.
        self.assertAlmostEqual(solved["reflected"]["total"][0], walked["reflected"]["total"][0], delta=5 / 256000**0.5)
        bound, sample = solved["reflected"]["standard_error"][0], solved["map_error"]["reflected"][0]
        self.assertLess(bound, 1e-3)
        # Neighbouring squares differ by less than halves of the map do, which walks are judged by.
        self.assertGreater(sample, 10 * bound)
        self.assertLess(sample, walked["reflected"]["standard_error"][0])
        self.assertIn("wi0.reflect.all.map_error.Y", self.lamella("show", "a.exr").out)

    def test_judges_closed_forms_by_the_solver_without_noise(self):
        self.grey_exr("map.exr", [[0.2, 0.6]])
        self.write("a.toml", self.HAZE.format('{ map = "map.exr", filter = "nearest" }'))
        answer = self.json_of("compare", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8", "--quiet", "-o", "out",
                              "--model", "single_scattering")
        first = [lobe for lobe in answer["models"][0]["lobes"] if lobe["order"] == "1"]
        self.assertEqual({lobe["verdict"] for lobe in first}, {"agrees"})
        self.assertEqual(len(answer["map_error"]), 1)
        self.assertEqual(self.json_of("furnace", "a.toml", "--at", "mean", "--wi", "30", "--quiet")["estimator"],
                         "deterministic")

    def test_by_the_solver_repeats_from_its_file(self):
        self.grey_exr("map.exr", [[0.2, 0.6], [0.6, 0.4]])
        self.write("a.toml", self.HAZE.format('{ map = "map.exr", filter = "nearest" }'))
        self.lamella("compare", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8", "--quiet", "-o", "out",
                     "--model", "single_scattering")
        (self.folder / "map.exr").unlink()
        for file in ("truth", "single_scattering"):
            self.assertTrue(self.json_of("rerun", f"out/{file}.exr", "--quiet", "-o", "again.exr")["same"], file)
            self.assertTrue(self.json_of("rerun", "again.exr", "--quiet")["same"], file)

    def test_has_a_preview(self):
        # Halves of albedo 0 and 1: under uniform light the mean shows half.
        self.grey_exr("map.exr", [[0.0, 1.0]])
        self.write("a.toml", '[substrate]\nbsdf = "lambert"\nalbedo = { map = "map.exr", filter = "nearest" }\n')
        answer = self.json_of("compare", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8", "--quiet", "-o", "out",
                              "--preview", "--model", "single_scattering")
        under = {view["light"]: view for view in answer["previews"] if view["scene"] == "sphere"}["environment"]
        for picture in under["pictures"]:
            self.assertAlmostEqual(picture["mean_luminance"], 0.5, delta=1e-3)
        # More different texels than are drawn: of a sample of them, closed forms as well.
        self.grey_exr("map.exr", [[0.01 * x for x in range(100)]])
        answer = self.json_of("preview", "a.toml", "--at", "mean", "--quiet", "-o", "seen", "--size", "16", "--model",
                              "single_scattering")
        self.assertIn("16 texels", answer["truth"])
        for view in answer["views"]:
            truth, closed = (picture["mean_luminance"] for picture in view["pictures"])
            self.assertAlmostEqual(truth, closed, delta=1e-3 * truth)

    def test_is_divided_and_put_together_again(self):
        self.grey_exr("ramp.exr", [[0.1 + 0.1 * x for x in range(8)]])
        self.write("a.toml", self.HAZE.format('"ramp.exr"'))
        for more in (["--walks", "51200"], ["--estimator", "deterministic", "--tolerance", "1e-2"]):
            run = ["simulate", "a.toml", "--at", "mean", "--wi", "30", "--wi", "60", "--grid", "4x8", "--quiet", *more]
            self.lamella(*run, "-o", "whole.exr")
            for k in (1, 2, 3):
                self.lamella(*run, "--shard", f"{k}/3", "-o", f"{k}.part")
            self.lamella("merge", "1.part", "2.part", "3.part", "-o", "merged.exr", "--quiet")
            self.assertEqual((self.folder / "whole.exr").read_bytes(), (self.folder / "merged.exr").read_bytes(), more)
        # The picture is part of what parts are about.
        self.grey_exr("ramp.exr", [[0.1 + 0.05 * x for x in range(8)]])
        self.lamella(*run, "--shard", "2/3", "-o", "2.part")
        self.assertIn("differs", self.lamella("merge", "1.part", "2.part", "3.part", "-o", "m.exr", status=2).err)

    def test_goes_on_from_a_checkpoint(self):
        self.grey_exr("map.exr", [[0.2, 0.6]])
        self.write("a.toml", self.HAZE.format('"map.exr"'))
        run = ["simulate", "a.toml", "--at", "mean", "--wi", "30", "--grid", "4x8", "--walks", "51200", "--quiet"]
        self.lamella(*run, "-o", "whole.exr")
        self.lamella(*run, "--checkpoint", "a.checkpoint", "-o", "kept.exr")
        self.assertEqual((self.folder / "whole.exr").read_bytes(), (self.folder / "kept.exr").read_bytes())
        self.assertFalse((self.folder / "a.checkpoint").exists())


class WhatIsWrongWithAMapIsTold(MapsTest):
    def test_in_one_line_with_file_line_and_key(self):
        self.grey_exr("map.exr", [[0.2, 1.5]])
        self.grey_exr("nan.exr", [[math.nan]])
        self.write("no.png", "no picture")
        self.grey_exr("one.exr", [[0.5]])
        self.bytes("cut.exr", (self.folder / "map.exr").read_bytes()[:100])
        for value, part in (('"map.exr"', "found 1.5 at pixel (1, 0) of map.exr; allowed: a number or three numbers"),
                            ('"nan.exr"', "found nan"), ('"none.exr"', "none.exr"), ('"no.png"', "neither"),
                            ('"cut.exr"', "cut.exr"),
                            ('{ map = "map.exr", wrap = "round" }', "repeat, mirror, clamp"),
                            ('{ map = "map.exr", scales = [0, 1] }', 'did you mean "scale"'),
                            ('{ map = "map.exr", scale = 2 }', "two finite numbers"),
                            ('{ map = "map.exr", encoding = "angle" }', 'encoding = "value"'),
                            ('{ map = "map.exr", channel = "g" }', "channel")):
            with self.subTest(value):
                error = self.refusal(SLAB + f"roughness = 0.5\nalbedo = {value}\n", "--at", "0.5,0.5")
                self.assertIn("a.toml:5: ", error)
                self.assertIn('layer 0: key "albedo"', error)
                self.assertIn(part, error)
        for place in ([], ["--at", "0,0"]):
            self.assertIn("or a picture (.exr, .png, .jpg)", self.refusal(SLAB + 'albedo = "map.tif"\n', *place))
        # What is wrong beside a map still has its line.
        self.assertIn("a.toml:5: ", self.refusal(SLAB + 'albedo = "one.exr"\nroughness = 2\n', "--at", "0,0"))
        self.assertIn("encoding", self.refusal(SLAB + 'axis = "map.exr"\n', "--at", "0,0"))
        self.assertIn("one of", self.refusal(SLAB + 'flake = "map.exr"\n', "--at", "0,0"))

    @unittest.skipUnless(WITH_PICTURES, "built without libpng and libjpeg")
    def test_damaged_pictures_too(self):
        whole = png([[1, 2], [3, 4]])
        self.bytes("cut.png", whole[:-20])
        self.bytes("cut.jpg", GREY_JPEG[:100])
        huge = bytearray(whole)
        huge[16:24] = b"\x00\xff\xff\xff\x00\xff\xff\xff"
        self.bytes("huge.png", bytes(huge))
        for name in ("cut.png", "cut.jpg", "huge.png"):
            with self.subTest(name):
                self.assertIn(name, self.refusal(SLAB + f'albedo = "{name}"\n', "--at", "0,0"))

    def test_a_place_is_asked_for_where_one_is_needed(self):
        self.grey_exr("map.exr", [[0.2]])
        text = SLAB + 'albedo = "map.exr"\n'
        for command in (["simulate"], ["furnace"], ["compare"], ["explain"], ["sweep", "--set", "layer.0.density=1,2"],
                        ["preview"], ["samples", "-o", "x.npz"], ["homogenise"]):
            with self.subTest(command):
                error = self.refusal(text, command=command)
                self.assertIn("map.exr", error)
                self.assertIn("--at", error)
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,90\n")
        error = self.lamella("eval", "truth", "stack=./a.toml", "--pairs", "pairs.csv", status=2).err
        self.assertIn("--at U,V", error)
        self.assertIn("mean", self.lamella("eval", "truth", "stack=./a.toml", "--at", "mean", "--pairs", "pairs.csv",
                                           status=2).err)
        self.assertIn("no stack", self.lamella("eval", "lambert", "--at", "0,0", "--pairs", "pairs.csv", status=2).err)
        self.assertIn("no stack", self.lamella("export", "lambert", "--at", "0,0", "--to", "csv", "-o", "x.csv",
                                               status=2).err)
        self.assertIn("no stack", self.lamella("fit", "lambert", "--at", "0,0", "--model", "eon", status=2).err)
        self.assertIn("--at", self.lamella("export", "./a.toml", "--to", "csv", "-o", "x.csv", status=2).err)
        for place, part in (("2,0", "from 0 to 1"), ("x", "from 0 to 1"), ("0.5", "from 0 to 1"), ("mean", "from 0 to 1")):
            self.assertIn(part, self.refusal(text, "--at", place))
        self.assertIn("no pictures", self.lamella("simulate", "sggx_slab", "--at", "0,0", status=2).err)


if __name__ == "__main__":
    unittest.main()
