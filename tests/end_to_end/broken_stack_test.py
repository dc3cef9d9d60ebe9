from lamella_program import ProgramTest

SPHERES = '[[layer]]\nmedium = "lambert_sphere"\nthickness = 1\n'
SGGX = '[[layer]]\nmedium = "sggx"\nthickness = 1\n'

# Name, text, line, and what the message has beside file and line.
BROKEN = [
    ("empty file", "", 1, ['key "layer"', "found nothing", "[[layer]]"]),
    ("comment only", "# nothing\n", 1, ['key "layer"', "found nothing"]),
    ("no TOML", "[[layer]\n", 1, ["not valid TOML"]),
    ("binary", "\x00\x01\x02", 1, ["not valid TOML"]),
    ("key given twice", SPHERES + "albedo = 1\nalbedo = 1\n", 5, ["not valid TOML", "albedo"]),
    ("unknown table", SPHERES + "[subtrate]\n", 4, ['"subtrate"', 'did you mean "substrate"?']),
    ("layer no table", "layer = 3\n", 1, ['key "layer"', "found 3", "[[layer]]"]),
    ("one layer table", '[layer]\nmedium = "sggx"\n', 1, ['key "layer"', "[[layer]]"]),
    ("unknown key", SPHERES + "albdo = 0.5\n", 4, ['"albdo"', 'did you mean "albedo"?',
                                                   "allowed: "]),
    ("no medium", "[[layer]]\nthickness = 1\n", 1, ['"medium"', "found nothing", "sggx"]),
    ("unknown medium", '[[layer]]\nmedium = "sgx"\nthickness = 1\n', 2,
     ['"medium"', 'found "sgx"', 'did you mean "sggx"?', "lambert_sphere"]),
    ("medium a number", "[[layer]]\nmedium = 3\n", 2, ['"medium"', "found 3", "allowed: one of"]),
    ("no thickness", '[[layer]]\nmedium = "lambert_sphere"\n', 1, ['"thickness"', "found nothing",
                                                                   "[0, inf]"]),
    ("negative thickness", '[[layer]]\nmedium = "lambert_sphere"\nthickness = -1\n', 3,
     ['"thickness"', "found -1", "[0, inf]"]),
    ("thickness nan", '[[layer]]\nmedium = "lambert_sphere"\nthickness = nan\n', 3,
     ['"thickness"', "found nan", "[0, inf]"]),
    ("thickness a string", '[[layer]]\nmedium = "lambert_sphere"\nthickness = "1"\n', 3,
     ['"thickness"', 'found "1"', "a number"]),
    ("albedo above 1", SPHERES + "albedo = 1.2\n", 4, ['"albedo"', "found 1.2", "[0, 1]"]),
    ("albedo nan", SPHERES + "albedo = nan\n", 4, ['"albedo"', "found nan", "[0, 1]"]),
    ("albedo of two", SPHERES + "albedo = [0.5, 0.5]\n", 4, ['"albedo"', "[0.5, 0.5]", "three"]),
    ("one channel above 1", SPHERES + "albedo = [0.5, 0.5, 1.5]\n", 4, ['"albedo"', "1.5",
                                                                        "[0, 1]"]),
    ("albedo true", SPHERES + "albedo = true\n", 4, ['"albedo"', "found true", "a number"]),
    ("albedo a date", SPHERES + "albedo = 2024-01-01\n", 4, ['"albedo"', "a date", "a number"]),
    ("negative density", SPHERES + "density = -1\n", 4, ['"density"', "found -1", "[0, inf)"]),
    ("density inf", SPHERES + "density = inf\n", 4, ['"density"', "found inf", "[0, inf)"]),
    ("half space of density 0",
     '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\ndensity = 0\n', 4,
     ['"density"', "found 0", "(0, inf)"]),
    ("half space not last", '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\n' + SPHERES, 3,
     ['"thickness"', "found inf", "[0, inf)", "last"]),
    ("substrate below a half space",
     '[[layer]]\nmedium = "lambert_sphere"\nthickness = inf\n[substrate]\n', 4,
     ['"substrate"', "infinite"]),
    ("substrate no table", "substrate = 1\n" + SPHERES, 1, ['"substrate"', "found 1",
                                                            "[substrate]"]),
    ("substrate of glass", SPHERES + '[substrate]\nbsdf = "glass"\n', 5,
     ['"bsdf"', '"glass"', "lambert, black"]),
    ("substrate albedo", SPHERES + "[substrate]\nalbedo = -0.1\n", 5, ['"albedo"', "found -0.1"]),
    ("black substrate that reflects", SPHERES + '[substrate]\nbsdf = "black"\nalbedo = 0.5\n', 6,
     ['"albedo"', "black", "allowed: 0"]),
    ("no roughness", SGGX, 1, ['"roughness"', "found nothing", "[0.001, 1]", "matrix"]),
    ("roughness 0", SGGX + "roughness = 0\n", 4, ['"roughness"', "found 0", "[0.001, 1]"]),
    ("a shape that is none", SGGX + 'roughness = 0.5\nshape = "fibre"\n', 5,
     ['"shape"', '"fibre"', "surface, fiber", 'did you mean "fiber"?']),
    ("matrix not positive", SGGX + "matrix = [1, 1, -1, 0, 0, 0]\n", 4,
     ['"matrix"', "-1", "positive definite"]),
    ("matrix indefinite", SGGX + "matrix = [1, 1, 1, 2, 0, 0]\n", 4,
     ['"matrix"', "positive definite"]),
    ("matrix of five", SGGX + "matrix = [1, 1, 1, 0, 0]\n", 4, ['"matrix"', "six numbers"]),
    ("matrix nan", SGGX + "matrix = [nan, 1, 1, 0, 0, 0]\n", 4, ['"matrix"', "nan"]),
    ("matrix beside roughness", SGGX + "matrix = [1, 1, 1, 0, 0, 0]\nroughness = 0.5\n", 5,
     ['"roughness"', "matrix"]),
    ("axis zero", SGGX + "roughness = 0.5\naxis = [0, 0, 0]\n", 5, ['"axis"', "not all zero"]),
    ("axis of words", SGGX + 'roughness = 0.5\naxis = ["x", 0, 0]\n', 5, ['"axis"',
                                                                          "three numbers"]),
    ("f0 of diffuse flakes", SGGX + 'roughness = 0.5\nflake = "lambert"\nf0 = 0.04\n', 6,
     ['"f0"', "mirror"]),
    ("two roughnesses", '[[layer]]\nmedium = "vmf_flake"\nthickness = 1\nroughness = 0.5\n'
                        "alpha = 1\n", 5, ['"alpha"', "roughness"]),
    ("g of 1", '[[layer]]\nmedium = "henyey_greenstein"\nthickness = 1\ng = 1\n', 4,
     ['"g"', "found 1", "(-1, 1)"]),
    ("a key of another medium", SPHERES + "g = 0.5\n", 4, ['"g"', "unknown", "allowed:"]),
]


class BrokenStackFiles(ProgramTest):
    def refused(self, answer, where, parts):
        self.assertEqual(answer.out, "")
        self.assertTrue(answer.err.startswith(f"lamella: {where}: "), str(answer))
        self.assertEqual(answer.err.count("\n"), 1, str(answer))
        for part in parts:
            self.assertIn(part, answer.err)

    def test_are_refused_with_file_line_key_and_what_is_allowed(self):
        for name, text, line, parts in BROKEN:
            with self.subTest(name):
                self.write("broken.toml", text)
                answer = self.lamella("explain", "broken.toml", status=2)
                self.refused(answer, f"broken.toml:{line}", parts)

    def test_are_refused_by_every_command(self):
        self.write("broken.toml", SPHERES + "albedo = 1.2\n")
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n1,0,1,0\n")
        for command in (["simulate"], ["compare"], ["furnace"], ["explain"]):
            with self.subTest(command[0]):
                self.refused(self.lamella(*command, "broken.toml", status=2), "broken.toml:4",
                             ['"albedo"', "found 1.2", "[0, 1]"])
        answer = self.lamella("eval", "truth", "stack=broken.toml", "--pairs", "pairs.csv",
                              status=2)
        self.refused(answer, "broken.toml:4", ['"albedo"'])

    def test_from_stdin_are_named_so(self):
        answer = self.lamella("explain", "-", stdin=SPHERES + "albedo = 2\n", status=2)
        self.refused(answer, "<stdin>:4", ['"albedo"', "found 2"])
        self.refused(self.lamella("explain", "-", status=2), "<stdin>:1", ['key "layer"'])
