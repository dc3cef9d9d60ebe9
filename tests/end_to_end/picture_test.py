"""Pictures and fits: their formats and, in builds without Cairo or Ceres, their absence."""

import unittest

from lamella_program import WITH_CAIRO, WITH_CERES, ProgramTest

STARTS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}
COMPARE = ["compare", "sggx_slab", "--walks", "2000", "--wi", "30", "--grid", "4x8", "--model", "lambert",
           "--quiet", "-o", "out"]


class Pictures(ProgramTest):
    def endings(self):
        return {path.suffix[1:] for path in (self.folder / "out").iterdir()} & set(STARTS)

    @unittest.skipUnless(WITH_CAIRO, "built without Cairo")
    def test_come_in_the_formats_asked_for(self):
        for formats in ("png", "svg", "pdf", "svg,pdf,png"):
            for command in (COMPARE, ["reproduce", "micrograin_figure_9", "--walks", "3000", "--quiet", "-o", "out"],
                            ["preview", "sggx_slab", "--walks", "3000", "--size", "16", "--model", "lambert",
                             "--quiet", "-o", "out"]):
                with self.subTest(f"{command[0]} {formats}"):
                    for path in (self.folder / "out").glob("*"):
                        path.unlink()
                    self.lamella(*command, "--pictures", formats)
                    self.assertEqual(self.endings(), set(formats.split(",")))
                    for path in (self.folder / "out").iterdir():
                        if path.suffix[1:] in STARTS:
                            self.assertTrue(path.read_bytes().startswith(STARTS[path.suffix[1:]]), path)

    @unittest.skipUnless(WITH_CAIRO, "built without Cairo")
    def test_of_equal_runs_are_equal_files(self):
        files = []
        for _ in range(2):
            self.lamella(*COMPARE, "--pictures", "png,svg,pdf")
            files.append({p.name: p.read_bytes() for p in (self.folder / "out").iterdir() if p.suffix[1:] in STARTS})
        self.assertGreater(len(files[0]), 3)
        self.assertEqual(files[0], files[1])

    def test_of_an_unknown_format_are_refused(self):
        error = self.lamella(*COMPARE, "--pictures", "png,gif", status=2).err
        self.assertEqual(len(error.splitlines()), 1, error)
        for part in ("--pictures", '"gif"', "allowed: png, svg, pdf"):
            self.assertIn(part, error)

    @unittest.skipIf(WITH_CAIRO, "built with Cairo")
    def test_are_left_out_with_one_line_without_cairo_and_refused_where_asked_for(self):
        loud = [word for word in COMPARE if word != "--quiet"]
        self.assertEqual(self.lamella(*loud).out.count("LAMELLA_CAIRO=OFF"), 1)
        self.assertEqual(self.endings(), set())
        error = self.lamella(*COMPARE, "--pictures", "svg", status=2).err
        self.assertEqual(len(error.splitlines()), 1, error)
        self.assertIn("LAMELLA_CAIRO=OFF", error)


class Fits(ProgramTest):
    @unittest.skipIf(WITH_CERES, "built with Ceres")
    def test_are_refused_in_one_line_without_ceres(self):
        for arguments in (["fit", "sggx_slab"], ["fit", "--sampling", "eon"]):
            error = self.lamella(*arguments, status=2).err
            self.assertEqual(len(error.splitlines()), 1, error)
            self.assertIn("LAMELLA_CERES=OFF", error)


class Numbers(ProgramTest):
    def test_of_a_colour_are_its_luminance_in_the_table_which_says_so(self):
        self.write("colour.toml", '[[layer]]\nmedium = "lambert_sphere"\nalbedo = [0.9, 0.5, 0.2]\nthickness = 1\n')
        run = ["compare", "colour.toml", "--walks", "20000", "--wi", "60", "--model", "lambert,albedo=0.9,0.5,0.2",
               "-o", "out"]
        table = self.lamella(*run).out
        self.assertIn("energies: luminance (Rec. 709)", table)
        answer = self.json_of(*run)
        lobes = {(l["side"], l["order"]): l for l in answer["models"][0]["lobes"]}
        rows = [line.split() for line in table.splitlines() if line.split()[1:2] in (["reflect"], ["transmit"])]
        self.assertEqual(len(rows), len(lobes))
        for row in rows:
            lobe = lobes[row[1], row[2]]
            for shown, field in ((row[3], "energy_truth"), (row[5], "energy_model")):
                r, g, b = lobe[field]
                self.assertAlmostEqual(float(shown), 0.2126 * r + 0.7152 * g + 0.0722 * b, delta=6e-6)

    def test_above_a_hundred_percent_are_plain(self):
        # A thousandth is reflected where the model reflects all: some 1e5 %.
        self.write("dim.toml", '[[layer]]\nmedium = "lambert_sphere"\nalbedo = 0.005\nthickness = inf\n')
        table = self.lamella("compare", "dim.toml", "--walks", "2e4", "--wi", "30", "--model", "lambert,albedo=1",
                             "--grid", "4x8", "-o", "out").out
        rows = [line for line in table.splitlines() if " reflect " in line]
        self.assertRegex(rows[-1], r" \d{4,6} % .*differs by \d{4,6} %$")
        for row in rows:
            self.assertNotRegex(row, r"e\+?\d+ *%")


if __name__ == "__main__":
    unittest.main()
