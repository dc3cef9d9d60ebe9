"""lamella.library, and lamella.check against it: what the command line keeps and finds."""

import json

import numpy as np
import pytest

import lamella as lm

QUICK = ["isotropic_halfspace", "lambert_sphere_0.3"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import os
    import subprocess
    place = tmp_path_factory.mktemp("library") / "kept"
    subprocess.run([os.environ["LAMELLA"], "library", "build", str(place), "--only", ",".join(QUICK), "--quiet"],
                   check=True, timeout=300)
    return place


def test_an_entry_is_what_its_files_hold(folder):
    kept = lm.library(folder)
    assert list(kept) == ["lambert_sphere_0.3", "isotropic_halfspace"] and len(kept) == 2
    index = json.loads((folder / "index.json").read_text())
    for entry, known in zip(kept.values(), index["entries"]):
        assert entry.about == known
        assert entry.stack == lm.Stack.builtin(entry.name)
        arrays = np.load(folder / f"{entry.name}.npz")
        lobes = entry.lobes
        assert lobes.is_bounded == (entry.lobes_method["method"] == "adding-doubling")
        for side, name in lobes:
            assert np.array_equal(lobes[side, name], arrays[f"{side}.{name}"])
            assert np.array_equal(lobes.standard_error[side, name], arrays[f"{side}.{name}.se"])
        energies = lobes.energies
        assert np.array_equal(energies["reflect", "all"], arrays["energy.reflect.all"])
        assert np.array_equal(energies["absorbed"], arrays["energy.absorbed"])
        assert np.array_equal(energies.standard_error["absorbed"], arrays["energy.absorbed.se"])
        points = entry.points
        for name in points._fields:
            assert np.array_equal(getattr(points, name), arrays["points." + name])
        # Another way to the same values.
        f, error = lm.truth(entry.stack, points.wi[:4], points.wo[:4], tolerance=1e-7)
        assert (abs(f - points.f[:4]) <= error + points.error[:4]).all()


def test_refuses_what_is_none(folder, tmp_path):
    with pytest.raises(ValueError, match="index.json"):
        lm.library(tmp_path)
    with pytest.raises(KeyError, match="isotropic_halfspace"):
        lm.library(folder)["isotropic"]
    import shutil
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    whole = (broken / "isotropic_halfspace.npz").read_bytes()
    (broken / "isotropic_halfspace.npz").write_bytes(whole[:-1] + b"x")
    with pytest.raises(ValueError, match="SHA-256"):
        lm.library(broken)["isotropic_halfspace"].lobes


def without_threads(answer):
    return {key: value for key, value in answer.items() if key not in ("threads", "files")}


def test_a_check_against_a_library_is_that_of_the_command_line(folder, run):
    told = json.loads(run("check", "chandrasekhar", "--quick", "--library", folder, "--json", "-", "--quiet"))
    found = lm.check("chandrasekhar", quick=True, library=folder)
    assert without_threads(found.answer) == without_threads(told)
    # The model itself, its parameters fixed.
    line = lm.check(lm.Model("chandrasekhar", albedo=0.9), quick=True, library=folder).checks["isotropic_halfspace"]
    assert line["verdict"] == "pass" and line["worst"]["found"] < 1e-4
    with pytest.raises(ValueError, match="claims"):
        lm.check(lm.Model("chandrasekhar", albedo=0.5), quick=True, library=folder)


def test_functions_are_held_against_entries_that_are_named(folder):
    exact = lm.Model("chandrasekhar", albedo=0.9)

    def right(wi, wo):
        return exact.eval(wi, wo)

    def brighter(wi, wo):
        return 1.05 * exact.eval(wi, wo)

    def scaled(wi, wo, *, gain):
        return gain * exact.eval(wi, wo)
    found = lm.check(right, quick=True, library=folder, entries="isotropic_halfspace")
    assert found.checks["isotropic_halfspace"]["worst"]["found"] < 1e-4
    found = lm.check(brighter, quick=True, library=folder, entries=["isotropic_halfspace"], max_error=0.04)
    line = found.checks["isotropic_halfspace"]
    assert line["verdict"] == "fail" and line["worst"]["found"] == pytest.approx(0.05, abs=1e-3)
    family = lm.Family(scaled, numbers={"gain": (0.5, 1)})
    line = lm.check(family, quick=True, library=folder,
                    entries="isotropic_halfspace,gain=0.98").checks["isotropic_halfspace"]
    assert line["worst"]["found"] == pytest.approx(0.02, abs=1e-3)
    for entries, part in ([], "claims"), ("none", "--entry"), ("isotropic_halfspace,gain=1", "fixed"):
        with pytest.raises(ValueError, match=part):
            lm.check(right, quick=True, library=folder, entries=entries)
    with pytest.raises(ValueError, match="--library"):
        lm.check(right, quick=True, entries="isotropic_halfspace")
