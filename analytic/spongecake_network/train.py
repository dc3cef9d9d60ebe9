#!/usr/bin/env python3
"""Trains the networks that predict SpongeCake's lobes of multiple scattering.

    lamella dataset --layers 1 -o one-layer && lamella dataset --layers 2 -o two-layers
    python3 train.py one-layer --weights spongecake_1.weights
    python3 train.py two-layers --weights spongecake_2.weights

Needs PyTorch (Debian: python3-torch) and NumPy; the program itself needs neither. One network per
number of layers: a perceptron with three hidden layers of 128. It is evaluated once per colour
channel, so that grey stacks have grey lobes and channels may be exchanged. The closed form of
single scattering stands in `lobes` as tensors, and the loss compares it with the truth on the cells
of the data set: --loss mae is the mean absolute error of f, as in the paper; --loss relative is the
mean over the stacks of the root mean square error over the truth's root mean square.

The best network so far is written at every validation, which is on the last tenth of the stacks.
Beside the weights, NAME.json says how they were made, and NAME.csv has the curves. The same data,
options, threads and release of PyTorch give the same weights.
"""
import argparse
import hashlib
import json
import math
import pathlib
import struct
import sys
import time
import zlib

try:
    import numpy
    import torch
except ImportError as error:
    sys.exit(f"train.py: found no {error.name}; allowed: a Python that has NumPy and PyTorch "
             "(Debian: /usr/bin/python3 with python3-torch)")

HIDDEN = 128
ROUGHNESS, DEPTH = (0.05, 1.0), (0.02, 10.0)  # analytic/spongecake_network/spongecake_ranges.h
LEAST_ROUGHNESS, MOST_ROUGHNESS, LEAST_F0 = 0.02, 0.999, 0.01
CELL_POINTS = 2  # per axis of a cell, in validations
MOST_CHECKED = 200  # stacks of a validation
VALIDATED = ("relative_rmse_mean", "relative_rmse_median", "relative_rmse_90_percent",
             "mean_absolute_error")


def layer_inputs(layers):
    """Numbers that the network reads per stack and channel."""
    return 8 * layers + (2 if layers == 2 else 0)


def features(p):
    """p: [n, L, 12] parameters as `lamella dataset` writes them; returns [n, 3, inputs]."""
    n, layers, _ = p.shape
    roughness, albedo, depth, f0 = p[..., 0], p[..., 1:4], p[..., 4], p[..., 5:8]
    kind, axis = p[..., 8], p[..., 9:12]
    shared = [
        2 * (roughness - ROUGHNESS[0]) / (ROUGHNESS[1] - ROUGHNESS[0]) - 1,
        2 * torch.log(depth / DEPTH[0]) / math.log(DEPTH[1] / DEPTH[0]) - 1,
        2 * kind - 1,
        2 * axis[..., 2] ** 2 - 1,
    ]
    rows = []
    for k in range(layers):
        rows += [x[:, k : k + 1].expand(n, 3) for x in shared]
        for color in (albedo, f0):
            rows.append(2 * color[:, k] - 1)
        for color in (albedo, f0):
            rows.append(2 * color[:, k].mean(-1, keepdim=True).expand(n, 3) - 1)
    if layers == 2:
        dot = (axis[:, 0] * axis[:, 1]).sum(-1, keepdim=True)
        both = axis[:, 0, 2:3] * axis[:, 1, 2:3]
        rows += [(2 * dot**2 - 1).expand(n, 3), (both * dot).expand(n, 3)]
    return torch.stack(rows, -1)


class Perceptron(torch.nn.Module):
    def __init__(self, layers):
        super().__init__()
        sizes = [layer_inputs(layers), HIDDEN, HIDDEN, HIDDEN, 4 * layers + 2]
        self.steps = torch.nn.ModuleList(
            torch.nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:])
        )
        torch.nn.init.normal_(self.steps[-1].weight, std=0.01)
        # Begins with a second lobe that is rougher and darker than the first.
        torch.nn.init.zeros_(self.steps[-1].bias)
        with torch.no_grad():
            for k in range(layers):
                self.steps[-1].bias[4 * k : 4 * k + 3] = torch.tensor([0.5, 0.0, -1.5])

    def forward(self, x):
        for step in self.steps[:-1]:
            x = torch.nn.functional.silu(step(x))
        return self.steps[-1](x)


def bounded(x):
    """The identity near 0, within -4 and 4."""
    return 4 * torch.tanh(x / 4)


def logit(x):
    return torch.log(x / (1 - x))


def decode(p, out):
    """The lobes' parameters from the network's numbers, [n, 3, 4 L + 2]."""
    layers = p.shape[1]
    own = out[..., : 4 * layers].reshape(-1, 3, layers, 4)
    roughness, depth = p[..., 0], p[..., 4]
    span = MOST_ROUGHNESS - LEAST_ROUGHNESS
    share = ((roughness - LEAST_ROUGHNESS) / span).clamp(0.01, 0.99)
    f0 = p[..., 5:8].clamp(LEAST_F0, 1 - LEAST_F0)
    return {
        "roughness": LEAST_ROUGHNESS
        + span * torch.sigmoid(logit(share) + own[..., 0].mean(1)),
        "depth": depth * torch.exp(bounded(own[..., 1].mean(1))),
        "albedo": p[..., 1:4] * torch.exp(bounded(own[..., 2]).transpose(1, 2)),
        "f0": torch.sigmoid(logit(f0) + own[..., 3].transpose(1, 2)),
        "constant": torch.nn.functional.softplus(out[..., 4 * layers :] - 4),  # [n, 3, side]
    }


def single_scattering(lobe, kind, axis, wi, wo):
    """The second lobe and the constant one at directions wi, wo [n, m, 3]; [n, m, 3 channels].

    kind [n, L], axis [n, L, 3]. As phase/stack/single_scattering.cpp, from above."""
    layers = kind.shape[1]
    mi, mo = wi[..., 2], wo[..., 2].abs()
    reflects = wo[..., 2] > 0
    h = wi + wo
    h = h / h.norm(dim=-1, keepdim=True).clamp_min(1e-6)
    schlick = (1 - (wi * h).sum(-1).clamp(0, 1)) ** 5
    xi, xo, density = [], [], []
    for k in range(layers):
        fiber = kind[:, k, None] > 0.5
        a2 = lobe["roughness"][:, k, None] ** 2
        n = axis[:, k, None, :]

        def area(w):
            c2 = (w * n).sum(-1) ** 2
            return torch.where(fiber, 1 - (1 - a2) * c2, a2 + (1 - a2) * c2).clamp_min(1e-8).sqrt()

        c2 = (h * n).sum(-1) ** 2
        q = torch.where(fiber, 1 - c2 + c2 / a2, (1 - c2) / a2 + c2)
        root = torch.where(fiber, a2.sqrt(), a2)
        density.append(1 / (math.pi * root * q**2))
        depth = lobe["depth"][:, k, None]
        xi.append(depth * area(wi) / mi)
        xo.append(depth * area(wo) / mo)
    total = 0
    for k in range(layers):
        above_i = sum(xi[:k]) if k else torch.zeros_like(mi)
        above_o = sum(xo[:k]) if k else torch.zeros_like(mi)
        below_o = sum(xo[k + 1 :]) if k + 1 < layers else torch.zeros_like(mi)
        outside = above_i + torch.where(reflects, above_o, below_o)
        x = torch.where(reflects, xi[k] + xo[k], (xi[k] - xo[k]).abs()).clamp_min(1e-6)
        least = torch.where(reflects, torch.zeros_like(x), torch.minimum(xi[k], xo[k]))
        transport = lobe["depth"][:, k, None] * -torch.expm1(-x) / x * torch.exp(-least - outside)
        geometry = density[k] / (4 * mi * mo) * transport
        f0, albedo = lobe["f0"][:, None, k], lobe["albedo"][:, None, k]
        fresnel = f0 + (1 - f0) * schlick[..., None]
        total = total + geometry[..., None] * albedo * fresnel
    side = torch.where(
        reflects[..., None], lobe["constant"][:, None, :, 0], lobe["constant"][:, None, :, 1]
    )
    return total + side / math.pi


class Data:
    """The blocks of a folder that `lamella dataset` wrote, in order."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.settings = json.loads((self.folder / "settings.json").read_text())
        files = sorted(self.folder.glob("block_*.npz"))
        if not files:
            sys.exit(f"{folder}: found no block_*.npz; allowed: a folder of lamella dataset")
        checksums = hashlib.sha256()
        parts = []
        for file in files:
            checksums.update(hashlib.sha256(file.read_bytes()).hexdigest().encode())
            with numpy.load(file) as block:
                parts.append({name: block[name] for name in block.files})
        self.checksum = checksums.hexdigest()
        whole = {
            name: torch.from_numpy(numpy.concatenate([part[name] for part in parts]))
            for name in ("parameters", "w_i", "f", "noise")
        }
        self.parameters, self.wi, self.noise = whole["parameters"], whole["w_i"], whole["noise"]
        f = whole["f"]
        self.rows, self.columns = f.shape[3], f.shape[4]
        self.f = f.reshape(f.shape[0], -1, 3)  # [n, direction * side * cell, 3]
        self.count = f.shape[0]
        self.scale = (self.f**2).mean((1, 2)).sqrt().clamp_min(1e-9)
        self.mean = self.f.mean((1, 2)).clamp_min(1e-9)

    def directions(self, stacks, cells, jitter, p):
        """w_i, w_o [n, m * points, 3] of cells [n, m]: stratified points within each."""
        per_side = self.rows * self.columns
        direction, rest = cells // (2 * per_side), cells % (2 * per_side)
        side, cell = rest // per_side, rest % per_side
        row, column = cell // self.columns, cell % self.columns
        wi = torch.gather(self.wi[stacks], 1, direction[..., None].expand(-1, -1, 3))
        u = (torch.arange(p).repeat_interleave(p) + jitter[0]) / p
        v = (torch.arange(p).repeat(p) + jitter[1]) / p
        mu = (1 - (row[..., None] + u) / self.rows).clamp_min(1e-6).sqrt()
        phi = torch.atan2(wi[..., 1], wi[..., 0])[..., None] + 2 * math.pi * (
            column[..., None] + v
        ) / self.columns
        s = (1 - mu**2).clamp_min(0).sqrt()
        z = torch.where(side[..., None] == 0, mu, -mu)
        wo = torch.stack([s * phi.cos(), s * phi.sin(), z], -1)
        wi = wi[:, :, None].expand_as(wo)
        n = len(stacks)
        return wi.reshape(n, -1, 3), wo.reshape(n, -1, 3)


def predicted(data, net, stacks, cells, jitter, points, channels=None):
    p = data.parameters[stacks]
    f = torch.gather(data.f[stacks], 1, cells[..., None].expand(-1, -1, 3))
    if channels is not None:
        p = p.clone()
        p[..., 1:4], p[..., 5:8] = p[..., 1 + channels], p[..., 5 + channels]
        f = f[..., channels]
    lobe = decode(p, net(features(p)))
    wi, wo = data.directions(stacks, cells, jitter, points)
    model = single_scattering(lobe, p[..., 8], p[..., 9:12], wi, wo)
    model = model.reshape(f.shape[0], f.shape[1], points**2, 3).mean(2)
    return model, f


def validate(data, net, stacks):
    """Relative RMSE per stack, the truth's noise taken off, and the mean absolute error."""
    relative, absolute = [], 0.0
    middle = (torch.full((CELL_POINTS**2,), 0.5),) * 2
    with torch.no_grad():
        for part in stacks.split(16):
            cells = torch.arange(data.f.shape[1]).expand(len(part), -1)
            model, f = predicted(data, net, part, cells, middle, CELL_POINTS)
            share = ((model - f) ** 2).mean((1, 2)) / data.scale[part] ** 2
            noise = data.noise[part] ** 2
            # scale^2 holds the noise's variance too.
            relative.append(((share - noise).clamp_min(0) / (1 - noise).clamp_min(0.05)).sqrt())
            absolute += float((model - f).abs().mean((1, 2)).sum())
    relative = torch.cat(relative)
    return dict(zip(VALIDATED, (float(relative.mean()), float(relative.median()),
                                float(relative.quantile(0.9)), absolute / len(stacks))))


def save(net, layers, path):
    """"LMSC", version, layers, per step rows, columns, weights, biases; CRC-32. Little-endian."""
    out = b"LMSC" + struct.pack("<II", 1, layers)
    for step in net.steps:
        w = step.weight.detach().numpy().astype("<f4")
        out += struct.pack("<II", *w.shape) + w.tobytes()
        out += step.bias.detach().numpy().astype("<f4").tobytes()
    out += struct.pack("<I", zlib.crc32(out))
    pathlib.Path(path).write_bytes(out)
    return out


def write(given, data, net, curve, training, validation):
    """The weights of now, how they were made, and the curves so far."""
    layers = data.parameters.shape[1]
    weights = save(net, layers, given.weights)
    name = pathlib.Path(given.weights)
    # What this network predicts, for the test of the program's own.
    some = validation[:3]
    with torch.no_grad():
        lobes = decode(data.parameters[some], net(features(data.parameters[some])))
    report = {
        "command": "train.py " + " ".join(
            f"--{k} {v}" for k, v in vars(given).items() if k not in ("folder", "weights")),
        "data": {**data.settings, "there": data.count, "sha256": data.checksum,
                 "noise_per_cell_mean": float(data.noise.mean())},
        "training_stacks": len(training), "held_out_stacks": len(validation),
        "validated_stacks": min(len(validation), MOST_CHECKED),
        "steps": curve[-1]["steps"], "seconds": curve[-1]["seconds"],
        "validation": {k: curve[-1][k] for k in VALIDATED},
        # Of as many stacks that were trained on.
        "training_relative_rmse_mean": curve[-1]["training_rmse_mean"],
        "weights_sha256": hashlib.sha256(weights).hexdigest(),
        "examples": [
            {"parameters": data.parameters[s].tolist(),
             **{key: lobes[key][k].tolist()
                for key in ("roughness", "depth", "albedo", "f0", "constant")}}
            for k, s in enumerate(some.tolist())
        ],
    }
    name.with_suffix(".json").write_text(json.dumps(report, indent=1) + "\n")


def write_curve(given, curve):
    heads = list(curve[0])
    lines = [",".join(heads)] + [",".join(f"{r[h]:.6g}" for h in heads) for r in curve]
    pathlib.Path(given.weights).with_suffix(".csv").write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", help="of lamella dataset")
    parser.add_argument("--weights", required=True, help="file to write")
    parser.add_argument("--steps", type=int, default=50000, help="of training")
    parser.add_argument("--loss", choices=["mae", "relative"], default="relative")
    parser.add_argument("--batch", type=int, default=32, help="stacks per step")
    parser.add_argument("--cells", type=int, default=128, help="cells per stack and step")
    parser.add_argument("--points", type=int, default=2, help="per axis of a cell, at random")
    parser.add_argument("--rate", type=float, default=2e-3, help="of Adam, at the beginning")
    parser.add_argument("--checks", type=int, default=12, help="validations in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=1)
    given = parser.parse_args()
    for name in ("steps", "batch", "cells", "points", "checks", "threads"):
        if vars(given)[name] < 1:
            sys.exit(f"train.py: --{name}: found {vars(given)[name]}; allowed: 1 or more")
    torch.manual_seed(given.seed)
    torch.set_num_threads(given.threads)
    data = Data(given.folder)
    layers = data.parameters.shape[1]
    if layers > 2:
        sys.exit(f"{given.folder}: found {layers} layers; allowed: 1 or 2")
    held = max(1, data.count // 10)
    training = torch.arange(data.count - held)
    validation = torch.arange(data.count - held, data.count)
    net = Perceptron(layers)
    adam = torch.optim.Adam(net.parameters(), lr=given.rate)
    curve, best = [], math.inf
    start, step, sums, since = time.time(), 0, 0.0, 0
    share = 0.0
    while share < 1:
        order = training[torch.randperm(len(training))]
        for stacks in order.split(given.batch):
            share = (step + 1) / given.steps
            for group in adam.param_groups:
                group["lr"] = given.rate * (0.005 + 0.995 * 0.5 * (1 + math.cos(math.pi * share)))
            cells = torch.randint(data.f.shape[1], (len(stacks), given.cells))
            jitter = torch.rand(2, len(stacks), given.cells, given.points**2)
            model, f = predicted(data, net, stacks, cells, jitter, given.points, torch.randperm(3))
            if given.loss == "mae":
                loss = (model - f).abs().mean()
            else:
                square = ((model - f) ** 2).mean((1, 2))
                loss = (square / data.scale[stacks] ** 2 + 1e-6).sqrt().mean()
            if not torch.isfinite(loss):
                sys.exit(f"step {step}: the loss is not finite")
            adam.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
            adam.step()
            sums, since, step = sums + float(loss.detach()), since + 1, step + 1
            if share * given.checks >= len(curve) + 1:
                now = validate(data, net, validation[:MOST_CHECKED])
                known = validate(data, net, training[:MOST_CHECKED])
                row = {"seconds": round(time.time() - start), "steps": step,
                       "loss": sums / since, **now,
                       "training_rmse_mean": known["relative_rmse_mean"]}
                sums, since = 0.0, 0
                curve.append(row)
                print(json.dumps(row), flush=True)
                key = "mean_absolute_error" if given.loss == "mae" else "relative_rmse_mean"
                if now[key] < best:
                    best = now[key]
                    write(given, data, net, curve, training, validation)
                write_curve(given, curve)
            if share == 1:
                break


if __name__ == "__main__":
    main()
