from lamella_program import TIMINGS, ProgramTest, without

# The rest of an answer is a function of stack, seed, walks and estimator.
VARIES = TIMINGS | {"threads"}


class RunsRepeat(ProgramTest):
    def simulate(self, *arguments):
        return self.json_of("simulate", "spongecake_window_shade", "--grid", "4x8", "--quiet",
                            *arguments)

    def energies(self, *arguments):
        # Where a time or an error is asked for a pilot would choose, perhaps another one each time.
        answer = self.simulate(*arguments, "--estimator", "analog")
        return without(answer["runs"], VARIES)

    def test_equal_runs_give_equal_files_and_answers(self):
        for estimator in ("analog", "next-event"):
            with self.subTest(estimator):
                answers = []
                for name in ("a.exr", "b.exr"):
                    answers.append(self.simulate("--walks", "3000", "--estimator", estimator, "-o",
                                                 name))
                self.assertEqual(*(without(answer, TIMINGS) for answer in answers))
                self.assertEqual((self.folder / "a.exr").read_bytes(),
                                 (self.folder / "b.exr").read_bytes())

    def test_equal_comparisons_give_equal_folders(self):
        for name in ("a", "b"):
            self.lamella("compare", "sggx_slab", "--walks", "3000", "--wi", "30", "--grid", "4x8",
                         "--quiet", "-o", name)
        names = sorted(path.name for path in (self.folder / "a").iterdir())
        self.assertEqual(names, sorted(path.name for path in (self.folder / "b").iterdir()))
        for name in names:
            if name.endswith((".exr", ".png")):
                self.assertEqual((self.folder / "a" / name).read_bytes(),
                                 (self.folder / "b" / name).read_bytes(), name)

    def test_threads_change_nothing(self):
        answers, files = [], []
        for threads in ("1", "2", "7"):
            answers.append(self.energies("--walks", "3000", "--threads", threads, "-o",
                                         f"{threads}.exr"))
            files.append((self.folder / f"{threads}.exr").read_bytes())
        self.assertEqual(answers[0], answers[1])
        self.assertEqual(answers[0], answers[2])
        self.assertEqual(len(set(files)), 1)

    def test_another_seed_is_another_run(self):
        self.assertNotEqual(self.energies("--walks", "500"),
                            self.energies("--walks", "500", "--seed", "2"))

    def test_a_run_stopped_by_its_error_repeats_by_its_walks(self):
        run = self.energies("--wi", "30", "--target-error", "0.05")[0]
        self.assertLess(run["walks"], 1000000)
        for side in ("reflected", "transmitted"):
            for lobe in [run[side], *run[side]["orders"].values()]:
                for total, error in zip(lobe["total"], lobe["standard_error"]):
                    if total > 1e-3:
                        self.assertLessEqual(error, 0.05 * total)
        again = self.energies("--wi", "30", "--walks", str(run["walks"]))[0]
        self.assertEqual(run, again)

    def test_a_run_stopped_by_time_repeats_by_its_walks(self):
        run = self.energies("--wi", "30", "--time", "0.2", "--walks", "1e12")[0]
        self.assertLess(run["walks"], 10**12)
        self.assertEqual(run, self.energies("--wi", "30", "--walks", str(run["walks"]))[0])

    def test_an_error_that_was_not_reached_is_told(self):
        answer = self.lamella("simulate", "--target-error", "1e-6", "--walks", "500", "--wi", "0")
        self.assertIn("short of --target-error", answer.err)
