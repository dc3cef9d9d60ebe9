import os
import unittest

from lamella_program import ProgramTest

QUICK = ["--walks", "2000", "--quiet"]
WITH_OPENVDB = os.environ["LAMELLA_OPENVDB"] == "ON"


def layer(grid='"cloth.vdb"', size="[1, 1]", more="", thickness="0.4"):
    return (f'[[layer]]\nmedium = "sggx"\nroughness = 0.3\nthickness = {thickness}\n'
            f"grid = {grid}\nsize = {size}\n{more}")


# Name, text, line, and what the message has beside file and line.
BROKEN = [
    ("missing file", layer(), 5,
     ['"grid"', "cloth.vdb", "No such file", "allowed: a .vdb file"] if WITH_OPENVDB else
     ['"grid"', "cloth.vdb", "built without OpenVDB", "LAMELLA_OPENVDB=OFF"]),
    ("no name", layer(grid='""'), 5, ['"grid"', "the name of a .vdb file"]),
    ("a number", layer(grid="3"), 5, ['"grid"', "found 3"]),
    ("no size", layer().replace("size = [1, 1]\n", ""), 5, ['"size"', "found nothing", "[x, y]"]),
    ("size of one", layer(size="[1]"), 6, ['"size"', "[1]", "two numbers"]),
    ("size 0", layer(size="[1, 0]"), 6, ['"size"', "[1, 0]", "1e-06"]),
    ("size without a grid", layer().replace('grid = "cloth.vdb"\n', ""), 5,
     ['"size"', "without a grid"]),
    ("half space", layer(thickness="inf"), 4, ['"thickness"', "found inf", "grid"]),
    ("albedo of a third kind", layer(more='grid_albedo = "black"\n'), 7,
     ['"grid_albedo"', '"black"', "file, white"]),
    ("unknown built-in", layer(grid='"builtin:weav"'), 5,
     ['"builtin:weav"', 'did you mean "builtin:weave"?', "builtin:dust"]),
    ("no common period", layer(grid='"builtin:dust"') +
     layer(grid='"builtin:dust"', size="[1.41421356, 1]"), 11, ['"size"', "1.41421356"]),
]


class Grids(ProgramTest):
    def test_broken_ones_are_refused_with_file_line_key_and_what_is_allowed(self):
        for name, text, line, parts in BROKEN:
            with self.subTest(name):
                self.write("stack.toml", text)
                answer = self.lamella("simulate", "stack.toml", *QUICK, status=2)
                self.assertEqual(answer.out, "")
                self.assertTrue(answer.err.startswith(f"lamella: stack.toml:{line}: "), str(answer))
                self.assertEqual(answer.err.count("\n"), 1, str(answer))
                for part in parts:
                    self.assertIn(part, answer.err)

    def test_built_in_ones_run_everywhere(self):
        answer = self.json_of("simulate", "woven_cloth", *QUICK, "--wi", "30")
        self.assertEqual(answer["stack"]["layer"][0]["grid"], "builtin:weave")
        self.json_of("furnace", "blotchy_layer", "--walks", "2000", "--quiet", "--wi", "30")
        plan = self.lamella("explain", "woven_cloth").out
        for words in ("density, orientation from builtin:weave", "delta tracking", "majorant"):
            self.assertIn(words, plan)

    def test_closed_forms_refuse_them(self):
        answer = self.lamella("compare", "woven_cloth", "--model", "single_scattering", *QUICK,
                              status=2)
        self.assertIn("homogeneous layers only", answer.err)
        self.assertRegex(self.lamella("explain", "woven_cloth").out, r"models +none")

    def test_light_along_the_horizon_is_refused(self):
        answer = self.lamella("simulate", "woven_cloth", "--wi", "90", *QUICK, status=2)
        self.assertIn("mu = 0", answer.err)

    def test_homogenise_writes_a_stack_and_tells_the_error(self):
        answer = self.json_of("homogenise", "blotchy_layer", "--wi", "30", "--walks", "400000",
                              "--contrast", "0", "--contrast", "1", "-o", "layers.toml",
                              "--quiet")
        flat, full = answer["comparisons"]
        # Of uniform slices nothing is lost; of blotches the light that passes between them is.
        self.assertEqual(flat["contrast"][0]["voxel"] < 1e-6, True)
        self.assertNotIn("differs", [lobe["verdict"] for lobe in flat["lobes"]])
        self.assertIn("differs", [lobe["verdict"] for lobe in full["lobes"]])
        self.assertGreater(full["contrast"][0]["voxel"], 0.2)
        again = self.json_of("simulate", "layers.toml", *QUICK, "--wi", "30")
        self.assertNotIn("grid", again["stack"]["layer"][0])
        self.lamella("compare", "layers.toml", "--model", "single_scattering", *QUICK)

    def test_homogenise_refuses_stacks_without_a_grid_and_shares_beyond_1(self):
        self.assertIn("no layer with a grid",
                      self.lamella("homogenise", "sggx_slab", *QUICK, status=2).err)
        self.assertIn("[0, 1]",
                      self.lamella("homogenise", "--contrast", "2", *QUICK, status=2).err)

    def test_kinds_are_listed_and_wrong_ones_refused(self):
        kinds = self.json_of("grid")["kinds"]
        self.assertEqual([k["name"] for k in kinds], ["weave", "dust", "blotches", "spheres"])
        for words, part in ((["weav"], 'did you mean "weave"?'), (["weave", "pich=1"], '"pitch"'),
                            (["weave", "pitch=-1"], "found -1"), (["weave", "x"], "key=value"),
                            (["weave", "width=2"], "at most the pitch"),
                            (["dust", "voxels=8.5"], "a whole number")):
            with self.subTest(words):
                answer = self.lamella("grid", *words, "-o", "x.vdb", status=2)
                self.assertIn(part, answer.err)
        self.assertIn("-o", self.lamella("grid", "weave", status=2).err)

    @unittest.skipUnless(WITH_OPENVDB, "built without OpenVDB")
    def test_a_grid_that_was_made_reads_back_as_the_built_in_one(self):
        made = self.lamella("grid", "weave", "-o", "cloth.vdb").out
        self.write("cloth.toml", made)
        run = ["--wi", "40", *QUICK, "--json", "-"]
        mine = self.lamella("simulate", "cloth.toml", *run).json()
        built_in = self.lamella("simulate", "woven_cloth", *run).json()
        for side in ("reflected", "transmitted"):
            self.assertEqual(mine["runs"][0][side], built_in["runs"][0][side])
        answer = self.json_of("grid", "dust", "voxels=16", "-o", "dust.vdb")
        self.assertEqual(answer["voxels"], [16, 16, 8])

    @unittest.skipUnless(WITH_OPENVDB, "built without OpenVDB")
    def test_spheres_have_the_volume_that_is_known(self):
        answer = self.json_of("grid", "spheres", "packing=0.5", "realisations=4", "voxels=4")
        volume = answer["volume_fraction"]
        self.assertAlmostEqual(volume["expected"], 0.39346934, places=7)
        self.assertLess(abs(volume["value"] - volume["expected"]), 0.1)

    @unittest.skipUnless(WITH_OPENVDB, "built without OpenVDB")
    def test_files_that_are_none_are_refused(self):
        (self.folder / "sub").mkdir()
        self.write("sub/text.vdb", "no grid at all")
        for name in ("text.vdb", "."):
            self.write("sub/stack.toml", layer(grid=f'"{name}"'))
            answer = self.lamella("simulate", "sub/stack.toml", *QUICK, status=2)
            self.assertTrue(answer.err.startswith("lamella: sub/stack.toml:5: layer 0: key"),
                            str(answer))
            self.assertIn("allowed: a .vdb file", answer.err)

    @unittest.skipUnless(WITH_OPENVDB, "built without OpenVDB")
    def test_a_file_that_lacks_its_last_byte_is_refused_in_one_line(self):
        self.lamella("grid", "dust", "voxels=16", "-o", "dust.vdb")
        whole = (self.folder / "dust.vdb").read_bytes()
        (self.folder / "cut.vdb").write_bytes(whole[:-1])
        self.write("cut.toml", layer(grid='"cut.vdb"'))
        answer = self.lamella("simulate", "cut.toml", *QUICK, status=2)
        self.assertEqual(answer.err.count("\n"), 1, str(answer))
        for part in ("cut.toml:5: layer 0", "cut.vdb", "no whole .vdb file", "ends at byte",
                     "allowed: a .vdb file"):
            self.assertIn(part, answer.err)

    @unittest.skipUnless(WITH_OPENVDB, "built without OpenVDB")
    def test_names_and_tile_of_a_file_are_keys_of_the_layer(self):
        made = self.lamella("grid", "dust", "voxels=16", "-o", "dust.vdb").out
        self.write("dust.toml", made)
        self.write("named.toml", made + 'density_grid = "density"\nvoxels = [16, 16, 8]\n')
        run = ["--wi", "40", *QUICK, "--json", "-"]
        plain = self.lamella("simulate", "dust.toml", *run).json()
        named = self.json_of("simulate", "named.toml", "--wi", "40", *QUICK)
        self.assertEqual(plain["runs"][0]["reflected"], named["runs"][0]["reflected"])
        written = named["stack"]["layer"][0]
        self.assertEqual(written["density_grid"], "density")
        self.assertEqual(written["voxels"], [16, 16, 8])
        self.assertEqual(written["first_voxel"], [0, 0, 0])
        plan = self.lamella("explain", "named.toml").out
        self.assertIn('the layer\'s key "voxels"', plan)
        self.assertIn('density_grid = "density"', plan)
        self.write("other.toml", made + 'density_grid = "Density"\n')
        answer = self.lamella("simulate", "other.toml", *QUICK, status=2)
        self.assertIn('did you mean "density"?', answer.err)
        self.assertEqual(answer.err.count("\n"), 1, str(answer))

    @unittest.skipUnless(WITH_OPENVDB, "built without OpenVDB")
    def test_lengths_that_contradict_the_file_are_warned_of(self):
        made = self.lamella("grid", "dust", "voxels=16", "-o", "dust.vdb").out
        self.write("long.toml", "\n".join(
            "size = [7, 7]" if line.startswith("size") else line for line in made.splitlines()))
        answer = self.lamella("simulate", "long.toml", *QUICK)
        self.assertEqual(answer.err.count("lamella: warning: dust.vdb: "), 1, str(answer))
        self.assertIn("size and thickness say 7 x 7", answer.err)

    def test_stack_files_without_an_end_are_refused(self):
        answer = self.lamella("simulate", "/dev/zero", *QUICK, status=2)
        self.assertIn("/dev/zero: is a device", answer.err)
        self.assertEqual(answer.err.count("\n"), 1, str(answer))
