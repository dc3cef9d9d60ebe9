import json

from lamella_program import ProgramTest, check_schema, without, TIMINGS

QUICK = ["--walks", "2000", "--grid", "2x4", "--wi", "60"]
SETS = ["--set", "layer.0.roughness=0.2:0.8:3", "--set", "layer.0.albedo=0.5,1"]


class ASweepRunsOverAGridOfParameters(ProgramTest):
    def report(self, folder):
        report = json.loads((self.folder / folder / "report.json").read_text())
        check_schema("sweep", report)
        return report

    def test_every_point_is_that_stack_compared(self):
        answer = self.json_of("sweep", "sggx_slab", *SETS, *QUICK, "--quiet", "-o", "out")
        self.assertEqual([a["values"] for a in answer["axes"]], [[0.2, 0.5, 0.8], [0.5, 1]])
        self.assertEqual([p["at"] for p in answer["points"]],
                         [[i, j] for i in range(3) for j in range(2)])
        for point in answer["points"]:
            layer = point["answer"]["stack"]["layer"][0]
            self.assertEqual((layer["roughness"], layer["albedo"]),
                             ([0.2, 0.5, 0.8][point["at"][0]], [0.5, 1][point["at"][1]]))
        # A point by itself gives the same.
        alone = self.json_of("compare", "out/points/0003.toml", *QUICK, "--quiet", "-o", "alone")
        point = answer["points"][3]["answer"]
        self.assertEqual(without(alone["models"], TIMINGS), without(point["models"], TIMINGS))
        self.assertEqual(answer, self.report("out"))
        self.assertIn("<!doctype html>", (self.folder / "out/report.html").read_text())

    def test_goes_on_where_it_was_stopped(self):
        first = self.json_of("sweep", "sggx_slab", *SETS, *QUICK, "--quiet", "-o", "out")
        removed = self.folder / "out/points/0004.json"
        removed.unlink()
        answer = self.lamella("sweep", "sggx_slab", *SETS, *QUICK, "-o", "out")
        self.assertEqual(answer.out.count("(was there)"), 5)
        self.assertEqual(without(first, TIMINGS), without(self.report("out"), TIMINGS))

    def test_ctrl_c_keeps_the_points_that_are_done(self):
        arguments = ["sweep", "sggx_slab", "--set", "layer.0.roughness=0.1:1:200", "--walks", "2e5",
                     "--wi", "60", "-o", "out"]
        answer, seconds = self.interrupted(*arguments, seconds=1.5)
        self.assertEqual(answer.status, 0, str(answer))
        self.assertIn("interrupted after", answer.out)
        report = self.report("out")
        self.assertTrue(report["interrupted"])
        self.assertEqual(len(report["points"]), len(list((self.folder / "out/points").glob("*.json"))))
        self.assertLess(len(report["points"]), 200)
        self.assertFalse(any(p["answer"]["interrupted"] for p in report["points"]))

    def test_of_furnaces(self):
        answer = self.json_of("sweep", "sggx_slab", "--of", "furnace", "--set",
                              "layer.0.thickness=0.1:10:3:log", "--estimator", "deterministic",
                              "--wi", "60", "--quiet")
        self.assertEqual(answer["axes"][0]["values"], [0.1, 1, 10])
        for point in answer["points"]:
            self.assertEqual(point["answer"]["runs"][0]["verdict"], "pass")

    def test_a_folder_holds_one_sweep(self):
        self.lamella("sweep", "sggx_slab", *SETS, *QUICK, "--quiet", "-o", "out")
        answer = self.lamella("sweep", "sggx_slab", *SETS, *QUICK, "--seed", "2", "-o", "out", status=2)
        self.assertIn("another sweep", answer.err)

    def test_what_cannot_be_set_is_refused(self):
        for text, parts in {
                "layer.0.roughness": ["PATH=FROM:TO:COUNT"],
                "layer.0.roughness=1:2": ["PATH=FROM:TO:COUNT"],
                "layer.0.roughness=0:1:3:log": ["PATH=FROM:TO:COUNT"],
                "layer.3.roughness=0.1,0.2": ["layer.0 to layer.0"],
                "substrate.albedo=0.1,0.2": ["layer.0 to layer.0"],
                "layer.0.roughnes=0.1,0.2": ["roughnes", "did you mean"],
                "layer.0.roughness=0.5,1.5": ["roughness", "1.5"],
                "layer.0.thickness=inf:1:3": ["PATH=FROM:TO:COUNT"]}.items():
            with self.subTest(text):
                answer = self.lamella("sweep", "sggx_slab", "--set", text, *QUICK, "-o", "out",
                                      status=2)
                self.assertEqual(answer.err.count("\n"), 1)
                for part in parts:
                    self.assertIn(part, answer.err)
                self.assertEqual(list(self.folder.iterdir()), [])
        self.assertIn("--set", self.lamella("sweep", "sggx_slab", status=2).err)
