"""Runs in parts, and parts put together: the same bytes as the run in one."""

import hashlib
import json
import os
import random
import struct
import unittest

from lamella_program import TIMINGS, ProgramTest, without

QUICK = ["--walks", "600", "--grid", "2x4"]
SHORT = ["--quiet", *QUICK, "--wi", "60", "--wi", "10,30"]


class Parts(ProgramTest):
    def parts_of(self, count, *arguments, name="p", stdin=""):
        names = []
        for k in range(1, count + 1):
            part = f"{name}{k}.part"
            self.lamella(*arguments, "--threads", str((1, 2, 7)[k % 3]), "--shard", f"{k}/{count}",
                         "-o", part, stdin=stdin)
            names.append(part)
        return names

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()


class PartsAreTheWholeRun(Parts):
    def test_of_simulate_for_any_number_in_any_order(self):
        draw = random.Random(1)
        stacks = ["sggx_slab", "vmf_sand", "coated_lambert", "spongecake_plant", "woven_cloth"]
        counts = range(1, 18) if "LAMELLA_SOAK" in os.environ else (1, 2, 5, 17)
        for count in counts:
            stack = stacks[count % len(stacks)]
            with self.subTest(stack=stack, count=count):
                arguments = ["simulate", stack, *SHORT, "--estimator",
                             ("analog", "next-event")[count % 2], "--seed", str(count)]
                self.lamella(*arguments, "-o", "whole.exr")
                parts = self.parts_of(count, *arguments)
                draw.shuffle(parts)
                self.lamella("merge", *parts, "-o", "merged.exr", "--quiet")
                self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("merged.exr"))

    def test_of_simulate_with_order_1_exact(self):
        arguments = ["simulate", "spongecake_fabric", "--quiet", "--walks", "20000", "--grid", "2x4", "--wi", "60",
                     "--estimator", "analog"]
        whole = self.json_of(*arguments, "-o", "whole.exr")
        self.assertEqual(whole["runs"][0]["order_1"], "exact")
        merged = self.lamella("merge", *self.parts_of(3, *arguments), "-o", "merged.exr", "--quiet", "--json", "-").json()
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("merged.exr"))
        self.assertEqual(without(whole, TIMINGS | {"threads"}), without(merged, TIMINGS | {"threads"}))

    def test_of_simulate_tables_and_json(self):
        arguments = ["simulate", "sggx_slab", *QUICK, "--wi", "30"]
        whole = self.json_of(*arguments)
        parts = self.parts_of(3, *arguments)
        merged = self.lamella("merge", *parts, "--json", "-").json()
        self.assertEqual(without(whole, TIMINGS | {"threads"}), without(merged, TIMINGS | {"threads"}))

    def test_of_compare(self):
        arguments = ["compare", "lambert_sphere_halfspace", *SHORT, "--model", "hapke_lambert_sphere",
                     "--model", "lambert,albedo=0.3"]
        self.lamella(*arguments, "-o", "whole")
        self.lamella("merge", *self.parts_of(3, *arguments), "-o", "merged", "--quiet")
        names = sorted(path.name for path in (self.folder / "whole").iterdir())
        self.assertEqual(names, sorted(path.name for path in (self.folder / "merged").iterdir()))
        for name in names:
            if name.endswith((".exr", ".png")):
                self.assertEqual(self.bytes_of(f"whole/{name}"), self.bytes_of(f"merged/{name}"), name)
        whole, merged = (json.loads(self.bytes_of(f"{name}/report.json")) for name in ("whole", "merged"))
        self.assertEqual(without(whole, TIMINGS | {"threads"}), without(merged, TIMINGS | {"threads"}))

    def furnace_of(self, stack):
        arguments = ["furnace", stack, "--walks", "2000", "--wi", "45"]
        whole = self.lamella(*arguments, "--json", "-").json()
        merged = self.lamella("merge", *self.parts_of(2, *arguments), "--json", "-").json()
        self.assertEqual(without(whole, TIMINGS | {"threads"}), without(merged, TIMINGS | {"threads"}))
        return whole

    def test_of_furnace(self):
        self.assertEqual(self.furnace_of("sggx_slab")["verdict"], "inconclusive")

    @unittest.skipUnless("LAMELLA_SOAK" in os.environ, "radiance takes 132 runs of seconds: in the soak")
    def test_of_furnace_with_its_radiance(self):
        self.write("vmf.toml", '[[layer]]\nmedium = "vmf_flake"\nroughness = 0.5\nthickness = 1\n')
        self.assertIn("radiance", self.furnace_of("vmf.toml")["runs"][0])

    def test_of_truth_at_pairs(self):
        rows = "".join(f"{0.1 + k / 10:g},0,{0.9 - k / 20:g},{20 * k}\n" for k in range(7))
        self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n" + rows)
        for stack, more in (("sggx_slab", ["walks=600"]), ("lambert_sphere_halfspace", ["walks=600"]),
                            ("lambert_sphere_halfspace", ["estimator=deterministic"])):
            arguments = ["eval", "truth", f"stack={stack}", *more, "--pairs", "pairs.csv"]
            whole = self.lamella(*arguments).out
            parts = self.parts_of(3, *arguments)
            self.assertEqual(self.lamella("merge", *parts).out, whole)
            self.lamella("merge", *parts[::-1], "-o", "merged.csv")
            self.assertEqual(self.bytes_of("merged.csv").decode(), whole)

    def test_of_a_sweep(self):
        arguments = ["sweep", "sggx_slab", "--set", "layer.0.roughness=0.2:0.8:5", *QUICK, "--wi", "60",
                     "--model", "lambert,albedo=0.3"]
        self.lamella(*arguments, "-o", "whole")
        self.lamella("merge", *self.parts_of(3, *arguments), "-o", "merged", "--quiet")
        whole, merged = self.folder / "whole", self.folder / "merged"
        for path in sorted(whole.rglob("*")):
            other = merged / path.relative_to(whole)
            if path.suffix == ".json":
                a, b = (json.loads(p.read_text()) for p in (path, other))
                self.assertEqual(without(a, TIMINGS | {"threads"}), without(b, TIMINGS | {"threads"}), path)
            elif path.suffix == ".toml":
                self.assertEqual(path.read_bytes(), other.read_bytes())

    def test_of_the_solver_whole_by_the_first(self):
        arguments = ["simulate", "sggx_slab", "--estimator", "deterministic", "--grid", "4x8", "--wi", "60"]
        self.lamella(*arguments, "-o", "whole.exr")
        parts = self.parts_of(3, *arguments)
        self.assertGreater((self.folder / parts[0]).stat().st_size,
                           2 * (self.folder / parts[1]).stat().st_size)
        self.lamella("merge", *parts, "-o", "merged.exr")
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("merged.exr"))


class PartsOfGrids(Parts):
    @unittest.skipUnless(os.environ["LAMELLA_OPENVDB"] == "ON", "built without OpenVDB")
    def test_find_their_grid_by_its_content(self):
        self.lamella("grid", "weave", "pitch=0.5", "voxels=16", "-o", "cloth.vdb", "--quiet")
        self.write("cloth.toml", '[[layer]]\nmedium = "lambert_sphere"\nalbedo = 0.5\nthickness = 1\n'
                                 'grid = "cloth.vdb"\nsize = [1, 1]\n')
        arguments = ["simulate", "cloth.toml", *SHORT]
        self.lamella(*arguments, "-o", "whole.exr")
        parts = self.parts_of(2, *arguments)
        self.lamella("merge", *parts, "-o", "merged.exr")
        self.assertEqual(self.bytes_of("whole.exr"), self.bytes_of("merged.exr"))
        (self.folder / "cloth.vdb").write_bytes(self.bytes_of("cloth.vdb") + b"x")
        answer = self.lamella("merge", *parts, "-o", "merged.exr", status=2)
        self.assertIn("cloth.vdb", answer.err)


class WhatDoesNotBelongTogetherIsRefused(Parts):
    def setUp(self):
        super().setUp()
        self.run_of = ["simulate", "sggx_slab", *SHORT]
        self.parts = self.parts_of(3, *self.run_of)

    def refused(self, *arguments, parts):
        answer = self.lamella(*arguments, status=2)
        self.assertEqual(answer.err.count("\n"), 1, str(answer))
        for part in parts:
            self.assertIn(part, answer.err)

    def test_parts_missing_twice_and_of_other_runs(self):
        a, b, c = self.parts
        self.refused("merge", a, c, parts=["found 2 of 3 parts: 2 is missing"])
        self.refused("merge", b, parts=["found 1 of 3 parts: 1 and 3 are missing"])
        self.refused("merge", a, b, c, a, parts=[a, "part 1/3", "every part once"])
        walks = [word.replace("600", "700") for word in self.run_of]
        for other_run, reason in (([*self.run_of, "--seed", "2"], "seed is 2 instead of 1"),
                                  (walks, "walks is 700 instead of 600"),
                                  ([*self.run_of, "--max-order", "9"], "max_order is 9 instead of null"),
                                  (["simulate", "vmf_sand", *SHORT], "its stack")):
            self.lamella(*other_run, "--shard", "3/3", "-o", "other.part")
            self.refused("merge", a, b, "other.part", parts=["other.part", "another run", reason])
        other = self.parts_of(2, *self.run_of, name="two")
        self.refused("merge", a, b, other[1], parts=["part 2/2"])
        other = self.parts_of(3, "furnace", "sggx_slab", "--walks", "600", "--wi", "60", name="furnace")
        self.refused("merge", a, b, other[2], parts=["a part of furnace"])

    def change_header(self, name, change):
        """The same part with another header, and the sum that belongs to it."""
        raw = self.bytes_of(name)[:-65]
        at = len(b"lamella part 1\n")
        size, count = struct.unpack_from("<QQ", raw, at)
        header = json.loads(raw[at + 16:at + 16 + size])
        change(header)
        text = json.dumps(header).encode()
        raw = raw[:at] + struct.pack("<QQ", len(text), count) + text + raw[at + 16 + size:]
        (self.folder / "changed.part").write_bytes(raw + hashlib.sha256(raw).hexdigest().encode() + b"\n")
        return "changed.part"

    def test_parts_of_another_version(self):
        part = self.change_header(self.parts[2], lambda h: h.update(version="0.1.0"))
        self.refused("merge", *self.parts[:2], part, parts=["lamella 0.1.0", "numbers may differ"])

    def test_damaged_and_cut_off(self):
        raw = self.bytes_of(self.parts[0])
        for k in range(0, len(raw), len(raw) // 7):
            self.write("cut.part", "")
            (self.folder / "cut.part").write_bytes(raw[:k])
            self.refused("merge", "cut.part", *self.parts[1:], parts=["cut.part"])
            (self.folder / "cut.part").write_bytes(raw[:k] + bytes([raw[k] ^ 4]) + raw[k + 1:])
            self.refused("merge", "cut.part", *self.parts[1:], parts=["cut.part"])

    def test_headers_that_somebody_made_up(self):
        def settings(**values):
            return lambda h: h["settings"].update(values)
        for change in (settings(walks=-1), settings(walks="x"), settings(grid="9999x9999"), settings(incident=[7]),
                       settings(incident=["x"]), settings(isa="auto"), settings(thin_from=3), settings(tolerance=0),
                       settings(sampling="sobol"), settings(walk_order_1="no"),
                       settings(stack="x"), settings(words=3), settings(input="x"), settings(more=1),
                       settings(estimator="x"), settings(walk_options=["--x"]), settings(seed=1.5),
                       lambda h: h["settings"].pop("seed"), lambda h: h.pop("settings"), lambda h: h.pop("stack"),
                       lambda h: h.update(settings=[]), lambda h: h.update(part=[0, 1]), lambda h: h.update(part=[1]),
                       lambda h: h.update(part="x"), lambda h: h.update(stack=3), lambda h: h.update(command="x"),
                       lambda h: h.update(command="sweep"), lambda h: h.update(command="eval"),
                       lambda h: h.update(command="compare"), lambda h: h.update(stack="[[layer]]"),
                       lambda h: h.update(checkpoint=True), settings(incident=["20"]), settings(walks=900),
                       settings(estimator="deterministic")):
            parts = [self.change_header(self.parts[0], lambda h: (h.update(part=[1, 1]), change(h)))]
            answer = self.run_program("merge", *parts)
            self.assertEqual(answer.status, 2, str(answer))
            self.assertEqual(answer.err.count("\n"), 1, str(answer))

    def test_runs_that_cannot_be_divided(self):
        shard = ["--shard", "1/2", "-o", "x.part"]
        for arguments, part in ((["simulate", "sggx_slab"], "--walks N"),
                                (["simulate", "sggx_slab", "--walks", "500", "--time", "1"], "--time"),
                                (["simulate", "sggx_slab", "--walks", "500", "--target-error", "0.1"], "--target-error"),
                                (["furnace", "--model", "lambert", "--walks", "500"], "--model"),
                                (["furnace", "sggx_slab", "--estimator", "deterministic"], "deterministic"),
                                (["eval", "lambert", "--pairs", "pairs.csv"], "truth"),
                                (["compare", "sggx_slab", "--walks", "500", "--model", "x"], "x"),
                                (["simulate", "sggx_slab", "--walks", "500", "--json", "a.json"], "merge")):
            self.write("pairs.csv", "mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,0\n")
            self.refused(*arguments, *shard, parts=[part, "allowed: "])
        self.refused("simulate", "sggx_slab", "--walks", "500", "--shard", "1/2", parts=[".part"])
        self.refused("simulate", "sggx_slab", "--walks", "500", "--shard", "1/2", "-o", "x.exr", parts=[".part"])
        self.refused("simulate", "sggx_slab", "--walks", "500", "-o", "x.part", parts=["without --shard"])
        self.assertFalse((self.folder / "x.part").exists())

    def test_results_of_the_wrong_kind(self):
        self.refused("merge", *self.parts, "-o", "x.png", parts=[".exr"])
        self.refused("merge", *self.parts, "--html", "x.html", parts=["--html"])
        self.refused("merge", "none.part", parts=["none.part"])
        self.write("text.part", "text")
        self.refused("merge", "text.part", parts=["text.part", "something else"])
