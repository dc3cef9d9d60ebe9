"""Files for other programs, read back by readers written from the formats' descriptions."""

import csv
import io
import json
import struct

import numpy as np
import pytest

import lamella as lm

@pytest.fixture(scope="module")
def spread():
    """The points by which `lamella export` tells the error of a format: eight w_i along mu_i^2, and
    for each 8 x 16 cells of w_o with 4 x 4 points."""
    mu_i2 = (np.arange(8) + 0.5) / 8
    mu_o2 = (np.arange(32) + 0.5) / 32
    phi = 2 * np.pi * (np.arange(64) + 0.5) / 64
    turn = 2.4 * np.arange(8)
    i, row, column = np.meshgrid(np.arange(8), np.arange(32), np.arange(64), indexing="ij")
    def vectors(mu2, angle):
        sine = np.sqrt(1 - mu2)
        return np.stack([sine * np.cos(angle), sine * np.sin(angle), np.sqrt(mu2)], -1).reshape(-1, 3)
    return (vectors(mu_i2[i], turn[i]), vectors(mu_o2[row], turn[i] + phi[column]))


# A reader of tensor files

def read_container(data):
    assert data[:12] == b"tensor_file\0" and data[12:14] == bytes([1, 0])
    count, = struct.unpack_from("<I", data, 14)
    at, fields = 18, {}
    for _ in range(count):
        length, = struct.unpack_from("<H", data, at)
        name = data[at + 2:at + 2 + length].decode()
        at += 2 + length
        axes, kind, offset = struct.unpack_from("<HBQ", data, at)
        shape = struct.unpack_from(f"<{axes}Q", data, at + 11)
        at += 11 + 8 * axes
        type = {1: np.uint8, 10: np.float32, 11: np.float64}[kind]
        fields[name] = np.frombuffer(data, type, int(np.prod(shape)), offset).reshape(shape)
    return fields


def sums_of(d):
    """Of a density at nodes [..., H, W]: normalised, and its integrals: conditional up to each
    column, of rows, marginal up to each row."""
    def integral(y, axis):
        y = np.moveaxis(y, axis, -1)
        part = np.cumsum((y[..., 1:] + y[..., :-1]) / 2, -1) / (y.shape[-1] - 1)
        return np.moveaxis(np.concatenate([np.zeros_like(part[..., :1]), part], -1), -1, axis)
    d = d / integral(integral(d, -1)[..., -1], -1)[..., -1, None, None]
    conditional = integral(d, -1)
    return d, conditional, conditional[..., -1], integral(conditional[..., -1], -1)


def interval(x, n):
    at = np.clip(x, 0, 1) * (n - 1)
    k = np.minimum(at.astype(int), n - 2)
    return k, at - k


def read_tensor(data, wi, wo, colors):
    """f by the file's own rules; its w_i is the direction to the camera, our w_o."""
    t = {name: a.astype(float) if a.dtype != np.uint8 else a
         for name, a in read_container(data).items()}
    camera, light = wo, wi
    m = camera + light
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    theta_i, phi_i = np.arccos(np.clip(camera[:, 2], -1, 1)), np.arctan2(camera[:, 1], camera[:, 0])
    theta_m, phi_m = np.arccos(np.clip(m[:, 2], -1, 1)), np.arctan2(m[:, 1], m[:, 0])
    isotropic = len(t["phi_i"]) <= 2
    v = ((phi_m - (phi_i if isotropic else 0) + np.pi) / (2 * np.pi)) % 1
    u = np.sqrt(2 * theta_m / np.pi)
    density, conditional, rows, marginal = sums_of(t["vndf"])
    h, w = t["vndf"].shape[-2:]
    r, y = interval(v, h)
    c, x = interval(u, w)

    def among(nodes, value):
        if len(nodes) == 1:
            return np.zeros(len(value), int), np.zeros(len(value))
        k = np.clip(np.searchsorted(nodes, value, "right") - 1, 0, len(nodes) - 2)
        return k, np.clip((value - nodes[k]) / (nodes[k + 1] - nodes[k]), 0, 1)

    kt, xt = among(t["theta_i"], theta_i)
    kp, xp = among(t["phi_i"], phi_i)
    parts = [((kp + a, kt + b), (xp if a else 1 - xp) * (xt if b else 1 - xt))
             for a in ((0,) if len(t["phi_i"]) == 1 else (0, 1)) for b in (0, 1)]
    total_m = total_c = total_r = 0
    for s, weight in parts:
        n = lambda dr, dc: density[s[0], s[1], r + dr, c + dc]
        n0, n1 = (1 - y) * n(0, 0) + y * n(1, 0), (1 - y) * n(0, 1) + y * n(1, 1)
        row0, row1 = rows[s[0], s[1], r], rows[s[0], s[1], r + 1]
        total_m += weight * (marginal[s[0], s[1], r] + y * (row0 + y * (row1 - row0) / 2) / (h - 1))
        total_c += weight * ((1 - y) * conditional[s[0], s[1], r, c]
                             + y * conditional[s[0], s[1], r + 1, c]
                             + x * (n0 + x * (n1 - n0) / 2) / (w - 1))
        total_r += weight * ((1 - y) * row0 + y * row1)
    s_u, s_v = total_c / total_r, total_m
    table = t[colors]
    size = table.shape[-1]
    r, y = interval(s_v, size)
    c, x = interval(s_u, size)
    value = 0
    for s, weight in parts:
        at = lambda dr, dc: table[s[0], s[1], :, r + dr, c + dc]
        value = value + weight[:, None] * (
            ((1 - y) * (1 - x))[:, None] * at(0, 0) + ((1 - y) * x)[:, None] * at(0, 1)
            + (y * (1 - x))[:, None] * at(1, 0) + (y * x)[:, None] * at(1, 1))
    assert np.all(t["ndf"] == 1) and np.all(t["sigma"] == 0.25) and t["jacobian"][0] == 1
    return value / light[:, 2:]


def relative_rmse(found, f):
    return np.sqrt(np.sum((found - f) ** 2) / np.sum(f ** 2))


def on_cells(f):
    return f.reshape(8, 8, 4, 16, 4, -1).mean(axis=(2, 4))


@pytest.mark.parametrize("to, field", [("mitsuba", "rgb"), ("pbrt", "spectra")])
def test_a_tensor_file_gives_the_model_back(to, field, spread, tmp_path):
    model = lm.Model("vmf_diffuse", albedo=[0.9, 0.6, 0.3], roughness=0.5)
    told = model.save(tmp_path / "a.bsdf", to, size="medium")
    data = (tmp_path / "a.bsdf").read_bytes()
    found = read_tensor(data, *spread, field)
    if to == "pbrt":
        assert read_container(data)["wavelengths"].tolist() == [450, 550, 650]
        found = found[:, ::-1]
    f = model.eval(*spread)
    # Two readers of the same rules, with doubles between float32 nodes.
    rounding = 1e-6
    ours = lm.Model(tmp_path / "a.bsdf").eval(*spread)
    assert relative_rmse(ours, np.maximum(found, 0)) < rounding
    error = relative_rmse(on_cells(np.maximum(found, 0)), on_cells(f))
    assert error == pytest.approx(told, rel=1e-3)
    assert error < 0.02


def test_larger_tensor_files_are_nearer(tmp_path):
    model = lm.Model("vmf_diffuse", roughness=0.5)
    errors = [model.save(tmp_path / "a.bsdf", size=size) for size in ("small", "medium")]
    assert errors[1] < errors[0] < 0.05


def test_an_anisotropic_tensor_file(spread, tmp_path):
    def brushed(wi, wo):
        h = wi + wo
        h /= np.linalg.norm(h, axis=1, keepdims=True)
        return 0.1 + 0.3 * np.exp(-(h[:, 0] / 0.5) ** 2 - (h[:, 1] / 1.0) ** 2)

    told = lm.Model(brushed).save(tmp_path / "a.bsdf", size="small")
    data = (tmp_path / "a.bsdf").read_bytes()
    assert len(read_container(data)["phi_i"]) == 17
    f = np.repeat(brushed(*spread)[:, None], 3, 1)
    error = relative_rmse(on_cells(np.maximum(read_tensor(data, *spread, "rgb"), 0)), on_cells(f))
    assert error == pytest.approx(told, rel=1e-3) and error < 0.1
    with pytest.raises(ValueError, match="depends on the azimuth"):
        lm.Model(brushed).save(tmp_path / "a.binary", "merl")


def read_merl(data, wi, wo):
    """f by the bin that a pair falls in."""
    sizes = struct.unpack_from("<3i", data)
    assert sizes == (90, 90, 180) and len(data) == 12 + 8 * 3 * 90 * 90 * 180
    table = np.frombuffer(data, "<f8", offset=12).reshape(3, -1)
    h = wi + wo
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    theta_h, phi_h = np.arccos(np.clip(h[:, 2], -1, 1)), np.arctan2(h[:, 1], h[:, 0])
    x = np.cos(-phi_h) * wi[:, 0] - np.sin(-phi_h) * wi[:, 1]
    y = np.sin(-phi_h) * wi[:, 0] + np.cos(-phi_h) * wi[:, 1]
    d = np.stack([np.cos(-theta_h) * x + np.sin(-theta_h) * wi[:, 2], y,
                  -np.sin(-theta_h) * x + np.cos(-theta_h) * wi[:, 2]], -1)
    theta_d = np.arccos(np.clip(d[:, 2], -1, 1))
    phi_d = np.arctan2(d[:, 1], d[:, 0])
    phi_d = np.where(phi_d < 0, phi_d + np.pi, phi_d)
    index = (np.clip((180 * phi_d / np.pi).astype(int), 0, 179)
             + 180 * np.clip((90 * 2 * theta_d / np.pi).astype(int), 0, 89)
             + 16200 * np.clip((90 * np.sqrt(2 * theta_h / np.pi)).astype(int), 0, 89))
    return (table[:, index] * np.array([[1], [1.15], [1.66]]) / 1500).T


def test_a_merl_file_gives_the_model_back(spread, tmp_path):
    model = lm.Model("eon", albedo=[0.9, 0.6, 0.3], roughness=0.8)
    told = model.save(tmp_path / "a.binary", "merl")
    found = read_merl((tmp_path / "a.binary").read_bytes(), *spread)
    f = model.eval(*spread)
    # Pairs at the horizon may fall into bins whose centres lie below it.
    seen = found.min(axis=1) >= 0
    assert seen.mean() > 0.98
    # The error of bins; one that interpolates, as ours does, has less.
    assert relative_rmse(found[seen], f[seen]) < 0.02
    assert told < 0.005
    ours = lm.Model(tmp_path / "a.binary").eval(*spread)
    assert relative_rmse(on_cells(ours), on_cells(f)) == pytest.approx(told, rel=1e-3)


def test_a_measured_material_is_a_truth(run, tmp_path):
    lm.Model("oren_nayar_footnote", albedo=0.8).save(tmp_path / "rough.binary", "merl")
    answer = json.loads(run("compare", "rough.binary", "--model", "oren_nayar_footnote,albedo=0.8",
                            "--model", "lambert,albedo=0.8", "--wi", "30", "--grid", "4x8", "-o",
                            "out", "--json", "-"))
    near, far = (m["lobes"][0] for m in answer["models"])
    # The error of the format, against that of another model.
    assert near["relative_rmse"] < 0.005 and near["order"] == "all"
    assert far["relative_rmse"] > 5 * near["relative_rmse"] and far["verdict"] == "differs"
    assert (tmp_path / "out" / "report.html").exists()
    report = lm.compare(str(tmp_path / "rough.binary"),
                        ["oren_nayar_footnote,albedo=0.8", "lambert,albedo=0.8"], wi=[30],
                        grid=(4, 8))
    assert [m["lobes"] for m in report.answer["models"]] == [m["lobes"] for m in answer["models"]]


def test_measured_materials_are_judged_like_models(tmp_path):
    lm.Model("lambert", albedo=0.5).save(tmp_path / "grey.bsdf", size="small")
    grey = lm.Model(tmp_path / "grey.bsdf")
    report = lm.compare("lambert_sphere_halfspace", [grey, "lambert,albedo=0.5"], wi=[30],
                        grid=(4, 8), walks=5000)
    a, b = (next(r for r in report.table if r["model"] == n and r["order"] == "all")
            for n in ("grey", "lambert"))
    assert a["energy_model"][0] == pytest.approx(b["energy_model"][0], rel=0.02)


# The commands

def test_export_and_import_of_the_command_line(run, tmp_path):
    answer = json.loads(run("export", "vmf_diffuse,roughness=0.5", "--to", "mitsuba", "--size",
                            "small", "-o", "sand.bsdf", "--json", "-"))
    errors = [s["relative_rmse"] for s in answer["sizes"]]
    assert errors == sorted(errors, reverse=True) and errors[-1] < 0.01
    found = json.loads(run("import", "sand.bsdf", "--wi", "60", "--grid", "2x4", "-o", "sand.exr",
                           "--json", "-"))
    energies = np.array([r["reflected"] for r in found["runs"]])
    albedo = lm.Model("vmf_diffuse", roughness=0.5).albedo(lm.directions(60))
    assert np.allclose(energies, albedo, rtol=errors[0])
    lobes = lm.read(tmp_path / "sand.exr")
    assert np.allclose(lobes.energies["reflect", "all"], energies, rtol=1e-5)
    run("show", "sand.exr")


def test_lobes_as_npz_and_csv(run, tmp_path):
    for to in "npz", "csv":
        run("export", "sggx_slab", "--to", to, "--wi", "60", "--grid", "4x8", "--walks", "1000",
            "-o", f"a.{to}")
    lobes = lm.simulate("sggx_slab", wi=[60], grid=(4, 8), walks=1000)
    with np.load(tmp_path / "a.npz") as file:
        assert np.array_equal(file["reflect.all"], lobes["reflect", "all"])
        assert str(file["attribute.lamella.stack_name"]) == "sggx_slab"
    lobes.save(tmp_path / "b.npz")
    lobes.save(tmp_path / "b.csv")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.csv").read_text()
    rows = [r for r in csv.DictReader(io.StringIO((tmp_path / "a.csv").read_text()))
            if (r["side"], r["lobe"]) == ("transmit", "2")]
    assert [float(r["f"]) for r in rows] == lobes["transmit", "2"].ravel().tolist()


# Files that are none

def tensor(fields, version=b"\1\0", count=None):
    header = b"tensor_file\0" + version + struct.pack("<I", len(fields) if count is None else count)
    offset = len(header) + sum(13 + len(n) + 8 * len(s) for n, s, _, _ in fields)
    body = b""
    for name, shape, kind, data in fields:
        header += (struct.pack("<H", len(name)) + name.encode() + struct.pack("<HB", len(shape), kind)
                   + struct.pack("<Q", offset + len(body)) + struct.pack(f"<{len(shape)}Q", *shape))
        body += data
    return header + body


HUGE = 2**63


@pytest.mark.parametrize("name, data", [
    ("empty.binary", b""),
    ("short.binary", struct.pack("<3i", 90, 90, 180)),
    ("other.binary", struct.pack("<3i", 64, 64, 64) + bytes(100)),
    ("huge.binary", struct.pack("<3i", 2**31 - 1, 2**31 - 1, 2**31 - 1)),
    ("empty.bsdf", b""),
    ("magic.bsdf", b"tensor_file\0"),
    ("version.bsdf", tensor([], b"\2\0")),
    ("nothing.bsdf", tensor([])),
    ("many.bsdf", tensor([], count=2**32 - 1)),
    ("truncated.bsdf", tensor([("theta_i", (4,), 10, bytes(16))])[:40]),
    ("huge.bsdf", tensor([("theta_i", (HUGE,), 10, b"")])),
    ("product.bsdf", tensor([("theta_i", (2**32, 2**32, 2**32), 10, b"")])),
    ("zero.bsdf", tensor([("theta_i", (0, HUGE), 10, b"")])),
    ("type.bsdf", tensor([("theta_i", (1,), 77, bytes(4))])),
    ("outside.bsdf", tensor([("theta_i", (1000,), 10, bytes(4))])),
])
def test_a_malformed_file_ends_in_one_line(name, data, tmp_path, refusal):
    (tmp_path / name).write_bytes(data)
    text = refusal("import", name)
    assert name in text and "allowed: " in text and "\n" not in text
    with pytest.raises(ValueError, match=name):
        lm.Model(str(tmp_path / name))


def test_a_merl_file_of_no_numbers(tmp_path, refusal):
    (tmp_path / "nan.binary").write_bytes(struct.pack("<3i", 90, 90, 180)
                                          + np.full(3 * 90 * 90 * 180, np.nan).tobytes())
    assert "nan.binary: found a value of nan in bin 0" in refusal("import", "nan.binary")


def test_a_damaged_file_never_crashes(tmp_path):
    lm.Model("lambert").save(tmp_path / "a.bsdf", size="small")
    whole = (tmp_path / "a.bsdf").read_bytes()
    rng = np.random.default_rng(3)
    refused = 0
    for k in range(300):
        data = bytearray(whole)
        for _ in range(3):
            data[rng.integers(0, 400)] = rng.integers(0, 256)
        (tmp_path / "b.bsdf").write_bytes(bytes(data[:rng.integers(1, len(data))] if k % 3 else data))
        try:
            lm.Model(tmp_path / "b.bsdf").eval([0, 0, 1], [0, 0, 1])
        except ValueError as error:
            assert "b.bsdf" in str(error) and "\n" not in str(error)
            refused += 1
    assert refused > 200


def test_a_file_that_is_too_large_is_refused_unread(tmp_path, refusal):
    with open(tmp_path / "large.bsdf", "wb") as file:
        file.truncate(2**31)
    assert "2147483648 bytes" in refusal("import", "large.bsdf")
