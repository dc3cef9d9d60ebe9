from lamella_program import ProgramTest

HALF_SPACE = "lambert_sphere_halfspace"


class BrokenCommandLines(ProgramTest):
    def refused(self, arguments, *parts, stdin=""):
        """Status 2, nothing on stdout, and one line that has all of those parts."""
        with self.subTest(" ".join(arguments)):
            answer = self.lamella(*arguments, stdin=stdin, status=2)
            self.assertEqual(answer.out, "")
            self.assertTrue(answer.err.startswith("lamella: "), answer.err)
            self.assertEqual(answer.err.count("\n"), 1, answer.err)
            for part in parts:
                self.assertIn(part, answer.err)

    def test_commands_and_options(self):
        self.refused(["simulat"], '"simulat"', 'did you mean "simulate"?', "allowed: simulate,")
        self.refused(["--verson"], '"--verson"', 'did you mean "--version"?')
        self.refused(["simulate", "--walk", "3"], '"--walk"', 'did you mean "--walks"?', "allowed:")
        self.refused(["models", "--walks", "3"], '"--walks"', "allowed: --help, --json, --quiet")
        self.refused(["simulate", "sggx_slab", "hg_slab"], "simulate", '"hg_slab"')
        self.refused(["simulate", "--walks"], "--walks: found nothing; allowed: N (see lamella simulate --help)")
        self.refused(["eval", "lambert"], "--pairs", "required")
        self.refused(["eval"], "MODEL", "required")

    def test_numbers(self):
        for walks in ("0", "-5", "abc", "127", "1e99", "1.5e2x", "200.5", "nan", ""):
            self.refused(["simulate", "--walks", walks], f'--walks: found "{walks}"',
                         "allowed: a whole number from 128")
        for seed in ("-1", "1.5", "x", "18446744073709551616"):
            self.refused(["simulate", "--seed", seed], f'--seed: found "{seed}"', "allowed:")
        for threads in ("0", "-1", "5000", "two"):
            self.refused(["simulate", "--threads", threads], f'--threads: found "{threads}"',
                         "allowed: a whole number from 1 to 4096")
        for option in ("--target-error", "--time"):
            for value in ("0", "-1", "nan", "inf", "x"):
                self.refused(["simulate", option, value], f'{option}: found "{value}"',
                             "allowed: a number in (0, inf)")
        self.refused(["simulate", "--max-order", "0"], '--max-order: found "0"', "allowed:")
        for bad in ("3", "-1", "often", "2097152"):
            self.refused(["simulate", "--thin-from", bad], f'--thin-from: found "{bad}"',
                         "allowed: 0, or a power of two")
        self.refused(["compare", "--max-error", "-1"], '--max-error: found "-1"', "allowed:")

    def test_choices(self):
        self.refused(["simulate", "--estimator", "analogue"], '--estimator: found "analogue"',
                     'did you mean "analog"?', "allowed: auto, analog, next-event")
        self.refused(["simulate", "--isa", "z80"], '--isa: found "z80"', "allowed: auto, scalar")

    def test_grids(self):
        for grid in ("0x0", "16", "16x", "x32", "-4x8", "16x32x2", "5000x1", "a"):
            self.refused(["simulate", "--grid", grid], f'--grid: found "{grid}"',
                         "allowed: MUxPHI")
        # Sums of every batch would take more memory than most machines have.
        self.refused(["simulate", "--grid", "4096x4096"], "--grid", "at most 65536 cells")

    def test_incident_directions(self):
        for wi in ("200", "-10", "abc", "30,", "30,x", "nan", "30,inf", "1,2,3", ""):
            self.refused(["simulate", "--wi", wi], f'--wi: found "{wi}"',
                         "allowed: THETA[,PHI] in degrees, THETA in [0, 180]")
        for command in ("simulate", "compare", "furnace"):
            self.refused([command, HALF_SPACE, "--wi", "0", "--wi", "120"], '--wi: found "120"',
                         "half space", "allowed: THETA in [0, 90]")
        self.refused(["simulate", "spongecake_sheen", "--wi", "180"], '--wi: found "180"',
                     "opaque substrate", "allowed: THETA in [0, 90]")

    def test_stacks_that_are_not_there(self):
        self.refused(["simulate", "sggx_slb"], "sggx_slb", 'did you mean "sggx_slab"?', "allowed:")
        self.refused(["simulate", "none.toml"], "none.toml", "No such file", "allowed:")
        self.refused(["explain", "."], ".: is a directory", "allowed:")

    def test_outputs_that_cannot_be_written_are_told_before_the_run(self):
        self.write("file", "")
        (self.folder / "folder").mkdir()
        long = ["--walks", "1e12"]
        for option in ("-o", "--json"):
            self.refused(["simulate", *long, option, "none/x"], "cannot write none/x",
                         "No such file or directory")
            self.refused(["simulate", *long, option, "file/x"], "cannot write file/x",
                         "Not a directory")
            self.refused(["simulate", *long, option, "folder"], "cannot write folder",
                         "Is a directory")
        self.refused(["compare", *long, "-o", "file"], "cannot use file as a folder")
        self.refused(["compare", *long, "--json", "none/x"], "cannot write none/x")
        self.refused(["models", "--json", "none/x"], "cannot write none/x")
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["file", "folder"])

    def test_models(self):
        for command in ("compare", "furnace"):
            self.refused([command, "--model", "lambrt"], '"lambrt"', 'did you mean "lambert"?',
                         "allowed: lambert,")
            self.refused([command, "--model", "lambert,albdo=1"], "lambert", '"albdo"',
                         'did you mean "albedo"?', "allowed: albedo")
            self.refused([command, "--model", "lambert,albedo"], '"albedo"', "allowed: key=value")
        for value in ("1.2", "x", "nan", "0.1, 0.2", ""):
            self.refused(["compare", "--model", f"lambert,albedo={value}"], 'key "albedo"', value,
                         "allowed: a number or three numbers")
        self.refused(["compare", "vmf_sand", "--model", "spongecake"], "spongecake", "vmf_sand",
                     "allowed: a stack of homogeneous layers of SGGX")

    def test_eval_models(self):
        pairs = ["--pairs", self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n")]
        self.refused(["eval", "lambrt", *pairs], '"lambrt"', 'did you mean "lambert"?', "truth")
        self.refused(["eval", "lambert", "albdo=1", *pairs], '"albdo"', "allowed: albedo")
        self.refused(["eval", "lambert", "albedo=1.2", *pairs], '"albedo"', "found 1.2",
                     "in [0, 1]")
        self.refused(["eval", "lambert", "0.5", *pairs], 'found "0.5"', "allowed: key=value")
        self.refused(["eval", "lambert.difuse", *pairs], '"difuse"', 'did you mean "diffuse"?',
                     "allowed: pdf, albedo, diffuse")
        for model in ("truth", "single_scattering", "spongecake"):
            self.refused(["eval", model, *pairs], model, 'key "stack"', "found nothing", "allowed:")
        self.refused(["eval", "truth", "stack=none", *pairs], "none", "allowed:")
        self.refused(["eval", "truth", "stack=sggx_slab", "walks=10", *pairs], '"10"', "allowed:")
        self.refused(["eval", "truth", "stack=sggx_slab", "wlks=10", *pairs], '"wlks"', "allowed:")
        self.refused(["eval", "truth", "stack=sggx_slab", "seed=-1", *pairs], '"-1"', "allowed:")
        self.refused(["eval", "truth", "stack=sggx_slab", "estimator=x", *pairs], '"x"', "allowed:")
        self.refused(["eval", "truth", "stack=sggx_slab", "time=3", *pairs], '"3"', "allowed:",
                     "estimator=deterministic")
        self.refused(["eval", "media.sgx.sigma", *pairs], '"media.sgx.sigma"',
                     'did you mean "media.sggx.sigma"?', "allowed:")
        self.refused(["eval", "media.sggx.sigma", "roughness=2", *pairs], '"roughness"', "found 2",
                     "in [0.001, 1]")
        self.refused(["eval", "media.sggx.phase", *pairs], '"roughness"', "found nothing")
        self.refused(["eval", "truth", "stack=-", "--pairs", "-"], '"stack"', "stdin",
                     stdin="mu_i,phi_i,mu_o,phi_o\n")

    def test_files_of_pairs(self):
        lambert = ["eval", "lambert", "--pairs"]
        self.refused([*lambert, "none.csv"], "none.csv", "No such file", "allowed: a CSV file")
        self.refused([*lambert, "."], "Is a directory", "allowed: a CSV file")
        self.refused([*lambert, "-"], "<stdin>:1", "empty", "theta_i,phi_i,theta_o,phi_o")
        for text, *parts in [
                ("a,b\n", "p.csv:1", '"a,b"', "allowed: theta_i,phi_i,theta_o,phi_o or mu_i"),
                ("mu_i,phi_i,mu_o,phi_o\n1,0,1\n", "p.csv:2", '"1,0,1"', "four numbers"),
                ("mu_i,phi_i,mu_o,phi_o\n\n1,0,1,0,0\n", "p.csv:3", "four numbers"),
                ("mu_i,phi_i,mu_o,phi_o\n1,0,x,0\n", "p.csv:2", '"1,0,x,0"', "four numbers"),
                ("mu_i,phi_i,mu_o,phi_o\n1.1,0,1,0\n", "p.csv:2", "mu_i", "found 1.1", "[-1, 1]"),
                ("mu_i,phi_i,mu_o,phi_o\n1,0,nan,0\n", "p.csv:2", "mu_o", "found nan", "[-1, 1]"),
                ("mu_i,phi_i,mu_o,phi_o\n1,0,1,inf\n", "p.csv:2", "phi_o", "found inf", "finite"),
                ("theta_i,phi_i,theta_o,phi_o\n0,0,181,0\n", "p.csv:2", "theta_o", "found 181",
                 "[0, 180]")]:
            self.write("p.csv", text)
            self.refused([*lambert, "p.csv"], *parts)

    def test_pairs_that_a_stack_has_no_answer_to(self):
        self.write("below.csv", "theta_i,phi_i,theta_o,phi_o\n0,0,0,0\n120,0,30,0\n")
        self.write("grazing.csv", "mu_i,phi_i,mu_o,phi_o\n0,0,1,0\n0,0,0,180\n")
        for model in ("truth", "single_scattering"):
            for stack, reason in ((HALF_SPACE, "half space"),
                                  ("spongecake_sheen", "opaque substrate")):
                self.refused(["eval", model, f"stack={stack}", "--pairs", "below.csv"],
                             "below.csv:3", '"120,0,30,0"', reason, "allowed: theta_i in [0, 90]")
            self.refused(["eval", model, "stack=sggx_slab", "--pairs", "grazing.csv"],
                         "grazing.csv:3", '"0,0,0,180"', "both cosines are 0", "allowed:")
