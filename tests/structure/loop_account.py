"""What the compiled loop of walks does: instructions per step of a lane, by kind, for every medium
and instruction set of a release build, from its disassembly (binutils).

    python3 tests/structure/loop_account.py build/release/lamella

With --check: the loop calls nothing but what fills the pool of walks and what counts those that
ended, so that it neither allocates nor looks up a function.
"""

import argparse
import collections
import re
import subprocess
import sys

SETS = 4  # kSets of volume/lanes/lane_pool.h
LANES = {"sse4": 4, "avx2": 8, "avx512": 16}
KERNEL = re.compile(
    r"lamella::isa_(\w+)::walks_of<0, lamella::OneMedium<lamella::isa_\w+::Lane<float>, "
    r"lamella::(\w+)OnLanes(?:, false)?>, lamella::NoScore>"
)
KINDS = [
    ("calls", r"call"),
    ("roots, reciprocals", r"v?(rcp|rsqrt|sqrt|div)\w*ps"),
    ("multiply, add", r"v?(f\w*(add|sub)\d*|mul|add|sub|min|max|round|rndscale|get(exp|mant))\w*ps"),
    ("conversions", r"v?cvt\w+"),
    ("gathers", r"v?gather\w+"),
    ("permutations", r"v?p?(perm|shuf|unpck|compress|expand|align|extract|insert|movzx|hadd)\w*"),
    ("comparisons, masks, blends", r"v?p?(cmp|blend|movmsk|test)\w+|k\w+|v(and|andn|or|xor)ps|(and|andn|or|xor)ps"),
    ("integers", r"v?p(add|sub|xor|ternlog|sl|sr|ro|or|and|mul|min|max)\w*"),
    ("loads, stores, copies", r"v?(mov|p?broadcast|lddqu)\w*"),
]


def instructions(binary, address, size):
    text = subprocess.run(
        ["objdump", "-d", "-C", "--no-show-raw-insn", f"--start-address={address}",
         f"--stop-address={address + size}", binary],
        capture_output=True, text=True, check=True).stdout
    for match in re.finditer(r"^\s*([0-9a-f]+):\s+(\S+)[ \t]*(.*)$", text, re.M):
        yield int(match[1], 16), match[2], match[3]


def reached(edges, start):
    seen, todo = set(), [start]
    while todo:
        for to in edges[todo.pop()]:
            if to not in seen:
                seen.add(to)
                todo.append(to)
    return seen


def loops(code):
    """What is repeated together: instructions that reach each other."""
    place = {address: k for k, (address, _, _) in enumerate(code)}
    after, before = collections.defaultdict(set), collections.defaultdict(set)
    back = set()
    for k, (_, name, operands) in enumerate(code):
        target = re.match(r"([0-9a-f]+)\b", operands) if name.startswith("j") else None
        next_ones = set()
        if target and int(target[1], 16) in place:
            next_ones.add(place[int(target[1], 16)])
        if name not in ("jmp", "ret") and k + 1 < len(code):
            next_ones.add(k + 1)
        for to in next_ones:
            after[k].add(to)
            before[to].add(k)
            if to <= k:
                back.add(k)
    while back:
        k = back.pop()
        body = reached(after, k) & reached(before, k)
        back -= body
        if body:
            yield [code[i] for i in sorted(body)]


def kernels(binary):
    symbols = subprocess.run(["nm", "-SC", binary], capture_output=True, text=True,
                             check=True).stdout
    for line in symbols.splitlines():
        match = KERNEL.search(line)
        if match and match[1] in LANES:
            address, size = (int(x, 16) for x in line.split()[:2])
            found = list(loops(list(instructions(binary, address, size))))
            yield match[1], match[2], max(found, key=len)


def kind_of(name):
    return next((kind for kind, pattern in KINDS if re.fullmatch(pattern, name)), "scalar")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("binary")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    found = sorted(kernels(arguments.binary))
    if len(found) < len(LANES) * 6:
        sys.exit(f"{len(found)} kernels in {arguments.binary}: not a build with all of them")
    if arguments.check:
        for isa, medium, loop in found:
            for _, name, operands in loop:
                if name.startswith("call") and not re.search(r"::(fill|count_all)\(", operands):
                    sys.exit(f"{isa} {medium}: {name} {operands}")
        return
    names = [kind for kind, _ in KINDS if kind != "calls"] + ["scalar"]
    print("| set | medium | instructions per step | per lane | " + " | ".join(names) + " |")
    print("| --- " * (4 + len(names)) + "|")
    for isa, medium, loop in found:
        count = collections.Counter(kind_of(name) for _, name, _ in loop)
        cells = [f"{count[name] / SETS:.0f}" for name in names]
        total = len(loop) / SETS
        print(f"| {isa} | {medium} | {total:.0f} | {total / LANES[isa]:.1f} | " +
              " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
