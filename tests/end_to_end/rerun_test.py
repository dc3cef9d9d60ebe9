from lamella_program import ProgramTest

QUICK = ["--walks", "3000", "--grid", "4x8", "--quiet"]


class AFileTellsHowItWasMade(ProgramTest):
    def test_show_prints_the_run_and_every_channel(self):
        self.lamella("simulate", "spongecake_copper", "--wi", "12.5,40", "--seed", "7", *QUICK,
                     "-o", "a.exr")
        text = self.lamella("show", "a.exr").out
        for part in ("4 pixels", "seed           7", "walks          3000", "12.5,40",
                     'medium = "sggx"', "wi0.reflect.order1.se.R", "wi0.reflect.all.B"):
            self.assertIn(part, text)
        answer = self.json_of("show", "a.exr", "--quiet")
        self.assertEqual(answer["attributes"]["lamella.estimator"], "analog")
        mean = next(c["mean"] for c in answer["channels"] if c["name"] == "wi0.reflect.all.R")
        self.assertGreater(mean, 0.01)

    def test_show_takes_any_exr_but_nothing_else(self):
        self.write("no.exr", "not an EXR")
        self.assertIn("no.exr", self.lamella("show", "no.exr", status=2).err)
        self.assertIn("absent.exr", self.lamella("show", "absent.exr", status=2).err)


class ARunIsRepeatedBitByBit(ProgramTest):
    def repeated(self, file, *arguments):
        answer = self.json_of("rerun", file, "--quiet", *arguments)
        self.assertEqual((answer["same"], answer["differences"]), (True, []))

    def test_of_simulate_whatever_decided_when_to_stop(self):
        # An azimuth that degrees do not hold exactly; a run that stops on its error.
        self.lamella("simulate", "spongecake_window_shade", "--wi", "33.333333333333336,0.1234567890123",
                     "--wi", "120", "--seed", "3", *QUICK, "-o", "a.exr")
        self.repeated("a.exr", "--threads", "3")
        self.lamella("simulate", "sggx_slab", "--wi", "60", "--target-error", "0.01",
                     "--estimator", "next-event", "--grid", "2x4", "--quiet", "-o", "b.exr")
        self.repeated("b.exr")
        # Thinned by default, and from an event that was asked for.
        for options in ([], ["--thin-from", "4", "--max-order", "5000"]):
            self.lamella("simulate", "lambert_sphere_white", "--wi", "60", *QUICK, *options, "-o", "c.exr")
            self.repeated("c.exr", "--threads", "3")

    def test_of_the_solver_too(self):
        self.lamella("compare", "lambert_sphere_halfspace", "--wi", "60", "--tolerance", "1e-4", "--grid", "4x8",
                     "--model", "lambert_sphere", "--quiet", "-o", "out")
        self.assertEqual(self.json_of("show", "out/truth.exr", "--quiet")["attributes"]["lamella.estimator"],
                         "deterministic")
        self.repeated("out/truth.exr")
        self.repeated("out/lambert_sphere.exr")

    def test_of_the_solver_to_the_last_digit_of_its_bounds(self):
        # Bounds are differences of nearly equal numbers: kernels have to be made as many at once.
        self.write("haze.toml", '[[layer]]\nmedium = "henyey_greenstein"\ng = 0.3\nthickness = 2\n'
                                'albedo = 0.20000000298023224\n')
        self.lamella("simulate", "haze.toml", "--wi", "30", "--wi", "60", "--estimator", "deterministic", "--quiet", "-o",
                     "haze.exr")
        self.repeated("haze.exr")

    def test_of_the_solver_whatever_ended_its_refinement(self):
        # Asked for, and ended by the clock, which a repeated run takes no notice of.
        for file, *options in (("asked.exr", "--tolerance", "1e-4"),
                               ("clock.exr", "--tolerance", "1e-12", "--time", "0.3")):
            self.lamella("simulate", "sggx_slab", "--wi", "45", "--wi", "70", "--estimator",
                         "deterministic", "--grid", "4x8", *options, "--quiet", "-o", file)
            self.repeated(file, "--threads", "3")

    def test_of_cells_whose_second_order_is_integrated(self):
        self.write("fibers.toml", '[[layer]]\nmedium = "sggx"\nshape = "fiber"\nroughness = 0.3\naxis = [1, 0, 0]\n'
                   "albedo = 0.9\nthickness = 1\n")
        answer = self.json_of("simulate", "fibers.toml", "--wi", "45", "--estimator", "deterministic", "--tolerance",
                              "1e-5", "--grid", "4x8", "--quiet", "-o", "a.exr")
        accuracy = answer["runs"][0]["accuracy"]
        self.assertTrue(accuracy["reached"])
        # Values and bounds depend on the degree from which on they were.
        self.assertEqual(accuracy["integrated_from"], accuracy["harmonics"])
        self.repeated("a.exr", "--threads", "3")

    def test_of_compare_the_truth_and_each_model(self):
        self.write("mine.toml", '[[layer]]\nmedium = "lambert_sphere"\nalbedo = [0.9, 0.5, 0.1]\n'
                                "thickness = inf\n")
        self.lamella("compare", "mine.toml", "--wi", "60", "--wi", "90", *QUICK, "-o", "out", "--model",
                     "lambert_sphere", "--model", "lambert,albedo=0.3,0.2,0.1")
        for name in ("truth", "lambert_sphere", "lambert"):
            self.repeated(f"out/{name}.exr")

    def test_of_colours_whose_solution_the_clock_cut_short(self):
        self.write("mine.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.3\nalbedo = [0.9, 0.5, 0.1]\n'
                                "thickness = 1\n")
        self.lamella("simulate", "mine.toml", "--wi", "60", "--grid", "4x8", "--estimator", "deterministic", "--tolerance",
                     "1e-9", "--time", "0.7", "--quiet", "-o", "a.exr")
        self.repeated("a.exr")

    def test_and_written_where_asked(self):
        self.lamella("simulate", "hg_slab", "--wi", "30", *QUICK, "-o", "a.exr")
        self.lamella("rerun", "a.exr", "-o", "b.exr")
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())

    def test_what_was_changed_is_found(self):
        self.lamella("simulate", "hg_slab", "--wi", "30", *QUICK, "-o", "a.exr")
        path = self.folder / "a.exr"
        data = path.read_bytes()
        self.assertEqual(data.count(b"\x01\x00\x00\x001"), data.count(b"\x01\x00\x00\x001"))
        changed = data.replace(b"lamella.seed\0string\0\x01\0\0\x001", b"lamella.seed\0string\0\x01\0\0\x002")
        self.assertNotEqual(changed, data)
        path.write_bytes(changed)
        answer = self.json_of("rerun", "a.exr", "--quiet", status=1)
        self.assertIn("channel wi0.reflect.all.Y", answer["differences"])
        self.assertGreater(answer["largest_difference"], 0)

    def test_a_file_of_another_kind_is_refused(self):
        self.lamella("preview", "hg_slab", "--size", "16", "--model", "lambert", "--quiet", "-o", "out")
        self.assertIn("found no attribute", self.lamella("rerun", "out/sphere_lamp.exr", status=2).err)
