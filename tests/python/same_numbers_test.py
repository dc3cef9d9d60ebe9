"""What Python computes equals the command line's answer bit by bit."""

import csv
import io
import json

import numpy as np
import pytest

import lamella as lm

ANGLES = [(0, 0, 30, 0), (30, 0, 30, 180), (60, 20, 45, 300), (80, 0, 85, 77), (10, 5, 89, 10)]
PAIRS = "theta_i,phi_i,theta_o,phi_o\n" + "".join(",".join(map(str, a)) + "\n" for a in ANGLES)
WI = lm.directions([a[0] for a in ANGLES], [a[1] for a in ANGLES])
WO = lm.directions([a[2] for a in ANGLES], [a[3] for a in ANGLES])


def columns(text, *names):
    rows = list(csv.DictReader(io.StringIO(text)))
    return np.array([[float(row[name]) for name in names] for row in rows])


@pytest.mark.parametrize("stack, options", [
    ("vmf_sand", {"walks": 2000, "estimator": "analog"}),
    ("spongecake_two_layer", {"walks": 1000, "estimator": "next-event", "seed": 7}),
    ("hg_slab", {"estimator": "deterministic", "tolerance": 1e-4}),
])
def test_lobes_are_the_file_that_simulate_writes(stack, options, run, tmp_path):
    if stack not in [s["name"] for s in lm.stacks()]:
        stack = "sggx_slab"
    lobes = lm.simulate(stack, wi=[30, (60, 45)], grid=(4, 8), **options)
    flags = [f"--{key.replace('_', '-')}={value}" for key, value in options.items()]
    answer = json.loads(run("simulate", stack, "--wi", "30", "--wi", "60,45", "--grid", "4x8",
                            "-o", "ours.exr", "--json", "-", *flags))
    lobes.save(tmp_path / "theirs.exr")
    assert (tmp_path / "theirs.exr").read_bytes() == (tmp_path / "ours.exr").read_bytes()
    for side, key in [("reflect", "reflected"), ("transmit", "transmitted")]:
        for name in "1", "2", "3", "4+":
            assert lobes.energies[side, name].tolist() == [
                r[key]["orders"][name]["total"] for r in answer["runs"]]
        assert lobes.energies.standard_error[side, "all"].tolist() == [
            r[key]["standard_error"] for r in answer["runs"]]
    for name in "uncollided", "absorbed", "unresolved":
        assert lobes.energies[name].tolist() == [r[name] for r in answer["runs"]]
    ours = lobes.answer
    for drop in "seconds", "threads":
        answer.pop(drop, None), ours.pop(drop, None)
    for r in answer["runs"] + ours["runs"]:
        del r["seconds"]
    assert ours == answer


@pytest.mark.parametrize("name, parameters", [
    ("eon", {"albedo": [0.8, 0.4, 0.2], "roughness": 0.5}),
    ("vmf_diffuse", {"albedo": 0.7, "roughness": 0.3}),
    ("lambert_sphere", {}),
    ("microfacet", {"roughness": 0.3}),
])
def test_models_are_eval(name, parameters, run):
    model = lm.Model(name, **parameters)
    words = [f"{k}={','.join(map(str, np.atleast_1d(v)))}" for k, v in parameters.items()]
    for part, values in [("", model.eval(WI, WO)), (".pdf", model.pdf(WI, WO)[:, None]),
                         (".albedo", model.albedo(WI)),
                         ("." + model.lobe_names[0], model.eval(WI, WO, lobe=model.lobe_names[0]))]:
        text = run("eval", name + part, *words, "--pairs", "-", stdin=PAIRS)
        names = ["f"] if ",f\n" in text or ",f," in text.splitlines()[0] + "," else \
            ["f_r", "f_g", "f_b"]
        theirs = columns(text, *names)
        # Where all that was typed is grey the command line tells the first channel alone.
        values = np.broadcast_to(values, (len(WI), max(values.shape[1], len(names))))
        assert np.array_equal(values[:, :len(names)], theirs), part


@pytest.mark.parametrize("options", [{"estimator": "deterministic", "tolerance": 1e-5},
                                     {"estimator": "next-event", "walks": 2000, "seed": 3}])
def test_truth_is_eval_truth(options, run):
    f, error = lm.truth("vmf_sand", WI, WO, **options)
    words = [f"{key}={value}" for key, value in options.items()]
    text = run("eval", "truth", "stack=vmf_sand", *words, "--pairs", "-", stdin=PAIRS)
    names = ["f"] if f.shape[-1] == 1 else ["f_r", "f_g", "f_b"]
    assert np.array_equal(f, columns(text, *names))
    assert np.array_equal(error, columns(text, *[n.replace("f", "se", 1) for n in names]))


def test_threads_change_nothing():
    one, two = (lm.simulate("vmf_sand", wi=[60], walks=2000, grid=(4, 8), threads=n)
                for n in (1, 2))
    assert np.array_equal(one["reflect", "all"], two["reflect", "all"])


def test_compare_is_the_command(run):
    report = lm.compare("lambert_sphere_halfspace", ["lambert_sphere", "lambert,albedo=0.5"],
                        wi=[60], grid=(4, 8), walks=20000)
    answer = json.loads(run("compare", "lambert_sphere_halfspace", "--model", "lambert_sphere",
                            "--model", "lambert,albedo=0.5", "--wi", "60", "--grid", "4x8",
                            "--walks", "20000", "-o", "out", "--json", "-"))
    ours = report.answer
    for a in (ours, answer):
        del a["threads"]
        for model in a["models"]:
            del model["ns_per_eval"]
    assert ours == answer
    assert {row["verdict"] for row in report.table} <= {"agrees", "differs", "insufficient"}
    assert report.table[0]["model"] == "lambert_sphere"


def test_furnace_is_the_command(run):
    ours = lm.furnace("vmf_sand", wi=[60], walks=2000, estimator="analog").answer
    theirs = json.loads(run("furnace", "vmf_sand", "--wi", "60", "--walks", "2000",
                            "--estimator", "analog", "--json", "-"))
    for a in (ours, theirs):
        del a["threads"]
        for r in a["runs"]:
            del r["seconds"]
    assert ours == theirs
