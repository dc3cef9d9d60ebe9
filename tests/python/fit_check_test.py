"""lamella.fit and lamella.check: the command line's numbers, Python functions, what they refuse."""

import functools
import json

import numpy as np
import pytest

import lamella as lm


def tilted(wi, wo, *, albedo, tilt):
    """A function of arrays with a colour and a number for parameters."""
    calls.append(len(wi))
    return (1 + tilt * wi[:, 2:] * wo[:, 2:]) * albedo / np.pi


calls = []


def has_ceres():
    try:
        lm.fit(lm.Model("lambert", albedo=0.5), "lambert", wi=[0], grid=(2, 4))
    except Exception as error:  # the text of a build without Ceres
        if "CERES" in str(error):
            return False
        raise
    return True


needs_ceres = pytest.mark.skipif(not has_ceres(), reason="built without Ceres")


@needs_ceres
def test_a_fit_is_that_of_the_command_line(run):
    told = json.loads(run("fit", "lambert_sphere_halfspace", "--model", "eon,lambert_sphere", "--wi", "30", "--wi",
                          "60", "--grid", "6x8", "--json", "-"))
    fits = lm.fit("lambert_sphere_halfspace", "eon,lambert_sphere", wi=[30, 60], grid=(6, 8))
    for answer in told, fits.answer:
        del answer["threads"]
    assert fits.answer == told
    assert [f.name for f in fits] == ["lambert_sphere", "eon"]
    assert fits[0].model.request == lm.Model(fits[0].request).request
    assert fits[0].covariance.shape == (1, 1)
    assert "lambert_sphere" in str(fits) and "left over" in repr(fits[0])
    assert fits.report.table[0]["model"] == "lambert_sphere"


@needs_ceres
def test_a_python_function_is_fitted_and_called_with_arrays():
    target = lm.Model(functools.partial(tilted, albedo=np.array([0.8, 0.4, 0.2]), tilt=0.3),
                      name="target")
    calls.clear()
    family = lm.Family(tilted, numbers={"tilt": (0, 1)}, colors={"albedo": (0, 1)})
    fits = lm.fit(target, [family, "lambert"], wi=[0, 50], grid=(4, 8))
    assert min(calls) > 64, "pair by pair"
    best = fits[0]
    assert best.name == "tilted"
    truth = {"tilt": 0.3, "albedo.r": 0.8, "albedo.g": 0.4, "albedo.b": 0.2}
    for name, value in truth.items():
        # As the C++ test has it: twice what the target's own bound makes.
        assert abs(best.values[name] - value) <= 2 * best.errors_of_truth[name], name
        assert best.states[name] == "found"
    wi, wo = lm.directions([30.0]), lm.directions([40.0], 70)
    assert np.allclose(best.model.eval(wi, wo), target.eval(wi, wo), rtol=1e-3)


@needs_ceres
def test_a_fit_takes_lobes_and_functions(tmp_path):
    lobes = lm.Model("oren_nayar", albedo=0.7, sigma=0.4).lobes([20, 60], grid=(6, 8))
    found = lm.fit(lobes, "oren_nayar")[0]
    assert abs(found.values["sigma"] - 0.4) <= 2 * found.errors_of_truth["sigma"]
    again = lm.fit(lambda wi, wo: np.full(len(wi), 0.3 / np.pi), "lambert", wi=[0, 60], grid=(2, 4))[0]
    assert abs(again.values["albedo"] - 0.3) < 1e-4
    fits = lm.fit(lobes, ["lambert", "fon"])
    fits.save(tmp_path / "fits")
    assert {"fit.json", "report.html", "report.json"} <= {p.name for p in (tmp_path / "fits").iterdir()}


@needs_ceres
def test_a_fitted_stack_is_reported_order_by_order(tmp_path):
    truth = lm.Stack([lm.layer("lambert_sphere", albedo=0.8, thickness=0.7)])
    start = lm.Stack([lm.layer("lambert_sphere", albedo=0.8, thickness=2)], name="start")
    fits = lm.fit(truth, stack=start, vary={"layer.0.thickness": (0.1, 5, "log")}, wi=[60], grid=(2, 4))
    assert abs(fits[0].values["layer.0.thickness"] - 0.7) < 2e-3
    table = fits.report.table
    assert {row["order"] for row in table} == {"1", "2", "3", "4+", "2+", "all"}
    assert all(row["relative_rmse_without_noise"] < 1e-3 for row in table)
    fits.save(tmp_path / "out")
    assert lm.Stack.read(tmp_path / "out/stack.toml").text == fits[0].stack.text
    assert {"fit.json", "report.html", "start.exr"} <= {p.name for p in (tmp_path / "out").iterdir()}
    assert "iframe" in fits._repr_html_()


@needs_ceres
def test_what_a_function_raises_reaches_the_caller_of_fit():
    def wrong(wi, wo, *, a):
        raise KeyError("mine")
    with pytest.raises(KeyError, match="mine"):
        lm.fit(lm.Model("lambert", albedo=0.5), lm.Family(wrong, numbers={"a": (0, 1)}), wi=[0],
               grid=(2, 4))


@pytest.mark.parametrize("arguments, keywords, part", [
    (("sggx_slab", "nonsense"), {}, "nonsense"), (("sggx_slab", "eon"), {"norm": "x"}, "--norm"),
    (("sggx_slab", []), {}, "models"), (("sggx_slab", "spongecake"), {}, "stack"),
    (("sggx_slab", [lambda wi, wo: wi]), {}, "Family")])
def test_a_fit_refuses(arguments, keywords, part):
    if not has_ceres():
        pytest.skip("built without Ceres")
    with pytest.raises(ValueError, match=part):
        lm.fit(*arguments, **keywords)
    with pytest.raises(ValueError, match="lowest|finite"):
        lm.Family(lambda wi, wo, a: wi, numbers={"a": (1, 0)})


def test_a_check_is_that_of_the_command_line(run):
    told = json.loads(run("check", "eon", "--quick", "--json", "-", "--quiet"))
    found = lm.check("eon", quick=True)
    for answer in told, found.answer:
        del answer["threads"]
    assert found.answer == told
    assert found and found.passed and not found.failures
    assert found.checks["energy"]["verdict"] == "pass"


def test_a_function_is_checked_and_called_with_arrays(tmp_path):
    sizes = []

    def lambert(wi, wo):
        sizes.append(len(wi))
        return np.full(len(wi), 0.5 / np.pi)
    found = lm.check(lambert, quick=True, reciprocal=True)
    assert found.passed, str(found)
    assert found.checks["reciprocity"]["verdict"] == "pass"
    # Some 33 pairs are asked for alone; all else is arrays, most of the values.
    assert sum(n for n in sizes if n == 1) < 64 and sum(sizes) > 10000
    found.save(tmp_path / "check.html")
    assert "lambert: check" in (tmp_path / "check.html").read_text()


def test_wrong_functions_fail_with_the_worst_case():
    def bright(wi, wo):
        return np.full(len(wi), 1.5 / np.pi)

    def lopsided(wi, wo):
        return 0.1 + 0.05 * wi[:, 2]

    def odd(wi, wo):  # depends on what else is in the batch
        return np.full(len(wi), 0.1 + 1e-3 * (len(wi) > 1))
    assert set(lm.check(bright, quick=True).failures) == {"energy"}
    found = lm.check(lopsided, quick=True, reciprocal=True)
    assert "reciprocity" in found.failures and not found
    assert lm.check(lopsided, quick=True).passed  # claims nothing
    assert "batches" in lm.check(odd, quick=True).failures
    negative = lm.check(lambda wi, wo: wi[:, 0], quick=True)
    assert "values" in negative.failures and "not below 0" in negative.failures["values"]


def test_a_family_is_checked_over_its_ranges():
    def grows(wi, wo, *, gain):
        return np.full(len(wi), gain / np.pi)
    found = lm.check(lm.Family(grows, numbers={"gain": (0.0, 1.2)}), quick=True)
    worst = found.checks["energy"]["worst"]
    assert "energy" in found.failures and "gain=1.2" in worst["request"]
    assert worst["found"] == pytest.approx(1.2, rel=1e-6)


def test_what_a_function_raises_reaches_the_caller_of_check():
    def wrong(wi, wo):
        if len(wi) > 1:
            raise KeyError("mine")
        return np.ones(len(wi))
    with pytest.raises(KeyError, match="mine"):
        lm.check(wrong, quick=True)
    with pytest.raises(ValueError, match="--samples"):
        lm.check("eon", samples=1)
    with pytest.raises(ValueError, match="unknown"):
        lm.check("nonsense")
