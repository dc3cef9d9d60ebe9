"""lamella.samples and fits of stacks: the command line's bits, views, what they refuse."""

import json

import numpy as np
import pytest

import lamella as lm


def test_samples_are_those_of_the_command_line(run, tmp_path):
    path = tmp_path / "walks.npz"
    run("samples", "vmf_sand", "--wi", "60", "--wi", "20,40", "--walks", "3000", "--seed", "4", "-o", str(path),
        "--quiet")
    found = lm.samples("vmf_sand", wi=[60, (20, 40)], walks=3000, seed=4)
    told = np.load(path)
    for name in "w_i", "w_o", "weight", "order", "side", "directions", "direction_walks", "direction_rows":
        mine = getattr(found, name)
        assert mine.dtype == told[name].dtype and np.array_equal(mine, told[name]), name
    assert told["walks"] == found.walks == 6000
    assert json.loads(str(told["lamella"])) == found.about
    again = tmp_path / "again.npz"
    assert found.save(again) == path.stat().st_size
    assert again.read_bytes() == path.read_bytes()


def test_samples_are_views_and_estimate_energies():
    white = lm.Stack(layers=[lm.layer("lambert_sphere", thickness=1)])
    found = lm.samples(white, distribution="uniform", walks=20000)
    assert found.w_o.shape == (len(found), 3) and found.weight.shape == (len(found), 1)
    assert not found.weight.flags.owndata
    with pytest.raises(ValueError):
        found.side[0] = 0
    assert len(found.directions) == 0
    np.testing.assert_allclose(np.linalg.norm(found.w_i, axis=1), 1, atol=2e-6)
    # All light leaves, and no weight changes.
    assert found.weight.sum() / found.walks == pytest.approx(1, abs=1e-6)


def test_samples_refuse_in_the_words_of_the_command_line():
    for keywords, text in (({"wi": [30], "distribution": "uniform"}, "--wi beside it"),
                           ({"distribution": "gauss"}, "uniform, cosine"), ({"walks": 3}, "--walks")):
        with pytest.raises(ValueError, match=text):
            lm.samples("sggx_slab", **keywords)
    with pytest.raises(ValueError, match=".npz"):
        lm.samples("sggx_slab", wi=[0], walks=200).save("x.txt")


def test_a_stacks_numbers_are_fitted_as_by_the_command_line(run, tmp_path):
    try:
        lm.fit(lm.Model("lambert", albedo=0.5), "lambert", wi=[0], grid=(2, 4))
    except Exception as error:
        if "CERES" in str(error):
            pytest.skip("built without Ceres")
        raise
    truth = lm.Stack(layers=[lm.layer("lambert_sphere", albedo=0.6, thickness=float("inf"))])
    start = lm.Stack(layers=[lm.layer("lambert_sphere", albedo=0.9, thickness=float("inf"))])
    found = lm.fit(truth, stack=start, vary={"layer.0.albedo": (0.1, 1)}, wi=[30], grid=(4, 4))
    assert found[0].values["layer.0.albedo"] == pytest.approx(0.6, abs=1e-3)
    assert "lambert_sphere" in found[0].stack.text
    truth.save(str(tmp_path / "truth.toml"))
    start.save(str(tmp_path / "start.toml"))
    told = json.loads(run("fit", str(tmp_path / "truth.toml"), "--stack", str(tmp_path / "start.toml"), "--vary",
                          "layer.0.albedo=0.1:1", "--wi", "30", "--grid", "4x4", "--json", "-"))
    assert told["models"][0]["parameters"] == found.answer["models"][0]["parameters"]
    for keywords, text in (({"vary": {"layer.0.albedo": (0, 1)}}, "--stack"),
                           ({"stack": start, "vary": {"layer.0.albedo": 3.0}}, "FROM, TO"),
                           ({"stack": start, "models": "eon"}, "--model")):
        with pytest.raises((ValueError, TypeError), match=text):
            lm.fit(truth, **keywords)
