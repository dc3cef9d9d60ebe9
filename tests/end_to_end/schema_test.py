import json

import jsonschema

from lamella_program import SCHEMAS, ProgramTest, check_schema

SLAB = """
[[layer]]
medium = "vmf_flake"
alpha = inf
albedo = [0.9, 0.5, 0.2]
thickness = 1
[[layer]]
medium = "sggx"
matrix = [1, 0.5, 0.25, 0.1, 0, 0]
flake = "lambert"
thickness = 0.5
density = 2
[[layer]]
medium = "henyey_greenstein"
g = -0.3
thickness = 0
"""
QUICK = ["--walks", "2000", "--quiet"]


class EveryAnswerMatchesItsSchema(ProgramTest):
    def test_every_schema_is_valid_and_strict(self):
        for path in sorted(SCHEMAS.glob("*.json")):
            with self.subTest(path.name):
                schema = json.loads(path.read_text())
                jsonschema.Draft202012Validator.check_schema(schema)
                for part in objects_in(schema):
                    if "oneOf" in part:
                        continue  # each of its forms is strict
                    self.assertIn("additionalProperties", part)
                    if part["additionalProperties"] is False:
                        self.assertLessEqual(set(part["required"]), set(part["properties"]))

    def test_a_schema_refuses_an_answer_with_a_key_too_many_or_too_few(self):
        answer = self.json_of("stacks")
        for change in ({"format": 2}, {"more": 1}, {"stacks": [{"name": "x"}]}):
            with self.assertRaises(jsonschema.ValidationError):
                check_schema("stacks", {**answer, **change})

    def test_simulate_of_grey_coloured_open_and_closed_stacks(self):
        self.write("slab.toml", SLAB)
        for stack in ("lambert_sphere_halfspace", "spongecake_window_shade", "spongecake_sheen",
                      "./slab.toml"):
            with self.subTest(stack):
                self.json_of("simulate", stack, *QUICK)

    def test_export_and_import(self):
        answer = self.json_of("export", "lambert,albedo=0.5", "--to", "mitsuba", "--size", "small", "-o", "a.bsdf")
        self.assertEqual([s["size"] for s in answer["sizes"]], ["small", "medium", "large"])
        self.assertEqual(answer["bytes"], (self.folder / "a.bsdf").stat().st_size)
        self.json_of("export", "sggx_slab", "--to", "csv", "--grid", "2x4", "-o", "a.csv", "--walks", "2000")
        for energy in self.json_of("import", "a.bsdf", "--wi", "30", "--grid", "4x8")["runs"][0]["reflected"]:
            self.assertAlmostEqual(energy, 0.5, delta=0.005)
        self.json_of("compare", "a.bsdf", "--model", "lambert", "--grid", "4x8", "--wi", "30", "--quiet")

    def test_samples_and_sets_of_them(self):
        walks = self.json_of("samples", "vmf_sand", "--wi", "30", "--walks", "200", "-o", "walks.npz")
        self.assertEqual(walks["walks"], 200)
        index = self.json_of("samples", "vmf_sand", "--per-bsdf", "--set", "layer.0.roughness=0.2,0.4", "--wi", "30",
                             "--walks", "200", "-o", "set")
        self.assertEqual(index["done"], 2)

    def test_a_half_space_is_written_as_the_string_inf(self):
        stack = self.json_of("simulate", "lambert_sphere_halfspace", *QUICK)["stack"]
        self.assertEqual(stack["layer"][0]["thickness"], "inf")

    def test_compare_and_the_report_in_its_folder(self):
        answer = self.json_of("compare", "sggx_slab", "--grid", "4x8", "--wi", "30", *QUICK)
        report = json.loads((self.folder / "sggx_slab-compare/report.json").read_text())
        check_schema("compare", report)
        self.assertEqual(answer, report)

    def test_compare_where_nothing_arrives(self):
        self.write("black.toml", '[[layer]]\nmedium = "lambert_sphere"\nalbedo = 0\n'
                                 'thickness = inf\n')
        answer = self.json_of("compare", "black.toml", "--model", "lambert,albedo=0.9,0.5,0.2",
                              "--wi", "30", *QUICK)
        lobe = answer["models"][0]["lobes"][0]
        self.assertEqual((lobe["relative_rmse"], lobe["verdict"]), ("inf", "differs"))

    def test_furnaces_of_stacks_and_of_models(self):
        self.write("vmf.toml", '[[layer]]\nmedium = "vmf_flake"\nroughness = 0.5\nthickness = 1\n')
        self.assertIn("radiance", self.json_of("furnace", "vmf.toml", *QUICK)["runs"][0])
        self.json_of("furnace", "spongecake_window_shade", "--as-is", *QUICK)
        self.json_of("furnace", "--model", "lambert", "--quiet")

    def test_check(self):
        answer = self.json_of("check", "eon", "roughness=0.5", "--quick", "--quiet")
        self.assertEqual({line["verdict"] for line in answer["checks"]}, {"pass"})

    def test_explain_models_media_and_stacks(self):
        for command in ("explain", "models", "media", "stacks"):
            with self.subTest(command):
                self.json_of(command)

    def test_accuracy_of_the_layerings_of_a_coat(self):
        answer = self.json_of("accuracy", "--coats", "--quick", "--tolerance", "1e-3", "--quiet")
        rows = {(row["layering"], row["roughness"]): row for row in answer["coats"]}
        self.assertEqual(len(rows), 10)
        # A smooth coat over Lambert's law is saunderson's by derivation; a diffuse base that does
        # not reflect the light that comes back from the coat lacks tens of per cent at albedo 0.8.
        for share in rows["saunderson", 0]["relative_rmse"]:
            self.assertLess(share, 1e-6)
        for roughness in (0, 0.3):
            for share in rows["albedo_scaling", roughness]["relative_rmse"]:
                self.assertGreater(share, 0.1)

    def test_accuracy_of_every_form_that_claims_a_medium(self):
        answer = self.json_of("accuracy", "--quick", "--tolerance", "1e-3", "--quiet")
        rows = {(row["family"], row["model"]): row for row in answer["rows"]}
        names = {model for _, model in rows}
        self.assertLessEqual({"chandrasekhar", "lambert_sphere", "lambert_sphere_three_term",
                              "vmf_diffuse", "single_scattering", "spongecake"}, names)
        # Exact forms: what is left is the truth's tolerance and the projection's 1e-4.
        exact = rows["isotropic half space", "chandrasekhar"]
        self.assertLess(max(exact["relative_rmse"]), 1e-3)
        self.assertGreater(rows["isotropic half space", "single_scattering"]["energy_off"], 0.1)

    def test_bench_rows_as_the_contract_has_them(self):
        answer = self.json_of("bench", "--quick", "--only", "walks", "--only", "models", "--only", "solver",
                              "--quiet")
        whats = [row["what"] for row in answer["rows"]]
        for stack in ("lambert_sphere_halfspace", "sggx_slab", "vmf_halfspace", "hg_slab"):
            for task in ("walk", "walk+cells", "nee1", "nee16", "nee64"):
                self.assertIn(f"{stack}/{task}", whats)
        for model in self.json_of("models")["models"]:
            self.assertIn("eval/" + model["name"], whats)
            self.assertIn("eval_batch/" + model["name"], whats)
        rows = {row["what"]: row for row in answer["rows"]}
        for model in ("eon", "eon_approx", "lambert_sphere", "vmf_diffuse"):
            row = rows["eval_batch/" + model]
            self.assertEqual(row["baseline"], "textbook scalar code")
            self.assertEqual(row["isa"], answer["isa"])
        for model in ("lambert_sphere", "vmf_diffuse"):
            self.assertGreater(rows["eval/" + model]["error"], 0)
        self.assertIsNone(rows["eval/eon"]["error"])
        solved = [row for row in answer["rows"] if row["kind"] == "deterministic"]
        self.assertIn("hg_slab/solve/1e-04", [row["what"] for row in solved])
        self.assertTrue(all(row["seconds"] > 0 and row["nodes"] > 0 for row in solved))
        for key in ("what", "kind", "seconds", "collisions_per_second_per_core", "ns_per_eval",
                    "error", "baseline", "ratio_to_baseline"):
            less = {k: v for k, v in answer["rows"][0].items() if k != key}
            with self.assertRaises(jsonschema.ValidationError):
                check_schema("bench", {**answer, "rows": [less]})

    def test_the_releases_measurements_are_results_of_bench(self):
        for isa in ("scalar", "avx2", "avx512"):
            with self.subTest(isa):
                answer = json.loads((SCHEMAS.parent / f"bench/release/{isa}.json").read_text())
                check_schema("bench", answer)
                self.assertEqual((answer["isa"], answer["quick"], answer["interrupted"]), (isa, False, False))

    def test_bench_gives_the_solver_the_seconds_that_are_asked_for(self):
        def nodes(*arguments):
            answer = self.json_of("bench", "--quick", "--quiet", "--only", "solver", *arguments)
            rows = {row["what"]: row["nodes"] for row in answer["rows"]}
            return answer["solver_seconds"], rows["sggx_mirror_0.05_slab/solve/1e-04"]

        default, few = nodes()
        self.assertEqual(default, 0.2)
        self.assertEqual(nodes("--solver-seconds", "1e-9"), (1e-9, 8))
        self.assertGreaterEqual(few, 8)
        for bad in ("0", "-1", "inf", "long"):
            answer = self.lamella("bench", "--solver-seconds", bad, status=2)
            self.assertIn("--solver-seconds", answer.err)
            self.assertIn("allowed: a number in (0, inf)", answer.err)

    def test_bench_measures_the_parts_that_are_asked_for(self):
        answer = self.json_of("bench", "--quick", "--quiet", "--only", "models", "--only", "plan")
        self.assertEqual(answer["parts"], ["plan", "models"])
        self.assertEqual({row["what"].split("/")[0] for row in answer["rows"]},
                         {"lambert_sphere_halfspace", "eval", "eval_batch"})


def objects_in(schema):
    """Every part of a schema that describes an object."""
    if isinstance(schema, dict):
        if schema.get("type") == "object":
            yield schema
        for value in schema.values():
            yield from objects_in(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from objects_in(value)
