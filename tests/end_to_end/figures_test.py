"""Published figures that need no explicit geometry, at a tiny size."""

import os
import unittest

from lamella_program import WITH_CAIRO, ProgramTest

in_soak = unittest.skipUnless("LAMELLA_SOAK" in os.environ, "a minute and more of solver: in the soak")


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
