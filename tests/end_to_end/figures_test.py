"""Published figures that need no explicit geometry, at a tiny size."""

import os
import unittest

from lamella_program import WITH_CAIRO, ProgramTest, check_schema

in_soak = unittest.skipUnless("LAMELLA_SOAK" in os.environ, "a minute and more of solver: in the soak")


# Those without pictures.
TABLES = {"eon_table_1", "spongecake_figure_7"}

# Findings that hold at any size, by figure: words of the paper's statement, and whether they agree.
CERTAIN = {
    "eon_figure_3": [("most prominent in the grazing", True), ("gain energy", True)],
    "eon_figure_6": [("eqs. 5 and 8", True), ("exceeds 1 at grazing angles and high sigma", False)],
    "eon_figure_7": [("eqs. 12 and 13", True), ("eq. 14 differs by less", True)],
    "eon_figure_9": [("passes the white furnace", True)],
    "eon_figure_10": [("white EON times the colour", True)],
    "eon_figure_11": [("slight bias", True), ("wastes samples", True)],
    "eon_figure_13": [("at r = 0 both", True)],
    "lambert_sphere_figure_3": [("mode 2 of multiple scattering", True)],
    "lambert_sphere_figure_4": [("very accurate", True)],
    "lambert_sphere_figure_6": [("fits follow", True)],
    "lambert_sphere_figure_7": [("Hapke's model underpredicts", True)],
    "micrograin_figure_10": [("n = 20", True), ("conservative", True)],
    "micrograin_figure_11": [("equal at theta_i", True)],
    "micrograin_figure_14": [("share of the area", True)],
    "spongecake_figure_15": [("black spots", True)],
    "spongecake_figure_18": [("much darker in transmission", True)],
}


class EveryFigure(ProgramTest):
    def check(self, name, answer, folder):
        self.assertTrue(answer["rows"], name)
        self.assertTrue(answer["findings"], name)
        self.assertEqual(bool(answer["pictures"]), WITH_CAIRO and name not in TABLES, name)
        for picture in answer["pictures"]:
            self.assertTrue((folder / picture).read_bytes().startswith(b"\x89PNG"), picture)
        for words, agrees in CERTAIN.get(name, []):
            found = [f for f in answer["findings"] if words in f["paper"]]
            self.assertEqual([f["agrees"] for f in found], [agrees], f"{name}: {words}: {found}")

    def test_runs_as_a_draft_and_tells_what_agrees(self):
        for figure in self.json_of("reproduce", "--quiet")["reproductions"]:
            name = figure["name"]
            with self.subTest(name):
                run = self.run_program("reproduce", name, "--quality", "draft", "--quiet", "-o", name,
                                       "--json", "-")
                if run.status == 2 and "Embree" in run.err:
                    continue
                self.assertEqual(run.status, 0, str(run))
                check_schema("reproduce", run.json())
                self.check(name, run.json(), self.folder / name)

    @in_soak
    def test_all_make_one_page(self):
        answer = self.json_of("reproduce", "--all", "--quality", "draft", "--quiet", "-o", "all")
        page = (self.folder / "all" / "index.html").read_text()
        for figure in answer["reproductions"]:
            name = figure["name"]
            self.assertIn(f'<h2 id="{name}">', page)
            if "left_out" not in figure:
                self.check(name, figure, self.folder / "all" / name)
                for picture in figure["pictures"]:
                    self.assertIn(f'src="{name}/{picture}"', page)

    def test_a_name_and_all_are_refused_together(self):
        self.assertIn("--all", self.lamella("reproduce", "--all", "eon_figure_3", status=2).err)


class FiguresOfSurfaces(ProgramTest):
    def reproduce(self, name, *arguments):
        answer = self.json_of("reproduce", name, *arguments, "--quiet", "-o", name)
        if WITH_CAIRO:
            self.assertTrue(answer["pictures"])
        for picture in answer["pictures"]:
            self.assertTrue((self.folder / name / picture).read_bytes().startswith(b"\x89PNG"))
        return answer["rows"]

    def test_are_listed(self):
        names = [r["name"] for r in self.json_of("reproduce", "--quiet")["reproductions"]]
        for name in ("vmf_figure_9", "lambert_sphere_figure_13", "spongecake_figure_14",
                     "spongecake_figure_16"):
            self.assertIn(name, names)

    def test_doubled_flakes_are_facets_that_share_their_heights(self):
        rows = self.reproduce("spongecake_figure_14")
        for row in rows:
            with self.subTest(row):
                if row["masking"] == "beta":
                    self.assertLess(row["relative_rmse"], 1e-10)
                else:
                    self.assertLess(row["relative_rmse"], 0.5)
                    self.assertGreater(row["relative_rmse"], 1e-4)

    @in_soak
    def test_sheen_of_facets_and_fibers(self):
        rows = self.reproduce("spongecake_figure_16")
        self.assertEqual([row["roughness"] for row in rows], [0.1, 0.2, 0.4, 0.7, 1.0])
        for row in rows:
            # Orders beyond the first only add, but for the table's scale.
            self.assertGreater(row["all_orders"]["luminance"], 0.99 * row["fibers"]["luminance"])
            self.assertGreater(row["fibers"]["rim"], 0.99 * row["fibers"]["luminance"])

    @in_soak
    def test_coats_over_flakes(self):
        rows = self.reproduce("vmf_figure_9", "--walks", "128")
        by_form = {(r["roughness"], r["picture"]): r["difference"]["relative_rmse"] for r in rows}
        # Over Lambert's law (r = 0) saunderson is exact.
        self.assertLess(by_form[0, "saunderson"], 5e-3)
        for roughness in (0, 0.5, 1):
            self.assertLess(by_form[roughness, "walks"], 0.3)

    def test_coats_over_bases(self):
        rows = self.reproduce("lambert_sphere_figure_13", "--walks", "128")
        self.assertEqual(len(rows), 10)
        by_name = {(r["coated"], r["picture"]): r["difference"] for r in rows}
        # The BRDF stands for the medium.
        for coated in (False, True):
            self.assertLess(by_name[coated, "their BRDF, solver"]["relative_rmse"], 0.02)
        self.assertLess(by_name[True, "BRDF, walks"]["relative_rmse"], 0.3)
