"""The deterministic solver through the program: simulate, compare, furnace, eval truth, explain."""

import math

from lamella_program import ProgramTest

SOLVER = ["--estimator", "deterministic"]
SPHERES = '[[layer]]\nmedium = "lambert_sphere"\nalbedo = 0.9\nthickness = 1\n'
TILTED = ('[[layer]]\nmedium = "sggx"\nroughness = 0.5\naxis = [1, 0, 1]\nflake = "lambert"\n'
          'thickness = 1\n')
MIRROR = '[[layer]]\nmedium = "sggx"\nroughness = 0.5\nthickness = 1\n'
ONE_SIDED = '[[layer]]\nmedium = "vmf_flake"\nroughness = 0.5\nthickness = 1.5\n'


def energies(run):
    """Every energy of a run with its error, by name."""
    values = {}
    for side in ("reflected", "transmitted"):
        part = run[side]
        values[side] = list(zip(part["total"], part["standard_error"]))
        for order, estimate in part["orders"].items():
            values[f"{side} {order}"] = list(zip(estimate["total"], estimate["standard_error"]))
    return values


class SolverAndWalk(ProgramTest):
    def test_agree_on_every_energy_of_every_kind_of_stack(self):
        stacks = {
            "spheres.toml": SPHERES,
            "one_sided.toml": ONE_SIDED,
            "layers.toml": '[[layer]]\nmedium = "henyey_greenstein"\ng = 0.5\n'
                           'albedo = [0.9, 0.5, 0.2]\nthickness = 0.7\n[[layer]]\n'
                           'medium = "sggx"\nflake = "lambert"\nroughness = 0.4\nthickness = 0.5\n'
                           '[substrate]\nbsdf = "lambert"\nalbedo = 0.5\n',
        }
        # Some 110 comparisons; chance of 5 standard errors: 6e-7 each.
        for name, text in stacks.items():
            self.write(name, text)
            wi = ["--wi", "20", "--wi", "75"] + ([] if "substrate" in text else ["--wi", "120"])
            walk = self.json_of("simulate", name, *wi, "--walks", "4e4", "--quiet")
            solved = self.json_of("simulate", name, *wi, *SOLVER, "--tolerance", "1e-5", "--quiet")
            self.assertEqual(walk["estimator"], "analog")
            self.assertEqual((solved["estimator"], solved["walks"], solved["collisions"]),
                             ("deterministic", 0, 0))
            self.assertEqual(len(walk["runs"]), len(solved["runs"]))
            for a, b in zip(walk["runs"], solved["runs"]):
                self.assertTrue(b["accuracy"]["reached"])
                self.assertLessEqual(b["accuracy"]["error"], 1e-5)
                expected = energies(b)
                for what, values in energies(a).items():
                    for (f, noise), (exact, bound) in zip(values, expected[what]):
                        self.assertLessEqual(bound, 1e-5)
                        self.assertLessEqual(abs(f - exact), 5 * noise + bound + 1e-12,
                                             f"{name}, mu_i {a['mu_i']}, {what}")

    def test_the_ledger_of_the_solver_closes(self):
        self.write("spheres.toml", SPHERES)
        for run in self.json_of("simulate", "spheres.toml", *SOLVER, "--quiet")["runs"]:
            parts = (run["reflected"]["total"][0] + run["transmitted"]["total"][0] +
                     run["uncollided"][0] + run["absorbed"][0] + run["unresolved"][0])
            self.assertAlmostEqual(parts, 1, delta=1e-10)
            self.assertEqual(run["unresolved"], [0])

    def test_files_say_what_their_errors_are(self):
        self.write("spheres.toml", SPHERES)
        arguments = ["simulate", "spheres.toml", "--wi", "30", "--grid", "4x8", "--quiet"]
        self.lamella(*arguments, *SOLVER, "-o", "solved.exr")
        self.lamella(*arguments, "--walks", "2000", "-o", "walked.exr")
        solved = (self.folder / "solved.exr").read_bytes()
        walked = (self.folder / "walked.exr").read_bytes()
        for text in (b"wi0.transmit.order4plus.se.Y", b"error bound of the deterministic solver",
                     b"lamella.tolerance", b"lamella.error_reached"):
            self.assertIn(text, solved)
        self.assertNotIn(b"error bound", walked)

    def test_equal_runs_give_equal_files_for_any_number_of_threads(self):
        self.write("spheres.toml", SPHERES)
        for threads in ("1", "3"):
            self.lamella("simulate", "spheres.toml", "--grid", "4x8", "--quiet", *SOLVER,
                         "--threads", threads, "-o", f"{threads}.exr")
        self.assertEqual((self.folder / "1.exr").read_bytes(), (self.folder / "3.exr").read_bytes())


class FacetsOfLargeRoughness(ProgramTest):
    def test_cells_are_not_held_against_more_than_the_nodes_know(self):
        self.write("coat.toml", '[[layer]]\ninterface = "ggx"\nior = 1.5\nroughness = 1\n'
                                '[substrate]\nbsdf = "lambert"\nalbedo = 0.8\n')
        coarse, fine = (self.json_of("simulate", "coat.toml", "--wi", "30", *SOLVER, "--tolerance",
                                     tolerance, "--quiet")["runs"][0] for tolerance in ("1e-4", "1e-8"))
        self.assertLessEqual(coarse["accuracy"]["error"], 1e-4)
        self.assertLess(abs(coarse["reflected"]["total"][0] - fine["reflected"]["total"][0]),
                        coarse["reflected"]["standard_error"][0])


class WhereTheSolverDoesNotApply(ProgramTest):
    def test_it_is_refused_with_status_2_and_the_reason(self):
        self.write("tilted.toml", '[[layer]]\ninterface = "ggx"\nior = 1.5\n'
                                  'roughness = 0.2\nscattering = "multiple"\n'
                                  '[[layer]]\nmedium = "vmf_flake"\n'
                                  "roughness = 0.5\naxis = [1, 0, 1]\nthickness = inf\n")
        self.write("delta.toml", '[[layer]]\nmedium = "vmf_flake"\nroughness = 0\n'
                                 'flake = "mirror"\nthickness = 1\n')
        for stack, reason in (("tilted.toml", "multiple scattering"), ("delta.toml", "delta")):
            for command in ("simulate", "compare", "furnace"):
                answer = self.lamella(command, stack, *SOLVER, status=2)
                self.assertIn(reason, answer.err)
                self.assertIn("allowed: auto, analog, next-event", answer.err)
                self.assertEqual(answer.err.count("\n"), 1)
            pairs = "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,90\n"
            answer = self.lamella("eval", "truth", f"stack={stack}", "estimator=deterministic",
                                  "--pairs", "-", stdin=pairs, status=2)
            self.assertIn(reason, answer.err)
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"tilted.toml", "delta.toml"})

    def test_auto_walks_there_and_says_so(self):
        self.write("narrow.toml", TILTED.replace("0.5", "0.1"))
        answer = self.json_of("explain", "narrow.toml")
        note = next(n for n in answer["plan"] if n["subject"] == "estimator")
        self.assertIn("analog", note["decision"])
        self.assertIn("not symmetric", note["reason"])

    def test_a_bad_tolerance_names_what_is_allowed(self):
        for text in ("0", "-1", "inf", "x"):
            self.assertIn("allowed", self.lamella("simulate", "--tolerance", text, status=2).err)


class WhatAutoDecides(ProgramTest):
    def simulated(self, *arguments):
        return self.json_of("simulate", *arguments, "--wi", "30", "--grid", "4x8", "--quiet")

    def test_the_solver_where_it_reaches_the_tolerance(self):
        answer = self.simulated("lambert_sphere_halfspace")
        self.assertEqual((answer["estimator"], answer["estimator_asked"]),
                         ("deterministic", "auto"))
        self.assertIn("nodes", answer["estimator_reason"])
        self.assertEqual(answer["tolerance"], 1e-4)

    def test_the_cells_of_mirrors_hold_what_it_says(self):
        # The default stack with grazing light, where the modes of order 2 are most.
        stack = ("simulate", "spongecake_two_layer", "--wi", "30", "--wi", "80", "--grid", "4x8",
                 "--tolerance", "1e-6", "--json", "-", "--quiet")
        solved = self.lamella(*stack, "--estimator", "deterministic", "--time", "600")
        self.assertEqual(solved.err, "")
        for run in solved.json()["runs"]:
            self.assertTrue(run["accuracy"]["reached"])
            self.assertLessEqual(run["accuracy"]["error"], 1e-6)
        # auto does the same, or says what a slow machine left undone.
        parsed = self.lamella(*stack).json()
        if parsed["estimator"] == "deterministic":
            self.assertIn("the solver reaches", parsed["estimator_reason"])
            for run in parsed["runs"]:
                if "short of" not in parsed["estimator_reason"]:
                    self.assertLessEqual(run["accuracy"]["error"], 1e-6)
        else:
            self.assertIn("the solver reaches no more than", parsed["estimator_reason"])

    def test_walks_where_they_are_named(self):
        for option, value in (("--walks", "2000"), ("--time", "0.05"), ("--target-error", "0.1"),
                              ("--max-order", "100")):
            walks = [] if option in ("--walks", "--time", "--target-error") else ["--time", "0.05"]
            answer = self.simulated("lambert_sphere_halfspace", option, value, *walks)
            self.assertIn("asks for walks", answer["estimator_reason"])
            # Where time or error is what counts, a pilot run has its say.
            pilot = bool(walks) or option in ("--time", "--target-error")
            self.assertEqual("pilot" in answer["estimator_reason"], pilot)
            if pilot:
                self.assertIn(f"pilot: {answer['estimator']} has", answer["estimator_reason"])
            else:
                self.assertEqual(answer["estimator"], "analog")

    def test_explain_gives_the_same_answer_with_the_reason(self):
        note = next(n for n in self.json_of("explain", "lambert_sphere_halfspace")["plan"]
                    if n["subject"] == "estimator")
        self.assertIn("deterministic", note["decision"])
        self.assertIn("the solver reaches", note["reason"])

    def test_an_option_of_walks_beside_the_solver_is_told_of(self):
        answer = self.lamella("simulate", "lambert_sphere_halfspace", *SOLVER, "--walks", "2000",
                              "--grid", "4x8", "--quiet")
        self.assertIn("--walks means nothing", answer.err)


class WhereTheSolverHasNoAnswer(ProgramTest):
    # White stacks whose peaks no affordable number of nodes holds: R = 1, or R + T = 1.
    STACKS = {
        "forward.toml": '[[layer]]\nmedium = "henyey_greenstein"\ng = 0.999\nthickness = inf\n',
        "fibers.toml": '[[layer]]\nmedium = "sggx"\nshape = "fiber"\naxis = [0, 0, 1]\n'
                       'roughness = 0.001\nthickness = 1e3\n',
    }

    def test_auto_walks_and_says_so(self):
        # A slab: walks in the half space itself have thousands of events each.
        slab = self.STACKS["forward.toml"].replace("inf", "1")
        for name, text in {"slab.toml": slab}.items():
            self.write(name, text)
            answer = self.json_of("simulate", name, "--wi", "45", "--grid", "4x8", "--quiet")
            self.assertNotEqual(answer["estimator"], "deterministic", name)
            self.assertIn("the solver has no answer", answer["estimator_reason"])
            run, = answer["runs"]
            for what, values in energies(run).items():
                for value, error in values:
                    self.assertTrue(-5 * error - 1e-9 <= value <= 1 + 5 * error + 1e-9,
                                    (name, what, value, error))

    def test_the_solver_by_name_ends_with_one_line_and_status_3(self):
        for name, text in self.STACKS.items():
            self.write(name, text)
            answer = self.lamella("simulate", name, "--wi", "45", "--grid", "4x8", *SOLVER, "--time",
                                  "5", status=3)
            self.assertEqual(answer.err.count("\n"), 1, answer.err)
            self.assertIn("--estimator deterministic: the solver has no answer", answer.err)
            self.assertIn("allowed: auto, analog, next-event", answer.err)

    def test_what_was_reached_is_kept_where_walks_would_leave_more(self):
        answer = self.json_of("simulate", "lambert_sphere_halfspace", "--wi", "30", "--grid", "4x8",
                              "--tolerance", "1e-15", "--quiet")
        self.assertEqual(answer["estimator"], "deterministic")
        self.assertIn("short of --tolerance 1e-15", answer["estimator_reason"])
        self.assertIn("walks leave", answer["estimator_reason"])


class WhereTheToleranceIsNotReached(ProgramTest):
    def test_what_was_reached_is_told_and_stands_in_the_json(self):
        self.write("mirror.toml", MIRROR)
        arguments = ["simulate", "mirror.toml", *SOLVER, "--wi", "80", "--grid", "8x16", "--time",
                     "0.3", "--tolerance", "1e-9"]
        answer = self.lamella(*arguments, "--quiet")
        self.assertIn("short of --tolerance 1e-09", answer.err)
        run = self.json_of(*arguments, "--quiet")["runs"][0]
        self.assertFalse(run["accuracy"]["reached"])
        self.assertGreater(run["accuracy"]["error"], 1e-9)


class Comparisons(ProgramTest):
    def lobes(self, *arguments):
        answer = self.json_of("compare", *arguments, *SOLVER, "--wi", "60", "--grid", "8x16",
                              "--quiet", "-o", "out")
        return {(m["name"], lobe["order"]): lobe for m in answer["models"]
                for lobe in m["lobes"]}

    def test_an_exact_form_agrees_and_an_approximate_one_differs_by_what_it_misses(self):
        self.write("isotropic.toml", '[[layer]]\nmedium = "henyey_greenstein"\nalbedo = 0.9\n'
                                     'thickness = inf\n')
        lobes = self.lobes("isotropic.toml")
        exact = lobes["chandrasekhar", "all"]
        # The projection onto cells is accurate to 1e-4.
        self.assertEqual((exact["verdict"], exact["p_value"]), ("agrees", 1))
        self.assertLess(exact["relative_rmse"], 1e-4)
        order_one = lobes["single_scattering", "1"]
        self.assertEqual((order_one["verdict"], order_one["p_value"]), ("agrees", 1))
        short = lobes["single_scattering", "all"]
        self.assertEqual((short["verdict"], short["p_value"]), ("differs", 0))
        for lobe in lobes.values():
            self.assertEqual(lobe["rmse_without_noise"], lobe["rmse"])
            self.assertEqual(lobe["empty_cells"], 0)

    def test_the_errors_of_the_walk_are_found_again(self):
        arguments = ["compare", "lambert_sphere_halfspace", "--wi", "60", "--grid", "4x8",
                     "--quiet", "--model", "lambert_sphere_fast", "-o", "out"]
        solved, walked = (next(lobe for lobe in self.json_of(*arguments, *how)["models"][0]["lobes"]
                               if lobe["order"] == "all")
                          for how in (SOLVER, ["--walks", "2e5"]))
        # Noise of a relative RMSE of some per cent after 2e5 walks: below 5e-3.
        self.assertAlmostEqual(solved["relative_rmse"], walked["relative_rmse_without_noise"],
                               delta=5e-3)
        self.assertEqual(solved["verdict"], "differs")


class Furnaces(ProgramTest):
    def test_a_white_half_space_passes(self):
        for stack in ("lambert_sphere_white", "vmf_sand"):
            answer = self.json_of("furnace", stack, *SOLVER, "--quiet")
            self.assertEqual(answer["verdict"], "pass")
            for run in answer["runs"]:
                for energy in run["energy"]:
                    self.assertAlmostEqual(energy, 1, delta=1e-5)
                self.assertEqual(set(run["unresolved"]), {0})

    def test_a_one_sided_slab_follows_the_law_of_its_radiance(self):
        self.write("one_sided.toml", ONE_SIDED)
        answer = self.json_of("furnace", "one_sided.toml", *SOLVER, "--wi", "30", "--wi", "150",
                              "--tolerance", "1e-5", "--quiet")
        self.assertEqual(answer["verdict"], "pass")
        for run in answer["runs"]:
            radiance = run["radiance"]
            # From above dimmer, from below brighter than the light by tens of per cent.
            self.assertGreater(abs(radiance["predicted"] - 1), 0.1)
            self.assertLess(radiance["standard_error"], 1e-5)
            self.assertLess(abs(radiance["measured"] - radiance["predicted"]),
                            radiance["standard_error"] + radiance["predicted_standard_error"])

    def test_absorption_fails_no_furnace_as_it_is(self):
        self.write("spheres.toml", SPHERES)
        answer = self.json_of("furnace", "spheres.toml", *SOLVER, "--as-is", "--quiet")
        self.assertEqual(answer["verdict"], "pass")
        self.assertTrue(all(run["absorbed"][0] > 0.05 for run in answer["runs"]))


class TruthAtPoints(ProgramTest):
    PAIRS = ("mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,90\n0.5,0,-0.8,90\n-0.3,20,0.6,10\n1,0,0.01,0\n"
             "0,0,0.7,180\n")

    def rows(self, *arguments, pairs=PAIRS):
        text = self.lamella("eval", "truth", *arguments, "--pairs", "-", stdin=pairs).out
        lines = text.splitlines()
        return lines[0], [[float(x) for x in line.split(",")] for line in lines[1:]]

    def test_has_its_bound_as_se_and_holds_it_under_refinement(self):
        self.write("spheres.toml", SPHERES)
        header, coarse = self.rows("stack=spheres.toml", "estimator=deterministic",
                                   "tolerance=1e-4")
        self.assertEqual(header, "mu_i,phi_i,mu_o,phi_o,f,se")
        _, fine = self.rows("stack=spheres.toml", "estimator=deterministic", "tolerance=1e-7")
        for a, b in zip(coarse, fine):
            self.assertGreater(a[5], 0)
            self.assertLess(b[5], 2e-7 * b[4])
            self.assertLess(abs(a[4] - b[4]), a[5] + b[5])

    def test_agrees_with_walks(self):
        self.write("spheres.toml", SPHERES)
        _, solved = self.rows("stack=spheres.toml", "estimator=deterministic")
        _, walked = self.rows("stack=spheres.toml", "estimator=next-event", "walks=2e4")
        for a, b in zip(solved, walked):
            self.assertLess(abs(a[4] - b[4]), 5 * b[5])

    def test_auto_takes_the_solver_unless_walks_are_named(self):
        self.write("spheres.toml", SPHERES)
        _, solved = self.rows("stack=spheres.toml", "estimator=deterministic")
        _, auto = self.rows("stack=spheres.toml")
        self.assertEqual(auto, solved)
        _, walked = self.rows("stack=spheres.toml", "walks=2000")
        self.assertGreater(walked[0][5], 1e-4 * walked[0][4])

    def test_many_pairs_are_as_good_as_few(self):
        self.write("spheres.toml", SPHERES)
        lines = [f"{math.cos(0.01 * k):.6f},{k},{math.cos(1.5 - 0.009 * k):.6f},{7 * k}"
                 for k in range(150)]
        header = "mu_i,phi_i,mu_o,phi_o\n"
        _, many = self.rows("stack=spheres.toml", "estimator=deterministic",
                            pairs=header + "\n".join(lines) + "\n")
        _, one = self.rows("stack=spheres.toml", "estimator=deterministic",
                           pairs=header + lines[77] + "\n")
        self.assertAlmostEqual(many[77][4], one[0][4], delta=1e-12)

    def test_analog_counts_cells_and_is_refused(self):
        answer = self.lamella("eval", "truth", "stack=sggx_slab", "estimator=analog", "--pairs", "-",
                              stdin=self.PAIRS, status=2)
        self.assertIn("never meets a point", answer.err)
        self.assertIn("allowed: auto, next-event, deterministic", answer.err)
