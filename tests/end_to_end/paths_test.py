"""Files that a stack or a command line names: found again from whatever is written elsewhere."""

import hashlib
import json
import os
import pathlib
import shutil
import unittest

from lamella_program import ProgramTest, without, TIMINGS

QUICK = ["--walks", "1000", "--grid", "2x4", "--wi", "60", "--quiet"]
WITH_OPENVDB = os.environ["LAMELLA_OPENVDB"] == "ON"
PLUGIN = os.path.join(os.environ["LAMELLA_PLUGINS"], "minnaert.so")


class Files(ProgramTest):
    def make_cloth(self, folder="in", pitch="0.5"):
        (self.folder / folder).mkdir(exist_ok=True)
        self.lamella("grid", "weave", f"pitch={pitch}", f"width={0.9 * float(pitch)}", "voxels=16",
                     "-o", f"{folder}/c.vdb", "--quiet")
        self.write(f"{folder}/cloth.toml", '[[layer]]\nmedium = "sggx"\nroughness = 0.3\nalbedo = 0.8\n'
                   'thickness = 0.4\ngrid = "c.vdb"\nsize = [1, 1]\n')

    def read(self, name):
        return json.loads((self.folder / name).read_text())

    def move(self, *names, to):
        (self.folder / to).mkdir(parents=True)
        for name in names:
            shutil.move(self.folder / name, self.folder / to / name)

    def same(self, file, status=0):
        answer = self.json_of("rerun", file, "--quiet", status=status)
        self.assertEqual((answer["same"], answer["differences"]), (True, []))

    def refused(self, *arguments):
        answer = self.lamella(*arguments, status=2)
        self.assertEqual(answer.err.count("\n"), 1, str(answer))
        return answer.err

    def assert_no_absolute_path(self, folder):
        """Of everything that is written there."""
        root = str(self.folder).encode()
        for path in (self.folder / folder).rglob("*"):
            if path.is_file():
                self.assertNotIn(root, path.read_bytes(), path)


@unittest.skipUnless(WITH_OPENVDB, "without OpenVDB there are no grid files")
class GridsThatAStackNamesRelativeToItself(Files):
    def test_sweep_from_another_folder(self):
        self.make_cloth()
        sweep = ["sweep", "in/cloth.toml", "--set", "layer.0.albedo=0.5,0.9", *QUICK, "-o", "out"]
        answer = self.json_of(*sweep)
        self.assertEqual(answer["stack"]["layer"][0]["grid"], "in/c.vdb")
        report = self.read("out/report.json")
        for part in [report, *(point["answer"] for point in report["points"])]:
            self.assertEqual(part["stack"]["layer"][0]["grid"], "../in/c.vdb")
        self.assertEqual([f["name"] for f in report["files"]], ["../in/c.vdb"])
        self.assertEqual(self.read("out/points/0000.json")["stack"]["layer"][0]["grid"], "../../in/c.vdb")
        self.assert_no_absolute_path("out")
        # A point's stack runs by itself, from anywhere, and gives the point's answer.
        alone = self.json_of("compare", "out/points/0001.toml", *QUICK, "-o", "alone")
        self.assertEqual(without(alone["models"], TIMINGS),
                         without(report["points"][1]["answer"]["models"], TIMINGS))
        self.assertEqual(self.json_of("furnace", "in/cloth.toml", *QUICK[:2], "--wi", "60", "--quiet")
                         ["stack"]["layer"][0]["grid"], "in/c.vdb")

    def test_a_rerun_finds_them_wherever_both_were_moved(self):
        self.make_cloth()
        self.lamella("compare", "in/cloth.toml", "--model", "lambert,albedo=0.5", *QUICK, "-o", "out")
        self.assert_no_absolute_path("out")
        self.same("out/truth.exr")
        self.same("out/lambert.exr")
        self.move("in", "out", to="elsewhere/deep")
        self.same("elsewhere/deep/out/truth.exr")
        # All in one folder.
        (self.folder / "flat").mkdir()
        shutil.copy(self.folder / "elsewhere/deep/out/truth.exr", self.folder / "flat")
        message = self.refused("rerun", "flat/truth.exr")
        self.assertIn('flat/truth.exr: file "../in/c.vdb": found nothing', message)
        shutil.copy(self.folder / "elsewhere/deep/in/c.vdb", self.folder / "flat")
        self.same("flat/truth.exr")

    def test_a_rerun_that_is_written_names_them_for_its_own_place(self):
        self.make_cloth()
        self.lamella("simulate", "in/cloth.toml", *QUICK, "-o", "a.exr")
        (self.folder / "out").mkdir()
        self.lamella("rerun", "a.exr", "-o", "out/b.exr", "--quiet")
        self.same("out/b.exr")
        stack = self.json_of("show", "out/b.exr", "--quiet")["attributes"]["lamella.stack"]
        self.assertIn('grid = "../in/c.vdb"', stack)
        self.lamella("rerun", "out/b.exr", "-o", "c.exr", "--quiet")
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "c.exr").read_bytes())

    def test_a_rerun_refuses_a_file_whose_content_changed(self):
        self.make_cloth()
        self.lamella("simulate", "in/cloth.toml", *QUICK, "-o", "a.exr")
        self.make_cloth(pitch="0.25")
        message = self.refused("rerun", "a.exr")
        for part in ("a.exr", '"in/c.vdb"', "sha256", "allowed: the file that was read"):
            self.assertIn(part, message)

    def test_a_sweep_does_not_go_on_with_another_file(self):
        self.make_cloth()
        sweep = ["sweep", "in/cloth.toml", "--set", "layer.0.albedo=0.5,0.9", *QUICK[:-1], "-o", "out"]
        self.lamella(*sweep)
        cloth = (self.folder / "in/c.vdb").read_bytes()
        os.utime(self.folder / "in/c.vdb")  # read again, the same content
        self.assertEqual(self.lamella(*sweep).out.count("(was there)"), 2)
        self.make_cloth(pitch="0.25")
        message = self.refused(*sweep)
        for part in ("out/settings.json", "another sweep", "../in/c.vdb had another content", "allowed: -o"):
            self.assertIn(part, message)
        # A stack file that says the same in other words goes on; another stack does not.
        (self.folder / "in/c.vdb").write_bytes(cloth)
        text = (self.folder / "in/cloth.toml").read_text()
        self.write("in/cloth.toml", "# as before\n" + text)
        self.lamella(*sweep)
        self.write("in/cloth.toml", text.replace("0.3", "0.4"))
        self.assertIn("its stack differs", self.refused(*sweep))

    def test_equal_runs_give_equal_files(self):
        self.make_cloth()
        for folder in ("a", "b"):
            self.lamella("simulate", "in/cloth.toml", *QUICK, "-o", f"{folder}.exr")
        self.assertEqual((self.folder / "a.exr").read_bytes(), (self.folder / "b.exr").read_bytes())


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


class WhatWasRead(Files):
    def files_of(self, *arguments):
        return self.json_of(*arguments, "--quiet").get("files")

    @unittest.skipUnless(WITH_OPENVDB, "without OpenVDB there are no grid files")
    def test_grids_stand_in_every_answer(self):
        self.make_cloth()
        expected = [{"name": "in/c.vdb", "sha256": sha256(self.folder / "in/c.vdb")}]
        few = ["--walks", "1000", "--wi", "60"]
        for arguments in (["simulate", "in/cloth.toml", *few], ["furnace", "in/cloth.toml", *few],
                          ["homogenise", "in/cloth.toml", *few, "--grid", "2x4"],
                          ["furnace", "in/cloth.toml", "--model", "lambert", "--wi", "60"],
                          ["explain", "in/cloth.toml"],
                          ["invert", "in/cloth.toml", "albedo=0.02", "--walks", "1000"]):
            with self.subTest(arguments[0]):
                self.assertEqual(self.files_of(*arguments), expected)

    def test_pictures_and_shared_objects_do_too(self):
        shutil.copy(PLUGIN, self.folder)
        plugin = {"name": "minnaert.so", "sha256": sha256(self.folder / "minnaert.so")}
        small = ["--size", "16"]
        self.lamella("preview", "lambert_sphere_halfspace", "--model", "lambert", *small, "--quiet", "-o", "light")
        picture = "light/sphere_lamp.exr"
        seen = self.files_of("preview", "lambert_sphere_halfspace", "--model", "./minnaert.so,albedo=0.5", *small,
                             "--environment", picture, "-o", "out")
        self.assertEqual(seen, [plugin, {"name": picture, "sha256": sha256(self.folder / picture)}])
        recorded = self.json_of("show", "out/plane_environment.exr", "--quiet")["attributes"]["lamella.files"]
        self.assertEqual(recorded, f"{plugin['sha256']}  ../minnaert.so\n"
                         f"{sha256(self.folder / picture)}  ../{picture}\n")
        for arguments in (["furnace", "--model", "./minnaert.so,albedo=0.5", "--wi", "60", "--max-error", "9"],
                          ["samplers", "--model", "./minnaert.so,albedo=0.5", "--samples", "100"],
                          ["invert", "./minnaert.so", "albedo=0.2"]):
            with self.subTest(arguments[0]):
                self.assertEqual(self.files_of(*arguments), [plugin])

    @unittest.skipUnless(WITH_OPENVDB, "without OpenVDB there are no grid files")
    def test_a_sweep_warns_of_a_grid_once(self):
        self.make_cloth()
        text = (self.folder / "in/cloth.toml").read_text()
        self.write("in/wide.toml", text.replace("size = [1, 1]", "size = [3, 3]"))
        answer = self.lamella("sweep", "in/wide.toml", "--set", "layer.0.albedo=0.2,0.5,0.8", *QUICK, "-o", "out")
        self.assertEqual(answer.err.count("warning"), 1, answer.err)


class ModelsOfSharedObjects(Files):
    MODEL = "./minnaert.so,albedo=0.6,k=0.8"

    def setUp(self):
        super().setUp()
        shutil.copy(PLUGIN, self.folder)

    def change_plugin(self):
        """Other content, the same code: bytes after a shared object's end mean nothing."""
        new = self.folder / "new.so"
        new.write_bytes((self.folder / "minnaert.so").read_bytes() + b"\0")
        new.rename(self.folder / "minnaert.so")

    def test_a_rerun_loads_the_object_that_was_judged(self):
        self.lamella("compare", "sggx_slab", "--model", self.MODEL, *QUICK, "-o", "out")
        self.assertEqual(self.read("out/report.json")["files"][0]["name"], "../minnaert.so")
        self.assert_no_absolute_path("out")
        self.same("out/minnaert.exr")
        self.move("out", "minnaert.so", to="elsewhere")
        self.same("elsewhere/out/minnaert.exr")
        shutil.move(self.folder / "elsewhere/minnaert.so", self.folder)
        self.move("elsewhere", to="again")
        self.assertIn('"../minnaert.so"', self.refused("rerun", "again/elsewhere/out/minnaert.exr"))
        # The truth needs no model.
        self.same("again/elsewhere/out/truth.exr")

    def test_a_file_of_a_model_names_its_object_relative_to_itself(self):
        self.move("minnaert.so", to="mine")
        for text in ("./minnaert.so,albedo=0.6,k=0.8", "minnaert.so,k=0.8,albedo=0.6,0.6,0.6"):
            self.write("mine/model.txt", f"# mine\n{text}\n")
            answer = self.json_of("compare", "sggx_slab", "--model", "@mine/model.txt", *QUICK, "-o", "out")
            self.assertEqual(answer["files"][0]["name"], "mine/minnaert.so")
        self.same("out/minnaert.exr")

    def test_a_rerun_refuses_another_object(self):
        self.lamella("compare", "sggx_slab", "--model", self.MODEL, *QUICK, "-o", "out")
        self.change_plugin()
        message = self.refused("rerun", "out/minnaert.exr")
        self.assertIn('"../minnaert.so"', message)
        self.assertIn("sha256", message)

    def test_a_sweep_does_not_go_on_with_another_object(self):
        sweep = ["sweep", "sggx_slab", "--set", "layer.0.albedo=0.5,0.9", "--model", self.MODEL, *QUICK[:-1],
                 "-o", "out"]
        self.lamella(*sweep)
        self.assertEqual(self.lamella(*sweep).out.count("(was there)"), 2)
        self.change_plugin()
        self.assertIn("../minnaert.so had another content", self.refused(*sweep))
        self.assert_no_absolute_path("out")
        pathlib.Path(self.folder / "minnaert.so").unlink()
        self.assertIn("minnaert.so", self.refused(*sweep))


class ASweepThatGoesOn(Files):
    def test_keeps_the_status_of_the_points_that_were_there(self):
        sweep = ["sweep", "sggx_slab", "--set", "layer.0.albedo=0.5,0.9", "--model", "lambert", *QUICK, "-o",
                 "out", "--max-error", "0.001"]
        self.lamella(*sweep, status=1)
        self.lamella(*sweep, status=1)

    def test_not_with_other_limits(self):
        sweep = ["sweep", "sggx_slab", "--set", "layer.0.albedo=0.5,0.9", "--model", "lambert", *QUICK, "-o",
                 "out"]
        self.lamella(*sweep)
        self.assertIn("its max_error is null instead of 0.5", self.refused(*sweep, "--max-error", "0.5"))
        self.assertIn("its seed is 1 instead of 2", self.refused(*sweep, "--seed", "2"))
