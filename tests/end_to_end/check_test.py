"""lamella check: right models pass, wrong ones fail with the worst case, all end in finite time."""

import os
import time

from lamella_program import ProgramTest, check_schema

PLUGINS = os.environ["LAMELLA_PLUGINS"]
ALL = {"values", "reciprocity", "batches", "energy", "albedo", "density", "samples", "weights"}

# What built-in models are known to fail with --quick, see analytic/README.md: the largest energies
# that the battery meets, and the largest negative value.
KNOWN = {
    "lambert_sphere_fast": {"energy": 1.29705},
    "lambert_sphere_three_term_pure": {"values": 0.206401},
    "hapke_lambert_sphere": {"energy": 1.17725},
    "vmf_diffuse": {"energy": 1.13488},
    "vmf_diffuse_printed": {"energy": 1.13397},
    "oren_nayar_full": {"energy": 1.02662},
    "oren_nayar_footnote": {"energy": 1.01300},
    "openpbr_diffuse": {"energy": 1.35008},
    "coated": {"energy": 1.90822},
}


def plugin(name):
    return os.path.join(PLUGINS, name + ".so")


def failures(answer):
    """Check -> what was found in its worst case."""
    return {line["name"]: line["worst"]["found"] for line in answer["checks"] if line["verdict"] == "fail"}


def line_of(answer, name):
    return next(line for line in answer["checks"] if line["name"] == name)


class CheckTest(ProgramTest):
    def check(self, *words):
        """The answer with --quick, whatever its verdict."""
        answer = self.run_program("check", *words, "--quick", "--quiet", "--json", "-")
        self.assertIn(answer.status, (0, 1), str(answer))
        parsed = answer.json()
        check_schema("check", parsed)
        self.assertEqual(parsed["verdict"], "fail" if answer.status else "pass")
        return parsed


class BuiltInModels(CheckTest):
    def test_pass_or_fail_as_is_known(self):
        for model in self.json_of("models", "--quiet")["models"]:
            name = model["name"]
            words = [name]
            if name in ("single_scattering", "spongecake"):
                words.append("stack=sggx_slab")
            # Its values are means over walks, from 64 on.
            if name == "beckmann_diffuse":
                words += ["walks=64", "--configurations", "1", "--samples", "1000"]
            with self.subTest(name):
                parsed = self.check(*words)
                found, known = failures(parsed), KNOWN.get(name, {})
                self.assertEqual(set(found), set(known), parsed)
                for check, value in known.items():
                    self.assertAlmostEqual(found[check], value, delta=1e-4 * value)
                self.assertFalse(parsed["ended_by_time"])
                self.assertEqual(parsed["configurations"] + parsed["refused"], parsed["configurations_planned"])
                for line in parsed["checks"]:
                    self.assertTrue(line["cases"] > 0 or line["reason"], line)
        self.assertLessEqual(set(KNOWN), {m["name"] for m in self.json_of("models", "--quiet")["models"]})


class SharedObjects(CheckTest):
    def test_right_ones_pass_in_either_precision(self):
        for alpha in ("0.01", "0.3"):
            energies = []
            for precision in ("single_precision", "double_precision"):
                words = [plugin(precision), "reflectance=0.04", "roughness=0.5", "alpha=" + alpha]
                answer = self.check(*words, "albedo=0")
                self.assertEqual(failures(answer), {}, precision + alpha)
                self.assertEqual(answer["single_precision"], precision == "single_precision")
                # Narrow facets above a diffuse part that they do not darken make light at grazing
                # angles, and nothing else is wrong.
                answer = self.check(*words, "albedo=0.5")
                self.assertEqual(set(failures(answer)), {"energy"} if alpha == "0.01" else set())
                energies.append(line_of(answer, "energy")["worst"]["found"])
            # The bound of model_plugin_test.cpp.
            self.assertAlmostEqual(*energies, delta=1e-6 + 2e-6 / float(alpha)**2)
        self.assertEqual(failures(self.check(plugin("faulty"), "kind=0")), {})
        self.assertEqual(failures(self.check(plugin("minnaert"), "k=1")), {})

    def test_each_fault_is_found_by_its_check(self):
        for kind, names in ((1, {"reciprocity", "albedo"}), (2, {"energy"}),
                            (3, {"density", "samples", "weights"}), (4, {"samples", "weights"}),
                            (5, {"weights"}), (6, {"batches"}), (7, {"values", "albedo"})):
            with self.subTest(kind):
                answer = self.check(plugin("faulty"), f"kind={kind}")
                self.assertEqual(set(failures(answer)), names)
                self.assertEqual(answer["verdict"], "fail")
                for name in names:
                    worst = line_of(answer, name)["worst"]
                    self.assertIn(f"kind={kind}", worst["request"])
                    self.assertTrue("wi" in worst or "wo" in worst)

    def test_broken_ones_fail_with_the_value_found(self):
        for name, text in (("not_a_number", "found nan"), ("negative", "found -0.25"), ("silent", "found nan")):
            answer = self.check(plugin(name))
            self.assertIn("values", failures(answer))
            self.assertIn(text, line_of(answer, "values")["worst"]["text"])
        for name in ("no_symbol", "wrong_version", "no_eval"):
            answer = self.lamella("check", plugin(name), status=2)
            self.assertEqual((answer.out, answer.err.count("\n")), ("", 1))

    def test_hostile_ones_end(self):
        undecided = {}
        for kind, names in ((0, set()), (1, set()), (2, set()), (3, set()), (4, {"values"}), (5, {"values"}),
                            (6, {"energy", "weights"}), (7, set()), (9, set())):
            with self.subTest(kind):
                answer = self.check(plugin("hostile"), f"kind={kind}", "--time", "10")
                self.assertLessEqual(names, set(failures(answer)))
                if not names:
                    self.assertEqual(failures(answer), {})
                undecided[kind] = line_of(answer, "energy")["verdict"]
        # Noise of 10 %, no integral, a checkerboard, a spike: no energy is known within 1e-3.
        self.assertEqual({kind for kind, verdict in undecided.items() if verdict == "undecided"}, {0, 2, 7, 9})

    def test_a_slow_one_ends_by_time_and_says_so(self):
        start = time.monotonic()
        answer = self.check(plugin("hostile"), "kind=8", "--time", "0.5")
        # Some 3000 values of a millisecond, on a machine that does other work, too.
        self.assertLess(time.monotonic() - start, 60)
        self.assertTrue(answer["ended_by_time"])
        self.assertEqual(line_of(answer, "energy")["verdict"], "skipped")
        self.assertEqual(line_of(answer, "energy")["reason"], "no time was left")


class TheAnswer(CheckTest):
    def test_has_a_line_per_check_within_the_terminal(self):
        answer = self.lamella("check", "vmf_diffuse", "--quick", status=1)
        for name in ALL:
            self.assertIn(f" {name} ", answer.out)
        self.assertIn("found: energy 1.13", answer.out)
        for line in answer.out.splitlines():
            self.assertLessEqual(len(line), 100, line)

    def test_is_the_same_again_and_differs_with_the_seed(self):
        first = self.check("eon", "roughness=0.5")
        self.assertEqual(first, self.check("eon,roughness=0.5"))
        self.assertEqual(first["verdict"], "pass")
        self.assertNotEqual(first["checks"], self.check("eon,roughness=0.5", "--seed", "7")["checks"])

    def test_keys_that_are_given_stay(self):
        answer = self.check("vmf_diffuse", "roughness=0.25")
        for line in answer["checks"]:
            self.assertIn("roughness=0.25", line["worst"]["request"])

    def test_what_is_refused(self):
        for words, parts in ((["eonn"], ['"eon"']), (["eon", "roughness=2"], ['key "roughness"']),
                             (["single_scattering"], ['key "stack"']), (["lambert", "x"], ['"x"']),
                             (["lambert", "--samples", "10"], ["--samples"])):
            answer = self.lamella("check", *words, status=2)
            self.assertEqual((answer.out, answer.err.count("\n")), ("", 1))
            for part in parts:
                self.assertIn(part, answer.err)
