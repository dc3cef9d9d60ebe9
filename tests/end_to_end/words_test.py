"""What is shown on the terminal, and which names and endings are taken."""

import json
import os

from lamella_program import WITH_EMBREE, ProgramTest

WIDTH = 100


class OneEntryOfAList(ProgramTest):
    def test_is_shown_alone(self):
        for command, name, other in (("models", "eon", "vmf_diffuse"), ("media", "sggx", "vmf_flake"),
                                     ("media", "micrograins", "sggx"), ("stacks", "sggx_slab", "vmf_sand")):
            with self.subTest(name):
                whole = self.json_of(command, "--quiet")[command]
                answer = self.json_of(command, name, "--quiet")[command]
                self.assertEqual(answer, [entry for entry in whole if entry["name"] == name])
                text = self.lamella(command, name).out
                self.assertTrue(text.startswith(name))
                self.assertNotIn(other, text)
        self.assertIn('medium = "sggx"', self.lamella("stacks", "sggx_slab").out)

    def test_of_a_shared_object(self):
        path = os.path.join(os.environ["LAMELLA_PLUGINS"], "minnaert.so")
        self.assertEqual(self.json_of("models", path, "--quiet")["models"][0]["name"], "minnaert")

    def test_that_is_not_there_gets_a_suggestion(self):
        for command, name, parts in (("models", "eonn", ['model "eonn"', '"eon"', "allowed: lambert,"]),
                                     ("media", "SGGX", ['medium "SGGX"', 'did you mean "sggx"?']),
                                     ("stacks", "sand", ['stack "sand"', '"vmf_sand"'])):
            answer = self.lamella(command, name, status=2)
            self.assertEqual((answer.out, answer.err.count("\n")), ("", 1))
            for part in parts:
                self.assertIn(part, answer.err)


class Suggestions(ProgramTest):
    def test_of_stacks(self):
        self.write("mystack.toml", "")
        for name, hint in (("sggx_slb", '"sggx_slab"'), ("mystck.toml", '"mystack.toml"'),
                           ("Sggx_Slab", '"sggx_slab"'), ("copper", '"spongecake_copper"')):
            for arguments in (["simulate", name], ["explain", name], ["compare", name]):
                answer = self.lamella(*arguments, status=2)
                self.assertIn(f"did you mean {hint}", answer.err)
                self.assertEqual(answer.err.count("\n"), 1)

    def test_of_what_invert_takes(self):
        for name, hint in (("vmf_difuse", '"vmf_diffuse"'), ("sggx_slb", '"sggx_slab"')):
            answer = self.lamella("invert", name, "albedo=0.5", status=2)
            self.assertIn(f"did you mean {hint}", answer.err)


class WithoutACommand(ProgramTest):
    def test_the_help_is_shown(self):
        answer = self.lamella()
        self.assertEqual(answer.out, self.lamella("--help").out)
        self.assertIn("simulate", answer.out)
        self.assertEqual(answer.err, "")


class NamesOfOutputs(ProgramTest):
    def test_with_the_ending_of_another_format_are_refused(self):
        for arguments, allowed in (
                (["simulate", "-o", "x.png"], ".exr"), (["simulate", "-o", "x"], ".exr"),
                (["simulate", "-o", "x.lobes"], ".exr"), (["rerun", "a.exr", "-o", "x.png"], ".exr"),
                (["homogenise", "-o", "x.exr"], ".toml"), (["measure", "-o", "x.json"], ".toml"),
                (["grid", "weave", "-o", "x.exr"], ".vdb"), (["furnace", "--html", "x.png"], ".html")):
            with self.subTest(" ".join(arguments)):
                answer = self.lamella(*arguments, status=2)
                self.assertIn(f'found "{arguments[-1]}"; allowed: a name that ends in {allowed}', answer.err)
                self.assertEqual(answer.err.count("\n"), 1)
        for arguments in (["compare", "-o", "x.png"], ["sweep", "--set", "layer.0.albedo=1", "-o", "x.exr"],
                          ["preview", "-o", "x.png"], ["reproduce", "vmf_figure_5", "-o", "x.html"],
                          ["simulate", "--json", "x.exr"], ["models", "--json", "x.png"]):
            with self.subTest(" ".join(arguments)):
                answer = self.lamella(*arguments, status=2)
                self.assertIn(f'found "{arguments[-1]}"; allowed: ', answer.err)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_with_their_own_ending_or_of_devices_are_taken(self):
        quick = ["--walks", "1000", "--wi", "60", "--quiet"]
        self.lamella("simulate", "sggx_slab", *quick, "-o", "x.EXR")
        self.lamella("simulate", "sggx_slab", *quick, "-o", "/dev/null")
        (self.folder / "run.png").mkdir()
        self.lamella("compare", "sggx_slab", *quick, "-o", "run.png")


class AColour(ProgramTest):
    def test_has_one_name_in_eval_and_invert(self):
        by_albedo = self.json_of("invert", "eon", "albedo=0.8,0.4,0.1", "roughness=1", "--quiet")
        self.assertEqual(by_albedo, self.json_of("invert", "eon", "color=0.8,0.4,0.1", "roughness=1", "--quiet"))
        # What eval calls the model's albedo is what was asked for.
        self.write("p.csv", "theta_i,phi_i,theta_o,phi_o\n0,0,0,0\n")
        albedo = ",".join(repr(a) for a in by_albedo["albedo"])
        rows = self.lamella("eval", "eon.albedo", f"albedo={albedo}", "roughness=1", "--pairs", "p.csv").out
        for value, asked in zip(rows.splitlines()[1].split(",")[4:], (0.8, 0.4, 0.1)):
            self.assertAlmostEqual(float(value), asked, places=7)
        # Errors name the key that was typed.
        for key in ("albedo", "color"):
            for what in ("eon", "sggx_slab"):
                for bad in ("2", "x", "", "0.1,0.2"):
                    self.assertIn(f'{what}: key "{key}"', self.lamella("invert", what, f"{key}={bad}", status=2).err)
        self.assertIn("second", self.lamella("invert", "eon", "albedo=0.2", "color=0.3", status=2).err)


class Tables(ProgramTest):
    def lines_of(self, *arguments):
        return self.lamella(*arguments).out.splitlines()

    def test_fit_a_screen(self):
        quick = ["--walks", "1000", "--wi", "60"]
        for arguments in (["models"], ["media"], ["stacks"],
                          ["samplers", "--samples", "100"], ["samplers", "--samples", "100", "--all"],
                          ["simulate", "spongecake_copper", *quick],
                          ["furnace", "spongecake_plant", *quick],
                          ["sweep", "sggx_slab", "--set", "layer.0.roughness=0.2,0.5", "--set",
                           "layer.0.albedo=0.5,1", *quick, "-o", "swept"]):
            with self.subTest(" ".join(arguments)):
                # Rows of tables; a headline is a sentence, which a terminal may break.
                for line in self.lines_of(*arguments):
                    if line.startswith(" "):
                        self.assertLessEqual(len(line), WIDTH, line)
        self.assertLess(len(self.lines_of("samplers", "--samples", "100")), 25)

    def test_of_comparisons_fit_a_screen(self):
        for arguments in (["compare", "sggx_slab", "--walks", "1000"],
                          ["compare", "lambert_sphere_halfspace", "--max-order", "20", "--walks", "1000"],
                          *([["compare", "sphere_bed_dense", "--walks", "1000", "--wi", "60"]] if WITH_EMBREE else [])):
            with self.subTest(" ".join(arguments)):
                for line in self.lines_of(*arguments, "--quiet", "-o", "out") + \
                        (self.folder / "out/summary.txt").read_text().splitlines()[1:]:
                    self.assertLessEqual(len(line), WIDTH, line)

    def test_of_plans_figures_and_grids_fit_a_screen(self):
        for stack in ("spongecake_plant", "vmf_sand", "woven_cloth", "sphere_bed_dense"):
            for line in self.lines_of("explain", stack):
                self.assertLessEqual(len(line), WIDTH, line)
        grids = [["grid", "weave", "voxels=16", "-o", "cloth.vdb"]] if os.environ["LAMELLA_OPENVDB"] == "ON" else []
        grains = [["reproduce", "lambert_sphere_dilute", "--walks", "2000", "-o", "dilute"],
                  ["reproduce", "micrograin_figure_5", "--walks", "2000", "-o", "normals"],
                  ["reproduce", "vmf_figure_6", "--walks", "2000", "-o", "six"]] if WITH_EMBREE else []
        for arguments in (["grid"], ["reproduce"], *grids, *grains):
            with self.subTest(" ".join(arguments)):
                for line in self.lines_of(*arguments):
                    self.assertLessEqual(len(line), WIDTH, line)

    def test_sweep_prints_its_result(self):
        arguments = ["sweep", "lambert_sphere_halfspace", "--set", "layer.0.albedo=0.5,0.9", "--walks", "1e4",
                     "--wi", "60", "--grid", "2x4", "--model", "lambert_sphere", "--model", "lambert", "-o", "out"]
        lines = self.lines_of(*arguments)
        at = next(k for k, line in enumerate(lines) if line.split() == ["layer.0.albedo", "lambert_sphere", "lambert"])
        report = json.loads((self.folder / "out/report.json").read_text())
        for k, albedo in enumerate(("0.5", "0.9")):
            words = lines[at + 1 + k].replace(" ?", "").replace(" %", "").split()
            self.assertEqual(words[0], albedo)
            for word, model in zip(words[1:], report["points"][k]["answer"]["models"]):
                worst = max(l["relative_rmse_without_noise"] for l in model["lobes"] if l["order"] == "all")
                self.assertEqual(word, f"{100 * worst:.3g}")

    def test_sweep_of_furnaces_prints_their_verdicts(self):
        lines = self.lines_of("sweep", "sggx_slab", "--of", "furnace", "--set", "layer.0.thickness=0.5,2",
                              "--wi", "60", "-o", "out")
        at = next(k for k, line in enumerate(lines) if line.split() == ["layer.0.thickness", "energy", "verdict"])
        for k, thickness in enumerate(("0.5", "2")):
            words = lines[at + 1 + k].split()
            self.assertEqual((words[0], words[2]), (thickness, "pass"))
            self.assertAlmostEqual(float(words[1]), 1, places=4)
