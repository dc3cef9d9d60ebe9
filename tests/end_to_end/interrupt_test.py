from lamella_program import ProgramTest, check_schema


class CtrlCKeepsWhatIsThere(ProgramTest):
    # A checkpoint comes after 0.2 to 0.4 s; the rest is for a machine with other work.
    LIMIT = 10

    def test_simulate(self):
        answer, seconds = self.interrupted("simulate", "sggx_slab", "--walks", "1e12", "--json",
                                           "-", "-o", "lobes.exr")
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, self.LIMIT)
        parsed = answer.json()
        check_schema("simulate", parsed)
        self.assertTrue(parsed["interrupted"])
        self.assertEqual(len(parsed["runs"]), 1)
        self.assertTrue((self.folder / "lobes.exr").exists())
        self.assertIn("interrupted", answer.err)

    def test_a_solution(self):
        # Finer and finer until it is told to end: no double holds this tolerance.
        answer, seconds = self.interrupted("simulate", "hg_slab", "--estimator", "deterministic",
                                           "--tolerance", "1e-18", "--time", "1e6", "--wi", "30",
                                           "--grid", "4x8", "--json", "-")
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, self.LIMIT)
        parsed = answer.json()
        check_schema("simulate", parsed)
        self.assertTrue(parsed["interrupted"])
        self.assertFalse(parsed["runs"][0]["accuracy"]["reached"])

    def test_a_solution_answers_every_direction(self):
        solver = ["hg_slab", "--estimator", "deterministic", "--tolerance", "1e-18", "--time",
                  "1e6", "--grid", "4x8", "--wi", "30", "--wi", "0", "--wi", "70"]
        for command, more in (("simulate", ["-o", "lobes.exr"]),
                              ("compare", ["-o", "compared", "--quiet"]),
                              ("furnace", [])):
            arguments = [a for a in solver if command != "furnace" or a not in ("--grid", "4x8")]
            answer, seconds = self.interrupted(command, *arguments, *more, "--json", "-")
            self.assertEqual(answer.status, 0, str(answer))
            self.assertLess(seconds, self.LIMIT)
            parsed = answer.json()
            check_schema(command, parsed)
            self.assertTrue(parsed["interrupted"])
            runs = parsed["models"][0]["lobes"] if command == "compare" else parsed["runs"]
            self.assertEqual({round(run["mu_i"], 3) for run in runs}, {0.866, 1, 0.342}, command)
            self.assertEqual(answer.err.count("when it was interrupted, short of"), 3, str(answer))
        self.assertTrue((self.folder / "compared" / "report.html").exists())

    def test_compare(self):
        answer, seconds = self.interrupted("compare", "sggx_slab", "--walks", "1e12", "--json", "-",
                                           "--grid", "4x8", "--quiet")
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, self.LIMIT)
        check_schema("compare", answer.json())

    def test_a_figure(self):
        # Long ones: a solution, walks into every pixel, walks and fits of several stacks.
        for name in ("vmf_figure_4", "spongecake_figure_15", "spongecake_figure_8"):
            with self.subTest(name):
                answer, seconds = self.interrupted("reproduce", name, "--quality", "final", "-o", name, "--json",
                                                   "-", seconds=2)
                self.assertEqual(answer.status, 0, str(answer))
                self.assertLess(seconds, self.LIMIT)
                self.assertTrue(answer.json()["interrupted"])
                check_schema("reproduce", answer.json())
                self.assertIn(f"{name} is not whole; kept: ", answer.err)

    def test_furnace(self):
        answer, seconds = self.interrupted("furnace", "sggx_slab", "--walks", "1e12", "--json", "-")
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, self.LIMIT)
        check_schema("furnace", answer.json())

    def test_truth_at_points(self):
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n0.8,0,-0.9,0\n")
        answer, seconds = self.interrupted("eval", "truth", "stack=sggx_slab", "walks=1e12",
                                           "--pairs", "pairs.csv")
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, self.LIMIT)
        self.assertEqual(answer.out.count("\n"), 3)
        self.assertIn("interrupted", answer.err)

    def test_solved_truth_at_points(self):
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n0.8,0,-0.9,0\n")
        answer, seconds = self.interrupted("eval", "truth", "stack=hg_slab", "tolerance=1e-18",
                                           "estimator=deterministic", "--pairs", "pairs.csv")
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, self.LIMIT)
        self.assertEqual(answer.out.count("\n"), 3)
        self.assertIn("interrupted: a coarser solution", answer.err)
