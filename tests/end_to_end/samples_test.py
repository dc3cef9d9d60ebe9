"""Walks one by one, and data sets of many stacks."""

import ast
import hashlib
import json
import struct
import zipfile

from lamella_program import ProgramTest, check_schema


class Npz:
    """A reader of NumPy's archives that needs no NumPy (NEP 1)."""

    TYPES = {"<f4": "f", "<f8": "d", "<u4": "I", "|i1": "b", "<u8": "Q", "|b1": "?"}

    def __init__(self, path):
        self.archive = zipfile.ZipFile(path)
        assert self.archive.testzip() is None, path

    def __getitem__(self, name):
        data = self.archive.read(name + ".npy")
        assert data[:8] == b"\x93NUMPY\x01\x00"
        length = struct.unpack("<H", data[8:10])[0]
        header = ast.literal_eval(data[10:10 + length].decode())
        kind, shape, body = header["descr"], header["shape"], data[10 + length:]
        if kind.startswith("<U"):
            return body.decode("utf-32-le")
        count = 1
        for n in shape:
            count *= n
        values = struct.unpack(f"<{count}{self.TYPES[kind]}", body)
        if shape == ():
            return values[0]
        return values if len(shape) == 1 else [values[k:k + shape[-1]]
                                               for k in range(0, count, shape[-1])]


class Samples(ProgramTest):
    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def test_have_the_energies_of_simulate(self):
        for stack in ("vmf_sand", "coated_lambert", "spongecake_plant"):
            with self.subTest(stack=stack):
                run = ["--wi", "60", "--wi", "20,40", "--walks", "5e3", "--seed", "4"]
                answer = self.json_of("samples", stack, *run, "-o", "walks.npz")
                truth = self.json_of("simulate", stack, *run, "--estimator", "analog", "--grid",
                                     "2x4", "--sampling", "random")
                file = Npz(self.folder / "walks.npz")
                self.assertEqual(file["walks"], 10000)
                self.assertEqual(file["direction_walks"], (5000, 5000))
                self.assertEqual(sum(file["direction_rows"]), len(file["side"]))
                first = 0
                for one, run_of_truth, rows in zip(answer["runs"], truth["runs"],
                                                   file["direction_rows"]):
                    side = file["side"][first:first + rows]
                    weight = file["weight"][first:first + rows]
                    first += rows
                    for c, total in enumerate(run_of_truth["reflected"]["total"]):
                        specular = run_of_truth["reflected"].get("specular", [0] * 3)[c]
                        found = sum(w[c] for w, s in zip(weight, side) if s == 1) / 5000
                        # Each weight is rounded to float.
                        self.assertAlmostEqual(found, total - specular, delta=1e-7)
                        self.assertAlmostEqual(one["reflected"][c], total - specular, delta=1e-7)

    def test_have_unit_vectors_orders_and_what_they_depend_on(self):
        self.lamella("samples", "sggx_slab", "--wi", "30,90", "--walks", "500", "-o", "walks.npz",
                     "--quiet")
        file = Npz(self.folder / "walks.npz")
        n = len(file["side"])
        self.assertEqual([len(file[name]) for name in ("w_i", "w_o", "weight", "order")], [n] * 4)
        for w in (*file["w_i"], *file["w_o"]):
            self.assertAlmostEqual(sum(x * x for x in w), 1, delta=2e-6)
        for w, side, order in zip(file["w_o"], file["side"], file["order"]):
            self.assertEqual(w[2] > 0, side > 0)
            self.assertEqual(abs(side) == 2, order == 0)
        self.assertAlmostEqual(file["w_i"][0][1], 0.5, delta=1e-6)
        self.assertEqual(len(file["directions"]), 1)
        about = json.loads(file["lamella"])
        self.assertEqual((about["seed"], about["walks"], about["w_i"]), (1, 500, "fixed"))
        self.assertIn("sggx", about["stack"])

    def test_are_the_same_for_any_threads_and_parts(self):
        arguments = ["samples", "vmf_sand", "--wi-distribution", "cosine", "--walks", "60000",
                     "--quiet"]
        names = []
        for threads in (1, 2, 7):
            self.lamella(*arguments, "--threads", str(threads), "-o", f"{threads}.npz")
            names.append(f"{threads}.npz")
        for k in (1, 2, 3):
            self.lamella(*arguments, "--shard", f"{k}/3", "-o", f"{k}.part")
        self.lamella("merge", "3.part", "1.part", "2.part", "-o", "merged.npz", "--quiet")
        for name in (*names, "merged.npz"):
            self.assertEqual(self.bytes_of(name), self.bytes_of("1.npz"), name)
        file = Npz(self.folder / "1.npz")
        self.assertEqual(len(file["directions"]), 0)
        mean = sum(w[2] for w in file["w_i"]) / len(file["w_i"])
        self.assertTrue(0.5 < mean < 0.8, mean)

    def test_that_are_interrupted_are_whole(self):
        answer, seconds = self.interrupted("samples", "lambert_sphere_halfspace", "--wi", "30",
                                           "--walks", "1e12", "-o", "walks.npz", "--json", "-",
                                           seconds=0.2)
        self.assertEqual(answer.status, 0, str(answer))
        self.assertLess(seconds, 20)
        parsed = answer.json()
        check_schema("samples", parsed)
        self.assertTrue(parsed["interrupted"])
        with zipfile.ZipFile(self.folder / "walks.npz") as archive:
            self.assertIsNone(archive.testzip())
        self.assertEqual([path.name for path in self.folder.iterdir()], ["walks.npz"])
        # They are the first ones of any run.
        self.lamella("samples", "lambert_sphere_halfspace", "--wi", "30", "--walks", "200", "-o",
                     "few.npz", "--quiet")
        few = Npz(self.folder / "few.npz")["order"]
        with zipfile.ZipFile(self.folder / "walks.npz") as archive:
            with archive.open("order.npy") as member:
                member.read(128)
                self.assertEqual(struct.unpack(f"<{len(few)}I", member.read(4 * len(few))), few)

    def test_say_what_is_wrong_in_a_line(self):
        for words, text in (
                (["--wi", "30", "--wi-distribution", "uniform", "-o", "x.npz"], "--wi beside it"),
                (["--wi", "30"], "FILE.npz"),
                (["--lobes", "-o", "x.npz"], "--per-bsdf"),
                (["--design", "latin:4", "-o", "x.npz"], "--per-bsdf"),
                (["--per-bsdf", "--design", "latin:4", "-o", "x"], "--set"),
                (["--per-bsdf", "-o", "x.npz"], "a folder"),
                (["--per-bsdf", "--design", "sobol:4", "-o", "x"], "latin:N"),
                (["--per-bsdf", "--design", "latin:4", "--set", "layer.0.albedo=0:2", "-o", "x"],
                 "albedo"),
                (["--per-bsdf", "--lobes", "--wi-distribution", "cosine", "--set",
                  "layer.0.albedo=0,1", "-o", "x"], "--wi-distribution")):
            answer = self.lamella("samples", "sggx_slab", *words, status=2)
            self.assertEqual(answer.err.count("\n"), 1, str(answer))
            self.assertIn(text, answer.err)


class DataSets(ProgramTest):
    DESIGN = ["samples", "sggx_slab", "--per-bsdf", "--design", "latin:5", "--set",
              "layer.0.roughness=0.1:1", "--set", "layer.0.thickness=0.1:10:log", "--set",
              "layer.0.albedo=0.5,0.9", "--walks", "300"]

    def files_of(self, name):
        return {path.name: path.read_bytes() for path in (self.folder / name).iterdir()
                if path.suffix == ".npz"}

    def test_have_a_file_per_stack_and_an_index(self):
        index = self.json_of(*self.DESIGN, "--wi", "40", "-o", "set")
        self.assertEqual((index["stacks"], index["done"]), (5, 5))
        on_disk = json.loads((self.folder / "set" / "index.json").read_text())
        self.assertEqual(on_disk, index)
        for key, ranges in (("layer.0.roughness", [0.1 + 0.18 * k for k in range(6)]),):
            values = sorted(entry["parameters"][key] for entry in index["entries"])
            for k, value in enumerate(values):
                self.assertTrue(ranges[k] <= value <= ranges[k + 1] + 1e-6, values)
        depths = sorted(entry["parameters"]["layer.0.thickness"] for entry in index["entries"])
        for k, value in enumerate(depths):
            self.assertTrue(0.1 * 100 ** (k / 5) * 0.9999 <= value <= 0.1 * 100 ** ((k + 1) / 5) *
                            1.0001, depths)
        for entry in index["entries"]:
            data = (self.folder / "set" / entry["file"]).read_bytes()
            self.assertEqual(hashlib.sha256(data).hexdigest(), entry["sha256"])
            # A stack by itself gives the same walks.
            self.write("one.toml", entry["stack"])
            self.lamella("samples", "one.toml", "--wi", "40", "--walks", "300", "--seed",
                         str(entry["seed"]), "-o", "one.npz", "--quiet")
            one, of_set = Npz(self.folder / "one.npz"), Npz(self.folder / "set" / entry["file"])
            for name in ("w_o", "weight", "order", "side"):
                self.assertEqual(one[name], of_set[name])

    def test_go_on_and_are_divided(self):
        arguments = [*self.DESIGN, "--wi-distribution", "uniform", "--quiet"]
        self.lamella(*arguments, "-o", "whole")
        self.lamella(*arguments, "-o", "again", "--shard", "2/2")
        index = json.loads((self.folder / "again" / "index.json").read_text())
        self.assertEqual([entry["number"] for entry in index["entries"]], [1, 3])
        # As if a process had been killed within a line, and a file were damaged.
        lines = self.folder / "again" / "done-2-of-2.jsonl"
        lines.write_text(lines.read_text() + '{"number": 4, "na')
        (self.folder / "again" / "0003.npz").write_bytes(b"PK")
        self.lamella(*arguments, "-o", "again")
        self.assertEqual(self.files_of("again"), self.files_of("whole"))
        index = json.loads((self.folder / "again" / "index.json").read_text())
        self.assertEqual([entry["number"] for entry in index["entries"]], [0, 1, 2, 3, 4])
        answer = self.lamella(*arguments, "--seed", "3", "-o", "again", status=2)
        self.assertIn("its seed is 1 instead of 3", answer.err)

    def test_hold_lobes_and_take_lists(self):
        index = self.json_of("samples", "sggx_slab", "hg_slab", "--per-bsdf", "--lobes", "--wi",
                             "20", "--wi", "50", "--walks", "2000", "--grid", "2x4", "-o", "lobes")
        self.assertEqual([entry["name"] for entry in index["entries"]], ["sggx_slab", "hg_slab"])
        lobes = Npz(self.folder / "lobes" / "hg_slab.npz")["reflect.all"]
        self.lamella("simulate", "hg_slab", "--wi", "20", "--wi", "50", "--walks", "2000", "--grid",
                     "2x4", "--seed", "2", "-o", "lobes.exr", "--quiet")
        self.lamella("export", "lobes.exr", "--to", "npz", "-o", "lobes.npz", "--quiet")
        expected = Npz(self.folder / "lobes.npz")["reflect.all"]
        self.assertEqual([v for row in lobes for v in row], [v for row in expected for v in row])
        grid = self.json_of("samples", "sggx_slab", "--per-bsdf", "--set",
                            "layer.0.roughness=0.2:1:3", "--set", "layer.0.albedo=0.5,1", "--wi",
                            "20", "--walks", "200", "-o", "grid")
        self.assertEqual(grid["done"], 6)
