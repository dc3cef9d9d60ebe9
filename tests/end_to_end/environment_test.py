"""Pictures of other programs as the light of a preview."""

import math

from exr_writer import Part, constant, exr_bytes, grey, header_only
from lamella_program import ProgramTest

LAMBERT = ["--model", "lambert,albedo=1", "--size", "32"]


def sun_over(width, height, latitude, longitude, radius):
    """A disc of light [degrees] in a black sky, and its irradiance on a plane that faces it."""
    rows, irradiance = constant(width, height, 0.0), 0
    towards = direction(latitude, longitude)
    for y in range(height):
        for x in range(width):
            theta = math.pi * (y + 0.5) / height
            w = direction(90 - math.degrees(theta), 360 * (x + 0.5) / width - 180)
            if math.degrees(math.acos(min(1, sum(a * b for a, b in zip(w, towards))))) <= radius:
                rows[y][x] = 1000.0
                band = math.cos(math.pi * y / height) - math.cos(math.pi * (y + 1) / height)
                irradiance += 1000 * 2 * math.pi / width * band
    return rows, irradiance


def direction(latitude, longitude):
    a, b = math.radians(latitude), math.radians(longitude)
    return math.cos(a) * math.sin(b), math.sin(a), -math.cos(a) * math.cos(b)


def seen_normals(size):
    """What the sphere's pixels face, from its picture's geometry."""
    for row in range(size):
        for column in range(size):
            x, y = 1.04 * ((2 * column + 1) / size - 1), 1.04 * ((size - 2 * row - 1) / size)
            if x * x + y * y < 1:
                yield x, y, math.sqrt(1 - x * x - y * y)


class Environments(ProgramTest):
    def write_exr(self, *parts, name="light.exr"):
        (self.folder / name).write_bytes(exr_bytes(*parts))
        return name

    def means(self, environment, *arguments, stack="lambert_sphere_halfspace"):
        arguments = arguments or LAMBERT
        answer = self.json_of("preview", stack, *arguments, "--environment", environment, "--quiet",
                              "-o", "out")
        return {v["scene"]: {p["name"]: p["mean_luminance"] for p in v["pictures"]}
                for v in answer["views"] if v["light"] == "environment"}

    def refusal(self, environment):
        answer = self.lamella("preview", "lambert_sphere_halfspace", *LAMBERT, "--environment",
                              environment, status=2)
        self.assertEqual(len(answer.err.strip().splitlines()), 1, answer.err)
        self.assertIn(environment, answer.err)
        return answer.err


class AnEnvironmentCoversTheDisplayWindow(Environments):
    def test_half_a_panorama_lights_half_as_much(self):
        # The upper half of the sphere: a plane that faces up sees nothing else, the sphere's
        # silhouette is symmetric, so that its mean is half.
        whole = self.means(self.write_exr(Part(grey(constant(64, 32, 1.0)))))
        upper = self.means(self.write_exr(
            Part(grey(constant(64, 16, 1.0)), data=(0, 0, 63, 15), display=(0, 0, 63, 31))))
        self.assertAlmostEqual(whole["sphere"]["lambert"], 1, delta=1e-6)
        self.assertAlmostEqual(upper["plane"]["lambert"], 1, delta=3e-3)
        self.assertAlmostEqual(upper["sphere"]["lambert"], 0.5, delta=3e-3)

    def test_wherever_the_windows_begin_and_whatever_lies_outside_is_cut(self):
        upper = self.means(self.write_exr(
            Part(grey(constant(64, 16, 1.0)), data=(0, 0, 63, 15), display=(0, 0, 63, 31))))
        moved = self.means(self.write_exr(
            Part(grey(constant(64, 16, 1.0)), data=(-7, 100, 56, 115), display=(-7, 100, 56, 131))))
        larger = constant(80, 20, 5.0)
        for y in range(16):
            larger[4 + y][8:72] = [1.0] * 64
        cut = self.means(self.write_exr(
            Part(grey(larger), data=(-8, -4, 71, 15), display=(0, 0, 63, 31))))
        self.assertEqual(moved, upper)
        self.assertEqual(cut, upper)

    def test_windows_that_do_not_meet_are_refused(self):
        error = self.refusal(self.write_exr(
            Part(grey(constant(4, 4, 1.0)), data=(10, 0, 13, 3), display=(0, 0, 3, 3))))
        self.assertIn("display window", error)


class ASmallSunHasItsWholeIrradiance(Environments):
    def test_on_white_lambert_and_on_a_rough_lobe(self):
        size, where = 32, (35, 120)
        rows, irradiance = sun_over(1024, 512, *where, radius=0.35)
        light = self.write_exr(Part(grey(rows), kind="half"))
        towards = direction(*where)
        normals = list(seen_normals(size))
        cosines = [max(0, sum(a * b for a, b in zip(n, towards))) for n in normals]
        means = self.means(light, "--size", str(size), "--model", "lambert,albedo=1")
        expected = irradiance / math.pi * sum(cosines) / len(cosines)
        self.assertAlmostEqual(means["sphere"]["lambert"] / expected, 1, delta=2e-3)
        self.assertAlmostEqual(means["plane"]["lambert"] / (irradiance / math.pi * towards[1]), 1,
                               delta=2e-3)

    def test_as_the_lamp_from_there_has(self):
        # A lamp of irradiance pi from above right of the viewer, and a sun there.
        self.write("narrow.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.1\nthickness = inf\n')
        theta, phi = 50, 30
        x, y = math.sin(math.radians(theta)) * math.cos(math.radians(phi)), math.sin(
            math.radians(theta)) * math.sin(math.radians(phi))
        z = math.cos(math.radians(theta))
        rows, irradiance = sun_over(1024, 512, math.degrees(math.asin(y)),
                                    math.degrees(math.atan2(x, -z)), radius=0.35)
        answer = self.json_of("preview", "./narrow.toml", "--size", "64", "--model",
                              "single_scattering", "--walks", "200", "--light", f"{theta},{phi}",
                              "--environment", self.write_exr(Part(grey(rows))), "--quiet")
        seen = {v["light"]: {p["name"]: p["mean_luminance"] for p in v["pictures"]}
                for v in answer["views"] if v["scene"] == "sphere"}
        for name, lamp in seen["lamp"].items():
            self.assertAlmostEqual(seen["environment"][name] / irradiance * math.pi / lamp, 1,
                                   delta=5e-3, msg=name)


class APictureIsFoundInAnyPartAndLayer(Environments):
    def test_whatever_its_channels_are_called(self):
        plain = self.means(self.write_exr(Part(grey(constant(8, 4, 0.5)))))
        half = constant(8, 4, 0.5)
        nothing = constant(8, 4, 7.0)
        for parts in (
            [Part({"r": half, "g": half, "b": half})],
            [Part({f"ViewLayer.Combined.{c}": half for c in "RGBA"} |
                  {f"ViewLayer.DiffCol.{c}": nothing for c in "RGB"} | {"ViewLayer.Depth.Z": nothing})],
            [Part({"Z": nothing}, name="depth"), Part(grey(half), name="color")],
            [Part({"Y": half})],
            [Part({"red": half, "green": half, "blue": half})],
        ):
            with self.subTest([list(p.channels) for p in parts]):
                self.assertEqual(self.means(self.write_exr(*parts)), plain)

    def test_or_all_channels_are_listed_in_one_line(self):
        values = constant(4, 2, 1.0)
        error = self.refusal(self.write_exr(
            Part({f"Normal.{c}": values for c in "XYZ"}, name="normals"),
            Part({"R": values, "G": values}, name="half a picture")))
        for word in ("Normal.X", "Normal.Z", "normals", "half a picture", "G, R"):
            self.assertIn(word, error)

    def test_half_float_and_whole_numbers_are_pixels(self):
        two = {kind: self.means(self.write_exr(Part(grey(constant(8, 4, 2)), kind=kind)))
               for kind in ("half", "float", "uint")}
        self.assertEqual(two["half"], two["float"])
        self.assertEqual(two["uint"], two["float"])
        self.assertAlmostEqual(two["float"]["sphere"]["lambert"], 2, delta=1e-6)

    def test_what_is_no_radiance_is_refused_with_its_place(self):
        for value in (math.nan, math.inf, -0.5):
            rows = constant(8, 4, 1.0)
            rows[3][6] = value
            with self.subTest(value):
                self.assertIn("x 6, y 3", self.refusal(self.write_exr(Part(grey(rows)))))

    def test_an_absurd_window_is_refused_before_memory_is_taken(self):
        for data in ((0, 0, 10**9, 10**9), (0, 0, 100000, 100000), (0, 0, 2**31 - 2, 3)):
            with self.subTest(data):
                (self.folder / "absurd.exr").write_bytes(header_only(data))
                self.refusal("absurd.exr")


class ShowTellsAllParts(Environments):
    def test_with_windows_types_and_values(self):
        name = self.write_exr(
            Part({"Z": constant(4, 2, 3.0)}, name="depth", data=(1, 1, 4, 2), display=(0, 0, 9, 9)),
            Part(grey([[1.0, math.nan, 2.0]]), name="color", kind="half",
                 display=(0, 0, 9, 9)))
        answer = self.json_of("show", name)
        depth, color = answer["parts"]
        self.assertEqual((depth["name"], color["name"]), ("depth", "color"))
        self.assertEqual(depth["data_window"], {"left": 1, "top": 1, "width": 4, "height": 2})
        self.assertEqual(depth["display_window"], {"left": 0, "top": 0, "width": 10, "height": 10})
        self.assertEqual([c["name"] for c in color["channels"]], ["B", "G", "R"])
        blue = color["channels"][0]
        self.assertEqual((blue["type"], blue["least"], blue["greatest"], blue["mean"], blue["not_finite"]),
                         ("half", 1, 2, 1.5, 1))
        self.assertEqual(answer["channels"], depth["channels"])
        table = self.lamella("show", name).out
        for word in ("part 0 of 2", "part 1 of 2", "depth", "color", "not finite"):
            self.assertIn(word, table)
