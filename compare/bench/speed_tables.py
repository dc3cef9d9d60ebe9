"""Writes the figures of speed into the texts: `speed_tables.py SOURCE [--check]`.

SOURCE/compare/bench/release holds what `make speed` measured, a file of `lamella bench --json` per
instruction set, and about.txt, which says what else the machine did. In the Markdown files of the
tree a block

    <!-- speed: NAME -->
    ...
    <!-- /speed -->

has what the function NAME below makes of those files. With --check nothing is written: blocks that
do not agree with the files are printed, and the exit status is 1.
"""

import json
import re
import statistics
import sys
from pathlib import Path

SETS = ["scalar", "avx2", "avx512"]
SET_NAMES = {"scalar": "scalar double", "avx2": "AVX2", "avx512": "AVX-512"}
BLOCK = re.compile(r"(<!-- speed: (\w+) -->\n)(.*?)(<!-- /speed -->)", re.DOTALL)
WIDTH = 120

WALKS = [("lambert_sphere_halfspace", "Lambert sphere, half space (`lambert_sphere_halfspace`)"),
         ("sggx_slab", "SGGX mirror flakes, slab (`sggx_slab`)"),
         ("sggx_lambert", "SGGX Lambertian flakes, slab"),
         ("vmf_halfspace", "vMF Lambertian flakes, half space (`vmf_halfspace`)"),
         ("vmf_mirror", "vMF mirror flakes, slab"),
         ("hg_slab", "Henyey-Greenstein, slab (`hg_slab`)")]
TASKS = [("walk", "walk"), ("walk+cells", "with cells"), ("nee1", "next-event to 1 direction"),
         ("nee16", "next-event to 16 directions"), ("nee64", "next-event to 64 directions"),
         ("walk+cells/engine's generator", "with cells, against the engine's generator")]
SAMPLED = ["lambert_sphere_halfspace", "sggx_slab", "vmf_halfspace", "spongecake_two_layer"]
GROWN = ["lambert_sphere_halfspace", "sggx_slab", "vmf_halfspace", "vmf_sand", "spongecake_two_layer"]
SOLVED = [("lambert_sphere_halfspace", "Lambert-sphere half space"),
          ("lambert_sphere_slab", "Lambert-sphere slab, depth 2"),
          ("hg_slab", "Henyey-Greenstein g = 0.7, depth 4"),
          ("hg_0.9_slab", "Henyey-Greenstein g = 0.9, depth 4"),
          ("sggx_lambert_slab", "SGGX 0.5 Lambertian, depth 2"),
          ("sggx_lambert_0.05_slab", "SGGX 0.05 Lambertian, depth 2"),
          ("vmf_halfspace", "vMF r = 0.5 Lambertian, half space"),
          ("vmf_lambert_0.01_slab", "vMF r = 0.01 Lambertian, depth 2"),
          ("sggx_slab", "SGGX 0.5 mirror, depth 2"),
          ("sggx_mirror_0.3_slab", "SGGX 0.3 mirror, depth 2"),
          ("vmf_mirror_0.3_halfspace", "vMF r = 0.3 mirror, half space"),
          ("sggx_mirror_0.05_slab", "SGGX 0.05 mirror, depth 2")]
MODELS = ["fon", "eon_approx", "eon", "oren_nayar", "oren_nayar_full", "vmf_diffuse", "lambert_sphere",
          "lambert_sphere_fast", "hapke_lambert_sphere"]


class Release:
    """What `make speed` measured: rows by instruction set and name."""

    def __init__(self, folder):
        self.answers = {name: json.loads((folder / f"{name}.json").read_text()) for name in SETS}
        self.about = (folder / "about.txt").read_text().strip()
        self.rows = {name: {row["what"]: row for row in answer["rows"]}
                     for name, answer in self.answers.items()}

    def row(self, what, isa="avx512"):
        try:
            return self.rows[isa][what]
        except KeyError:
            sys.exit(f"{isa}.json has no row {what}: measure anew with make speed")

    def get(self, what, key, isa="avx512"):
        return self.row(what, isa).get(key)

    def ratio(self, what, isa="avx512"):
        return self.row(what, isa)["ratio_to_baseline"]


def digits(x, count=2):
    """A number with `count` significant digits, without an exponent where that is short."""
    if x is None:
        return ""
    if x == 0:
        return "0"
    if x < 1e-4 or x >= 1e6:
        return f"{x:.{count - 1}e}".replace("e-0", "e-").replace("e+0", "e")
    rounded = float(f"{x:.{count - 1}e}")
    size = len(str(int(rounded))) if rounded >= 1 else 0
    if rounded >= 1:
        return f"{rounded:.{max(0, count - size)}f}"
    return f"{rounded:.12f}".rstrip("0")


def between(values, count=2):
    low, high = digits(min(values), count), digits(max(values), count)
    return low if low == high else f"{low} to {high}"


def error_text(x):
    return f"{x:.1e}".replace("e-0", "e-")


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines).replace("|  |", "| |").replace("|  |", "| |")


def paragraph(text, first="", rest=""):
    """Text in lines of the width."""
    lines, line = [], first
    for word in text.split():
        if len(line) + len(word) + (line not in (first, rest)) > WIDTH:
            lines.append(line)
            line = rest
        line += (" " if line not in (first, rest) else "") + word
    return "\n".join([*lines, line]) + "\n"


def item(text):
    return paragraph(text, "- ", "  ")


def measured(release):
    a = release.answers["avx512"]
    rounds = "one round" if a["rounds"] == 1 else f"the medians of {a['rounds']} rounds"
    return paragraph(f"The figures are from `make speed` with lamella {a['version']} on a 2-core virtual machine, "
                     f"{rounds}, seed {a['seed']}, {release.about}; `compare/bench/release` has all of them.")


def walks(release):
    head = ["medium (built-in stack), task"]
    for isa in SETS:
        head += [SET_NAMES[isa], "ratio"]
    rows = []
    for stack, name in WALKS:
        for task, words in TASKS:
            line = [f"{name}, {words}" if task == "walk" else words]
            for isa in SETS:
                row = release.row(f"{stack}/{task}", isa)
                line += [digits(row["collisions_per_second_per_core"] / 1e6, 3), f"{row['ratio_to_baseline']:.2f}"]
            rows.append(line)
    return table(head, rows)


def directions(release):
    """Next-event estimation per direction, and what 16 and 64 of them lose against one."""
    rows = []
    for stack, name in WALKS:
        line = [name]
        for isa in ("avx2", "avx512"):
            rates = [release.get(f"{stack}/nee{n}", "directions_per_second", isa) / 1e6 for n in (1, 16, 64)]
            line += [digits(rates[0], 3), digits(rates[1], 3), digits(rates[2], 3)]
        rows.append(line)
    return table(["stack", "AVX2: 1", "16", "64", "AVX-512: 1", "16", "64"], rows)


def coats(release):
    rows = []
    for stack, name in (("ggx_coat_lambert_sphere_halfspace", "half space of Lambert spheres"),
                        ("ggx_coat_lambert", "Lambert's law")):
        row = release.row(f"{stack}/walk+cells")
        rows.append([name, digits(row["events_per_walk"]), digits(row["interfaces_per_walk"]),
                     *(digits(release.ratio(f"{stack}/walk+cells", isa), 3) for isa in SETS)])
    return table(["below the coat", "events per walk", "meetings with the coat", *SET_NAMES.values()], rows)


def tilted(release):
    rows = []
    for flake, name in (("mirror", "mirrors"), ("lambert", "Lambertian")):
        for alpha in ("0.005", "0.05", "0.2", "0.5"):
            what = f"tilted vMF {flake} {alpha}/walk+cells"
            cells = [(digits(release.get(what, "ns_per_walk", isa), 3), digits(release.ratio(what, isa), 3))
                     for isa in ("avx2", "avx512")]
            rows.append([f"{name}, alpha = {alpha}", *cells[0], *cells[1]])
    return table(["flakes", "AVX2: ns per walk", "ratio", "AVX-512: ns per walk", "ratio"], rows)


def engine(release):
    """What the list below the table of walks says."""
    occupied = [release.get(f"{stack}/walk+cells", "lane_occupancy") for stack, _ in WALKS]
    nulls = release.get("vmf_halfspace/walk+cells", "null_collisions")
    kept = [release.ratio(f"{s}/samples") for s in ("lambert_sphere_halfspace", "sggx_slab", "vmf_halfspace", "hg_slab")]
    mixed = [release.ratio(f"mixed/{pair}") for pair in
             ("lambert_sphere+henyey_greenstein", "lambert_sphere+sggx", "lambert_sphere+vmf_flake", "sggx+vmf_flake")]
    four = release.ratio("mixed/lambert_sphere+henyey_greenstein+sggx+vmf_flake")
    plan = [release.ratio(f"lambert_sphere_halfspace/plan/{e}") for e in ("analog", "next-event")]

    def exponents(what, sizes):
        return between([release.get(f"growth of walks/{what} {n}", "exponent") for n in sizes], 1)

    return "".join(map(item, [
        f"Walks that are kept one by one (`--only samples`, in memory, one thread, AVX-512) go at {between(kept)} of the "
        "speed of the same walks counted in cells. A row of the file has 33 bytes, which are written twice.",
        f"Lanes are {between([100 * x for x in occupied], 3)} % occupied (fewest where a run is short)" + (
            f"; {100 * nulls:.0f} % of the lanes on vMF flakes are at null collisions (refused normals)." if nulls
            else "."),
        "The plan leaves colour, layers and asymmetry out of the walks in `lambert_sphere_halfspace`: the same scalar "
        f"walks are {plan[0]:.2f} (analog) and {plan[1]:.2f} times (next-event) as fast as by the general plan.",
        f"By the clock two threads are {release.ratio('lambert_sphere_halfspace/threads'):.2f} times as fast as one.",
        f"Stacks of two media walk at {between(mixed)} of the mean speed of stacks of each medium alone, stacks of four "
        f"at {digits(four)} (`--only mixed`).",
        "The cost of a walk grows (`--only growth`) with the number of layers to the power "
        f"{exponents('layers', (4, 16))} up to 16 and {exponents('layers', (64,))} beyond, with the optical depth to the "
        f"power {exponents('optical depth', (8, 64))} up to 64, and with the number of directions to the power "
        f"{exponents('directions', (4, 16, 64))}."]))


def absorption(release):
    sizes = ["0.1", "0.01", "0.001", "0.0001", "1e-05", "1e-06"]
    rows = [release.row(f"growth of cost/absorption {s}") for s in sizes]
    return table(["absorption 1 - albedo", *(digits(float(s), 1) for s in sizes)],
                 [["seconds to 1 %", *(digits(r["seconds"]) for r in rows)],
                  ["times as fast as walks that are not thinned, to the same 1048576 events",
                   *(digits(r["ratio_to_baseline"]) for r in rows)]])


def accuracy(release):
    rows = []
    for stack, lobes in (("lambert_sphere_halfspace", ("reflect.all", "reflect.order3")),
                         ("spongecake_two_layer", ("reflect.all", "transmit.all")),
                         ("vmf_sand", ("reflect.all", "reflect.order3")), ("sggx_slab", ("reflect.all",)),
                         ("hg_slab", ("reflect.all",))):
        solver = release.row(f"{stack}/0.01%/deterministic/all lobes")
        for k, lobe in enumerate(lobes):
            rows.append([f"`{stack}`" if k == 0 else "", lobe.replace(".", ", ").replace("order", "order "),
                         *(digits(release.get(f"{stack}/1%/{e}/{lobe}", "seconds")) for e in ("analog", "next-event")),
                         (digits(solver["seconds"]) + f" ({solver['error']:.0e})".replace("e-0", "e-")) if k == 0 else ""])
    return table(["stack", "lobe", "analog", "next-event", "solver (error)"], rows)


def sampling(release):
    rows = []
    for stack in SAMPLED:
        for what, words in (("next-event/cells", "cells, next-event"), ("points", "f at points, next-event"),
                            ("next-event/energy", "energy, next-event"),
                            ("analog/cells", "cells, counted"), ("energy", "energy, counted")):
            line, slopes = [f"`{stack}`", words], []
            for order in ("order1", "order2", "order3", "order4plus", "all"):
                row = release.row(f"sampling/{stack}/{what}/{order}")
                at = row["walks_of"].index(1e6)
                variance = row["variance_ratios"][at]
                line.append(f"{digits(variance, 3)} ({digits(variance * row['speed_ratios'][at], 3)})")
                if order in ("order2", "all"):
                    slopes.append(f"{row['slope']:.2f}")
            rows.append([*line, ", ".join(slopes)])
    return table(["stack", "what", "order 1", "order 2", "order 3", "order 4+", "all", "slopes"], rows)


def sampling_growth(release):
    columns = (("next-event/cells/order2", "cells, next-event: order 2"), ("next-event/cells/order3", "order 3"),
               ("next-event/cells/all", "all"), ("next-event/energy/order2", "energy, next-event: order 2"),
               ("energy/order2", "counted: order 2"), ("energy/all", "all"))
    return table(["stack", *(words for _, words in columns)],
                 [[f"`{stack}`", *(", ".join(digits(ratio, 3) for ratio in
                                             release.row(f"sampling/{stack}/{what}")["variance_ratios"])
                                   for what, _ in columns)] for stack in GROWN])


def order_one(release):
    def cell(stack, what):
        row = release.row(f"order1/{stack}/{what}")
        return f"{digits(row['variance_ratio'], 3)} ({digits(row['ratio_to_random'], 3)})"

    walks_of = release.get("order1/sggx_slab/analog/cells", "walks")
    return table(["stack", "cells, counted", "cells, next-event", "energy, counted"],
                 [[f"`{s}`", cell(s, "analog/cells"), cell(s, "next-event/cells"), cell(s, "analog/energy")]
                  for s in SAMPLED]) + "\n" + paragraph(f"Both with {walks_of} walks.")


def digits_of_solver(release):
    rows = []
    for stack, name in SOLVED:
        line = [name]
        for tolerance in ("1e-06", "1e-08"):
            r = release.row(f"{stack}/solve/{tolerance}")
            error = error_text(r["error"])
            told = "" if r["reached"] else ", not reached"
            line.append(f"{error}: {r['nodes']}, {r['modes']}, {digits(r['seconds'])} s{told}")
        rows.append(line)
    return table(["stack", "1e-6", "1e-8"], rows)


def solver(release):
    cells = [release.row(f"lambert_sphere_halfspace/cells 32x32, 8 directions/{t}") for t in ("1e-06", "1e-08")]
    pairs = [release.row(f"lambert_sphere_halfspace/1e6 pairs/{t}") for t in ("1e-04", "1e-06")]
    threads = release.row("lambert_sphere_halfspace/cells, threads/1e-08")
    nodes = [release.row(f"growth/nodes {n}") for n in (16, 32, 64)]
    return "".join(map(item, [
        "All cells of a 32 x 32 grid for 8 directions of the Lambert-sphere half space take "
        f"{digits(cells[0]['seconds'])} s to {error_text(cells[0]['error'])} and {digits(cells[1]['seconds'])} s to "
        f"{error_text(cells[1]['error'])}, on one core.",
        f"f at 1e6 scattered pairs of the same stack takes {digits(pairs[0]['seconds'])} s to 1e-4 and "
        f"{digits(pairs[1]['seconds'])} s to 1e-6 on one core, with tables of {pairs[0]['rows']} and {pairs[1]['rows']} "
        f"cosines, {digits(pairs[0]['ratio_to_baseline'])} and {digits(pairs[1]['ratio_to_baseline'])} times as fast as "
        "pair by pair.",
        f"Two threads find the cells of such grids to 1e-8 {threads['ratio_to_baseline']:.2f} times as fast as one, by the "
        "clock.",
        "Nodes: 16, 32, 64 nodes at 8 modes take " + ", ".join(digits(r["seconds"]) for r in nodes) + " s: exponents "
        f"{nodes[1]['exponent']:.1f} and {nodes[2]['exponent']:.1f} on the way to 3."]))


def grids(release):
    rows = []
    for grid in ("sparse", "dense"):
        names = [f"grid_{grid}/{task}" for task in ("walk", "walk, per block", "fixed steps")]
        rows.append([grid, digits(release.get(names[0], "collisions_per_second_per_core") / 1e6) + " M",
                     *(digits(release.ratio(name)) for name in names)])
    return table(["grid", "collisions a second", "one majorant", "one majorant per block", "fixed steps of half a voxel"],
                 rows)


def grains(release):
    trace, shadow, build = (release.row(f"sphere_bed_dilute/{what}") for what in ("trace", "shadow", "build"))
    return paragraph(
        f"Explicit grains (`--only grains`): {digits(trace['rays_per_second'] / 1e6)} million rays a second find the "
        f"nearest of {trace['spheres']} spheres ({digits(trace['ratio_to_baseline'], 3)} times as fast as trying all of "
        f"them), and {digits(shadow['rays_per_second'] / 1e6)} million shadow rays a second; a scene of "
        f"{digits(build['spheres'])} spheres is built in {digits(build['seconds'])} s and takes "
        f"{build['bytes'] / 1048576:.0f} MiB.")


def models(release):
    rows = []
    for model in MODELS:
        single, batch = (release.row(f"{kind}/{model}", "avx2") for kind in ("eval", "eval_batch"))
        name = f"`{model}`" + (f" (`{single['error_on']}`)" if single.get("error_on") else "")
        textbook = single.get("ns_textbook")
        rows.append([name, f"{single['ns_per_eval']:.1f}", f"{batch['ns_per_eval']:.1f}",
                     f"{textbook:.1f}" if textbook else "",
                     f"{textbook / batch['ns_per_eval']:.2f}" if textbook else "",
                     error_text(single["error"]) if single.get("error") else ""])
    return table(["model", "single", "batch", "textbook", "ratio", "error"], rows)


def startup(release):
    rows = [r for r in release.answers["avx512"]["rows"] if r["kind"] == "startup"]
    return table(["command", "milliseconds, median", "fewest", "of the processor", "memory [MB]"],
                 [[f"`{r['what'].removeprefix('startup/')}`", digits(1e3 * r["seconds"]),
                   digits(1e3 * r["least_seconds"]), digits(1e3 * r["processor_seconds"]),
                   digits(1e-6 * r["peak_bytes"])] for r in rows])


BLOCKS = {f.__name__: f for f in (measured, walks, directions, coats, tilted, engine, absorption, accuracy, sampling, sampling_growth,
                                  order_one, digits_of_solver, solver, grids, grains, models, startup)}


def main(source, check):
    release = Release(source / "compare/bench/release")
    wrong, used = [], set()
    for path in sorted(source.rglob("*.md")):
        if any(part.startswith((".", "build")) or part == "node_modules" for part in path.relative_to(source).parts):
            continue
        text = path.read_text()

        def filled(match):
            name = match[2]
            if name not in BLOCKS:
                sys.exit(f"{path}: no block is called {name}; allowed: {', '.join(BLOCKS)}")
            used.add(name)
            return match[1] + BLOCKS[name](release) + match[4]

        new = BLOCK.sub(filled, text)
        if new != text:
            wrong.append(str(path.relative_to(source)))
            if not check:
                path.write_text(new)
    for name in BLOCKS.keys() - used:
        sys.exit(f"no text has the block {name}")
    if check and wrong:
        sys.exit(f"figures of speed that are not those of compare/bench/release: {', '.join(wrong)}; "
                 "compare/bench/speed_tables.py writes them")
    print(f"{len(used)} blocks" + (" agree" if check else f", {len(wrong)} texts changed"))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), "--check" in sys.argv[2:])
