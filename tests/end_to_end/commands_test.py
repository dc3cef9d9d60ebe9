import json
import subprocess

from lamella_program import PROGRAM, WITH_CAIRO, ProgramTest

QUICK = ["--walks", "2000"]
EXR_MAGIC = b"\x76\x2f\x31\x01"


class EveryCommandDoesWhatItSays(ProgramTest):
    def test_version_and_help_are_answers(self):
        self.assertRegex(self.lamella("--version").out, r"^lamella \d+\.\d+\.\d+\n$")
        commands = ["simulate", "compare", "furnace", "accuracy", "eval", "explain", "models", "media",
                    "stacks", "measure", "reproduce"]
        overview = self.lamella("--help").out
        for command in commands:
            with self.subTest(command):
                self.assertIn(command, overview)
                text = self.lamella(command, "--help").out
                self.assertIn(f"Usage: lamella {command}", text)
                self.assertIn("Example: ", text)

    def test_simulate_writes_a_file_only_where_asked(self):
        table = self.lamella("simulate", "sggx_slab", *QUICK).out
        self.assertIn("reflected", table)
        self.assertIn("theta_i 80", table)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.lamella("simulate", "sggx_slab", *QUICK, "--wi", "30", "-o", "lobes.exr")
        exr = (self.folder / "lobes.exr").read_bytes()
        self.assertTrue(exr.startswith(EXR_MAGIC))
        for channel in (b"wi0.reflect.all.Y", b"wi0.reflect.order1.se.Y",
                        b"wi0.transmit.order4plus.Y"):
            self.assertIn(channel, exr)

    def test_the_default_stack_runs_without_a_name(self):
        answer = self.json_of("simulate", *QUICK, "--quiet")
        self.assertEqual(answer["stack"]["name"], "spongecake_two_layer")
        self.assertEqual([round(run["mu_i"], 6) for run in answer["runs"]],
                         [1, 0.866025, 0.5, 0.173648])

    def test_json_leaves_stdout_to_itself(self):
        for arguments in (["simulate", *QUICK], ["compare", "sggx_slab", *QUICK, "--grid", "4x8", "--wi",
                                                         "30"],
                          ["furnace", *QUICK], ["furnace", "--model", "lambert"], ["explain"],
                          ["models"], ["media"], ["stacks"]):
            with self.subTest(arguments[0]):
                answer = self.lamella(*arguments, "--json", "-")
                json.loads(answer.out)
                self.assertNotEqual(answer.err, "")
                quiet = self.lamella(*arguments, "--json", "-", "--quiet")
                json.loads(quiet.out)
                self.assertEqual(quiet.err, "")

    def test_json_goes_to_a_file_beside_the_table(self):
        answer = self.lamella("simulate", *QUICK, "--json", "answer.json")
        self.assertIn("reflected", answer.out)
        self.assertEqual(json.loads((self.folder / "answer.json").read_text())["walks"], 2000)

    def test_quiet_prints_nothing(self):
        for command in ("simulate", "furnace", "explain", "models", "media", "stacks"):
            with self.subTest(command):
                walks = QUICK if command in ("simulate", "furnace") else []
                answer = self.lamella(command, *walks, "--quiet")
                self.assertEqual(answer.out + answer.err, "")

    def test_compare_fills_its_default_folder_or_the_one_asked_for(self):
        for output, folder in (([], "sggx_slab-compare"), (["-o", "deep/er"], "deep/er")):
            with self.subTest(folder):
                answer = self.lamella("compare", "sggx_slab", *QUICK, "--wi", "30", *output)
                self.assertIn("single_scattering", answer.out)
                names = {path.name for path in (self.folder / folder).iterdir()}
                self.assertLessEqual({"truth.exr", "single_scattering.exr", "spongecake.exr",
                                      "report.json", "summary.txt"}, names)
                self.assertEqual(any(name.endswith(".png") for name in names), WITH_CAIRO)
                exr = (self.folder / folder / "single_scattering.exr").read_bytes()
                for layer in (b"truth", b"model", b"difference", b"z"):
                    self.assertIn(b"wi0.reflect.order1." + layer, exr)

    def test_compare_takes_models_more_than_once_with_lists_in_them(self):
        answer = self.json_of("compare", "lambert_sphere_halfspace", *QUICK, "--wi", "30",
                              "--model", "lambert,albedo=0.4", "--model",
                              "lambert,albedo=0.9,0.5,0.2", "--grid", "4x8", "-o", "out")
        self.assertEqual([m["parameters"]["albedo"] for m in answer["models"]],
                         [0.4, [0.9, 0.5, 0.2]])

    def test_a_model_beyond_the_largest_error_gives_status_1(self):
        arguments = ["compare", "lambert_sphere_halfspace", "--walks", "1e4", "--wi", "30",
                     "--model", "lambert,albedo=0.1", "--grid", "4x8", "--quiet", "-o", "out"]
        self.lamella(*arguments)
        self.lamella(*arguments, "--max-error", "0.01", status=1)
        self.lamella(*arguments, "--max-error", "10")

    def test_a_model_that_reflects_where_nothing_does_is_beyond_any_error(self):
        self.write("black.toml", '[[layer]]\nmedium = "lambert_sphere"\nalbedo = 0\n'
                                 'thickness = inf\n')
        self.lamella("compare", "black.toml", *QUICK, "--model", "lambert,albedo=1", "--max-error", "0.5",
                     "--wi", "60", status=1)

    def test_the_stack_may_come_from_stdin(self):
        text = '[[layer]]\nmedium = "lambert_sphere"\nalbedo = 0.5\nthickness = 1\n'
        answer = self.json_of("simulate", "-", *QUICK, "--quiet", stdin=text)
        self.assertEqual(answer["stack"]["name"], "stdin")
        self.assertEqual(answer["stack"]["layer"][0]["albedo"], 0.5)
        self.json_of("compare", "-", *QUICK, "--grid", "2x4", "--wi", "0", stdin=text)
        self.assertTrue((self.folder / "stdin-compare").is_dir())

    def test_the_answer_names_the_stack_after_its_file(self):
        self.write("my.toml", '[[layer]]\nmedium = "lambert_sphere"\nthickness = 1\n')
        self.assertEqual(self.json_of("explain", "my.toml")["stack"]["name"], "my")

    def test_walks_may_be_written_as_a_power(self):
        self.assertEqual(self.json_of("simulate", "--walks", "2e3", "--quiet")["walks"], 2000)

    def test_energy_is_a_ledger(self):
        for stack in ("spongecake_window_shade", "spongecake_sheen", "vmf_sand"):
            for run in self.json_of("simulate", stack, *QUICK, "--quiet")["runs"]:
                for c in range(3):
                    parts = [run["reflected"]["total"][c], run["transmitted"]["total"][c],
                             run["uncollided"][c], run["absorbed"][c], run["unresolved"][c]]
                    self.assertAlmostEqual(sum(parts), 1, delta=1e-9)

    def test_explain_prints_the_plan_and_the_order_limit(self):
        text = self.lamella("explain", "sggx_slab", "--max-order", "7").out
        self.assertIn("because", text)
        self.assertIn("cut after 7 events", text)

    def test_lists_name_what_there_is(self):
        self.assertIn("single_scattering", self.lamella("models").out)
        self.assertIn("henyey_greenstein", self.lamella("media").out)
        names = [stack["name"] for stack in self.json_of("stacks")["stacks"]]
        for name in ("spongecake_two_layer", "lambert_sphere_halfspace", "vmf_sand"):
            self.assertIn(name, names)

    def test_a_full_disk_behind_stdout_is_an_error(self):
        with open("/dev/full", "w") as full:
            process = subprocess.run([PROGRAM, "stacks"], stdout=full, stderr=subprocess.PIPE,
                                     text=True, check=False)
        self.assertEqual(process.returncode, 2)
        self.assertIn("No space left", process.stderr)


class IncidentDirections(ProgramTest):
    def runs(self, *arguments, stack="sggx_slab"):
        return self.json_of("simulate", stack, *QUICK, "--quiet", *arguments)["runs"]

    def test_may_be_given_twice_and_with_an_azimuth(self):
        runs = self.runs("--wi", "30,45", "--wi", "60", stack="spongecake_window_shade")
        self.assertEqual([run["phi_i"] for run in runs], [45, 0])
        self.assertAlmostEqual(runs[0]["mu_i"], 0.75**0.5)

    def test_above_90_light_comes_from_below(self):
        runs = self.runs("--wi", "120")
        self.assertAlmostEqual(runs[0]["mu_i"], -0.5)
        self.assertGreater(runs[0]["reflected"]["total"][0], 0.1)

    def test_at_90_the_cosine_is_0_and_nothing_passes(self):
        run = self.runs("--wi", "90")[0]
        self.assertEqual(run["mu_i"], 0)
        self.assertEqual(run["uncollided"], [0])

    def test_at_normal_incidence_an_azimuth_is_taken(self):
        self.assertEqual(len(self.runs("--wi", "0,30", stack="spongecake_window_shade")), 1)


class Furnaces(ProgramTest):
    def verdict(self, *arguments, status=0):
        return self.json_of("furnace", *arguments, "--quiet", status=status)["verdict"]

    def test_a_white_slab_passes(self):
        # Analog walks lose nothing to the last bit; next-event estimates need enough of them.
        self.assertEqual(self.verdict("spongecake_two_layer", *QUICK, "--estimator", "analog"), "pass")
        self.assertEqual(self.verdict("spongecake_two_layer", *QUICK), "inconclusive")

    def test_absorption_fails_no_furnace_as_it_is(self):
        self.assertEqual(self.verdict("spongecake_sheen", "--walks", "1e6", "--wi", "30", "--as-is"), "pass")

    def test_what_facets_lose_is_told(self):
        out = self.lamella("furnace", "coated_lambert", *QUICK, "--estimator", "analog", status=1).out
        self.assertIn("facets lose 0.0", out)

    def test_albedo_substrate_and_f0_are_whitened(self):
        for stack in ("spongecake_sheen", "spongecake_copper"):
            answer = self.json_of("furnace", stack, *QUICK, "--quiet")
            self.assertTrue(all(run["absorbed"] == [0] for run in answer["runs"]))

    def test_long_walks_are_thinned_where_little_is_absorbed(self):
        arguments = ["lambert_sphere_white", *QUICK, "--wi", "60", "--quiet"]
        thinned = self.json_of("simulate", *arguments)["runs"][0]
        self.assertEqual((thinned["thinned_from"], thinned["max_order"]), (16, 1048576))
        self.assertAlmostEqual(thinned["reflected"]["total"][0] + thinned["thinned"][0]
                               + thinned["unresolved"][0], 1, 9)
        self.assertEqual(thinned["absorbed"], [0])
        never = self.json_of("simulate", *arguments, "--thin-from", "0")["runs"][0]
        self.assertNotIn("thinned", never)
        self.assertEqual(never["max_order"], 1000)
        self.assertGreater(never["unresolved"][0], 0.01)
        self.assertIn("thinned: after 16 events", self.lamella("explain", "lambert_sphere_white").out)
        self.assertNotIn("thinned", self.lamella("explain", "sggx_slab").out)

    def test_order_1_is_exact_where_it_has_a_closed_form(self):
        arguments = ["simulate", "sggx_slab", "--walks", "4e4", "--grid", "4x8", "--wi", "60", "--quiet"]
        exact = self.json_of(*arguments, "-o", "exact.exr")["runs"][0]
        counted = self.json_of(*arguments, "--walk-order-1", "-o", "counted.exr")["runs"][0]
        solved = self.json_of("simulate", "sggx_slab", "--wi", "60", "--estimator", "deterministic",
                              "--quiet")["runs"][0]
        self.assertEqual((exact["order_1"], counted["order_1"]), ("exact", "walked"))
        self.assertGreater(exact["order_1_p_value"], 1e-6)
        for side in ("reflected", "transmitted"):
            first, walked, truth = (run[side]["orders"]["1"] for run in (exact, counted, solved))
            self.assertAlmostEqual(first["total"][0], truth["total"][0], delta=1e-3 * truth["total"][0])
            self.assertLess(first["standard_error"][0], 0.01 * walked["standard_error"][0])
            self.assertLessEqual(exact[side]["standard_error"][0], counted[side]["standard_error"][0])
            self.assertAlmostEqual(sum(lobe["total"][0] for lobe in exact[side]["orders"].values()),
                                   exact[side]["total"][0], 12)
        books = sum(exact[part]["total"][0] for part in ("reflected", "transmitted"))
        self.assertAlmostEqual(books + sum(exact[part][0] for part in (
            "uncollided", "absorbed", "unresolved")), 1, 9)
        for name, order_one in (("exact", "exact"), ("counted", "walked")):
            shown = self.json_of("show", f"{name}.exr", "--quiet")["attributes"]
            self.assertEqual(shown["lamella.order_1"], order_one)
            self.assertTrue(self.json_of("rerun", f"{name}.exr", "--quiet")["same"])
        few = self.json_of("simulate", "sggx_slab", *QUICK, "--wi", "60", "--quiet")["runs"][0]
        self.assertEqual(few["order_1"], "walked")
        self.assertIn("exact; walks count it", self.lamella("explain", "sggx_slab").out)
        self.assertIn("counted by walks", self.lamella("explain", "coated_lambert_sphere").out)

    def test_a_white_half_space_cut_short_is_inconclusive(self):
        arguments = ["lambert_sphere_white", *QUICK, "--max-order", "20"]
        self.assertEqual(self.verdict(*arguments), "inconclusive")
        self.assertEqual(self.verdict(*arguments, "--strict", status=1), "inconclusive")

    def test_near_mirrors_that_few_walks_hit_are_no_failure(self):
        self.write("mirror.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.001\n'
                                  'thickness = 1e9\n')
        self.assertEqual(self.verdict("mirror.toml", *QUICK, "--wi", "30"), "inconclusive")
        self.assertEqual(self.verdict("mirror.toml", *QUICK, "--wi", "30", "--estimator",
                                      "analog", "--max-order", "1000000", "--thin-from", "0"), "pass")

    def test_delta_flakes_have_no_radiance_check(self):
        self.write("delta.toml", '[[layer]]\nmedium = "vmf_flake"\nroughness = 0\n'
                                 'flake = "mirror"\nthickness = 1\n')
        answer = self.json_of("furnace", "delta.toml", *QUICK, "--wi", "30", "--quiet", "--estimator",
                              "analog")
        self.assertEqual(answer["verdict"], "pass")
        self.assertNotIn("radiance", answer["runs"][0])

    def test_a_closed_form_passes_or_fails(self):
        self.assertEqual(self.verdict("--model", "lambert"), "pass")
        self.assertEqual(self.verdict("--model", "lambert,albedo=0.5"), "pass")
        self.assertEqual(self.verdict("sggx_slab", "--model", "single_scattering", status=1),
                         "fail")
        self.assertEqual(self.verdict("sggx_slab", "--model", "single_scattering", "--max-error",
                                      "1"), "pass")
        self.assertEqual(self.verdict("--model", "lambert,albedo=0.5", "--as-is"), "pass")
