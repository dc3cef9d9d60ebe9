"""Every option of every command, given what it does not take: one line that says what is wrong."""

import os
import re

from lamella_program import WITH_CAIRO, WITH_CERES, ProgramTest

# What a command takes beside options, so that the option is what is wrong with it.
WORDS = {"eval": ["lambert", "--pairs", "pairs.csv"], "tabulate": ["eon"], "invert": ["eon", "albedo=0.5"],
         "sweep": ["sggx_slab", "--set", "layer.0.albedo=0.5"], "show": ["lobes.exr"], "rerun": ["lobes.exr"],
         "merge": ["one.part"], "library": ["verify", "folder"],
         "grid": ["weave"], "reproduce": ["vmf_figure_5"], "completion": ["bash"], "measure": ["sphere_bed_dense"],
         "check": ["lambert"],
         "export": ["lambert", "--to", "csv", "--output", "new.csv"], "import": ["grey.bsdf"]}

# Wrong values by the type that --help names.
NUMBERS = ["", "x", "-1", "1,2", "nan", "0x10", "1e", " "]
WRONG = {
    "N": [*NUMBERS, "1.5", "99999999999999999999999"],
    "K": [*NUMBERS, "1.5"],
    "E": [*NUMBERS],
    "S": [*NUMBERS, "0", "inf"],
    "F": [*NUMBERS, "2"],
    "MUxPHI": ["", "x", "4", "0x8", "4x", "4x8x2", "-4x8", "99999x1"],
    "THETA[,PHI]": ["", "x", "-1", "200", "30,", "30,x", "1,2,3", "nan"],
    "U,V": ["", "x", "0.5", "2,0", "0,1,2", "nan,0", "mean"],
    "SHAPE": ["", "none.obj", "folder", "file"],
    "MU": ["", "x", "0", "1.5", "nan"],
    "THETA": ["", "x", "-1", "91", "nan"],
    "FILE": ["", "none/x.json", "folder", "file/x.json"],
    "FILE.exr": ["", "none/x.exr", "folder.exr", "x.png", "x"],
    "FILE.vdb": ["", "none/x.vdb", "folder.vdb", "x.png"],
    "FILE.toml": ["", "none/x.toml", "folder.toml", "x.png"],
    "FILE.npz|FOLDER": ["", "none/x.npz", "x.png", "file"],
    "latin:N": ["", "latin", "latin:", "latin:0", "latin:x", "sobol:4", "latin:1e9"],
    "FILE.html": ["", "none/x.html", "folder.html", "x.png"],
    "JSON": ["", "none.json", "folder", "file", "pairs.csv"],
    "FILE.csv": ["", "none/x.csv", "folder", "x.png", "x"],
    "FILE.part": ["", "none/x.part", "folder", "x.png", "x"],
    "RESULT": ["", "none/x.exr", "folder", "x.png", "x"],
    "I/N": ["", "x", "1", "0/2", "3/2", "1/2/3", "1/0", "-1/2", "auto", "auto/0", "auto/2", "1/1000001"],
    "LIBRARY": ["", "none", "file", "folder"],
    "ENTRY,...": ["", "nonsense"],
    "ENTRY[,key=value...]": ["", "nonsense"],
    "FOLDER": ["", "file", "file/x", "x.png"],
    "PATH": ["", "file/x", "folder"],
    "NAME[,key=value...]": ["", "nonsense", "eon,nonsense=1", "eon,roughness=2", "eon,roughness=x", "eon,roughness",
                            "eon,roughness=", "@none", "@folder", "./none.so", ",", "eon,=1"],
    "PATH=VALUES": ["", "x", "layer.0.albedo", "layer.9.albedo=0.5", "layer.0.nonsense=1", "layer.0.albedo=x",
                    "layer.0.albedo=0:1", "layer.0.albedo=0:1:0", "layer.0.albedo=2", "=1",
                    "layer.0.albedo=0:1:3:log", "substrate.albedo=0.5", "layer.x.albedo=1"],
    "STACK": ["", "nonsense", "none.toml", "folder"],
    "PATH=RANGE": ["", "x", "layer.0.albedo", "layer.0.albedo=0.5", "layer.0.albedo=0:1:3", "=0:1"],
    "uniform|FILE.exr": ["", "none.exr", "folder", "file"],
    "png,svg,pdf": ["", "gif", "png,gif"],
}
# --pairs reads what it names.
PAIRS = ["", "none.csv", "folder", "file", "odd.csv"]


class EveryOption(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n")
        self.write("odd.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,x,0\n")
        self.write("file", "")
        for folder in ("folder", "folder.exr", "folder.vdb", "folder.toml", "folder.html"):
            (self.folder / folder).mkdir()
        self.lamella("simulate", "sggx_slab", "--wi", "60", "--walks", "200", "--grid", "2x4", "-o", "lobes.exr",
                     "--quiet")
        self.lamella("simulate", "sggx_slab", "--wi", "60", "--walks", "200", "--grid", "2x4", "--shard", "1/1", "-o",
                     "one.part", "--quiet")
        self.there = sorted(path.name for path in self.folder.iterdir())

    def commands(self):
        text = self.lamella("--help").out
        return re.findall(r"^  ([a-z]+) ", text[text.index("\nSubcommands:"):], re.M)

    def options_of(self, command):
        """Option -> type, of its help; flags have none."""
        found = {}
        for line in self.lamella(command, "--help").out.splitlines():
            match = re.match(r"^  (?:-\w,)?(--[a-z-]+)(?: ([^ ]+))?", line)
            if match:
                kind = match[2] or ""
                found[match[1]] = kind.removesuffix(":")
        return found

    def refused(self, *arguments, parts=()):
        with self.subTest(" ".join(arguments)):
            answer = self.run_program(*arguments)
            said = str(answer)
            self.assertEqual(answer.status, 2, said)
            self.assertEqual(answer.out, "", said)
            self.assertTrue(answer.err.startswith("lamella: "), said)
            self.assertEqual(answer.err.count("\n"), 1, said)
            self.assertTrue("allowed: " in answer.err or "cannot " in answer.err, said)
            for part in parts:
                self.assertIn(part, answer.err, said)

    def test_names_what_was_wrong_and_what_is_allowed(self):
        commands = self.commands()
        self.assertGreater(len(commands), 20)
        tried, seen = 0, set()
        for command in commands:
            words = WORDS.get(command, [])
            options = self.options_of(command)
            self.assertIn("--help", options)
            self.refused(command, *words, "--nonsense", parts=['"--nonsense": unknown'])
            self.refused(command, *words, "--nonsense=3", parts=['"--nonsense": unknown'])
            for option, kind in options.items():
                if option in ("--help", "--version"):
                    continue
                if not kind:  # a flag
                    continue
                values = PAIRS if option == "--pairs" else WRONG.get(kind)
                if values is None and "|" in kind:
                    values = ["", "nonsense"]
                self.assertIsNotNone(values, f"{command} {option}: no wrong values of the type {kind}")
                given = words if option not in words else words[:words.index(option)]
                # All wrong values of an option once; by each other command that has it in the soak.
                if (option, kind) in seen and "LAMELLA_SOAK" not in os.environ:
                    continue
                seen.add((option, kind))
                for value in values:
                    if command == "fit" and not WITH_CERES or option == "--pictures" and not WITH_CAIRO:
                        continue
                    tried += 1
                    self.refused(command, *given, f"{option}={value}")
                self.refused(command, *given, option, parts=[f"{option}: found nothing"])
        self.assertGreater(tried, 200, tried)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), self.there)

    def test_texts_that_are_empty_are_no_default(self):
        for command in ("simulate", "compare", "furnace", "preview", "samples", "explain", "measure", "homogenise", "show",
                        "rerun", "models", "media", "stacks", "grid", "reproduce"):
            self.refused(command, "", parts=['found ""'])
        self.refused("sweep", "", "--set", "layer.0.albedo=0.5", parts=['STACK: found ""'])
        self.refused("eval", "", "--pairs", "pairs.csv", parts=['found ""'])
        self.refused("eval", "truth", "stack=", "--pairs", "pairs.csv", parts=['key "stack"', 'found ""'])
        self.refused("invert", "", "albedo=0.5", parts=['found ""'])
        self.refused("check", "", parts=['found ""'])
        if WITH_CERES:
            self.refused("fit", "", parts=['TARGET: found ""'])

    def test_words_beside_what_a_command_takes(self):
        for command in self.commands():
            words = WORDS.get(command, [])
            if command in ("eval", "tabulate", "invert", "grid", "check"):  # take key=value
                self.refused(command, *words[:1], "nonsense", *words[2:] if command == "eval" else [],
                             *(["--pairs", "pairs.csv"] if command == "eval" else []), parts=['"nonsense"'])
            elif command in ("accuracy", "bench", "samplers", "man", "soak", "dataset"):
                self.refused(command, "nonsense", parts=['"nonsense"'])
            else:
                self.refused(command, *(words or ["sggx_slab"]), "nonsense", parts=['"nonsense"'])
