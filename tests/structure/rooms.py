"""Holds the sources against the table of rooms: `rooms.py SOURCE TABLE`.

TABLE has a line per inner room, "room/name: room/name ...": what its files may include besides one
another; configuring writes it from the CMakeLists.txt of the rooms. A file in no room, an include
against the table, a line of the table that no include needs, a circle of files, a file name that
stands twice, or a library outside its one file is printed, and the exit status is 1.
"""

import re
import sys
from collections import defaultdict
from pathlib import Path

ROOMS = ["phase", "volume", "analytic", "compare"]
# What a room may include of the others, whatever the table says.
DIRECTION = {"phase": [], "volume": ["phase"], "analytic": ["phase"],
             "compare": ["phase", "volume", "analytic"]}
# Libraries that few files may include: those whose path begins so.
LIBRARIES = {"embree": ("volume/grains/grain_scene", "volume/mesh/mesh_scene"),
             "openvdb": ("volume/voxels/vdb_",), "cairo": ("compare/drawing/canvas",),
             "png": ("compare/files/picture_readers",), "jpeglib": ("compare/files/picture_readers",)}


def unit(path):
    """A header and its source are one unit: a circle is one of units."""
    return path.rsplit(".", 1)[0]


def circles(uses):
    """The strongly connected sets of more than one node of a graph {node: {nodes}}: Tarjan 1972."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for used in sorted(uses.get(node, ())):
            if used not in index:
                visit(used)
                low[node] = min(low[node], low[used])
            elif used in stack:
                low[node] = min(low[node], index[used])
        if low[node] == index[node]:
            at = stack.index(node)
            if len(stack) - at > 1:
                found.append(sorted(stack[at:]))
            del stack[at:]

    sys.setrecursionlimit(10000)
    for node in sorted(uses):
        if node not in index:
            visit(node)
    return found


def faults(source, table):
    """Every fault of the tree `source` against `table` ({room: [rooms]}), in words."""
    files = sorted(path.relative_to(source).as_posix() for room in ROOMS
                   for ending in ("*.h", "*.cpp") for path in (source / room).rglob(ending))
    if not files:
        yield f"no sources in {source}"
    for room, used in table.items():
        for name in used:
            if name not in table:
                yield f"{room} may include {name}, which is no room"
            elif name.split("/")[0] not in DIRECTION[room.split("/")[0]] + [room.split("/")[0]]:
                yield f"{room} may include {name} against the direction of the rooms"

    uses, needed, places, mains = defaultdict(set), defaultdict(set), defaultdict(set), []
    for name in files:
        room = name.rsplit("/", 1)[0]
        places[Path(name).stem].add(unit(name))
        if room not in table:
            yield f"{name} lies in no room"
            continue
        for number, line in enumerate((source / name).read_text().splitlines(), 1):
            if re.match(r"int main\(", line):
                mains.append(name)
            library = re.match(r"#include <([a-z]+)", line)
            if library and not name.startswith(LIBRARIES.get(library[1], "")):
                yield f"{name}:{number}: only {LIBRARIES[library[1]]} may include {library[1]}"
            include = re.match(r'#include "([^"]*)"', line)
            if not include:
                continue
            if include[1] not in files:
                yield f"{name}:{number}: there is no {include[1]}"
                continue
            other = include[1].rsplit("/", 1)[0]
            if unit(include[1]) != unit(name):
                uses[unit(name)].add(unit(include[1]))
            if other != room:
                needed[room].add(other)
                if other not in table[room]:
                    yield f"{name}:{number}: {room} may not include {other}"

    for room, used in table.items():
        for other in used:
            if other not in needed[room]:
                yield f"{room} may include {other}, but no file does"
    for circle in circles({room: set(used) for room, used in table.items()}):
        yield "a circle of rooms: " + ", ".join(circle)
    for circle in circles(uses):
        yield "a circle of files: " + ", ".join(circle)
    for name, where in places.items():
        if len(where) > 1:
            yield "one name for several files: " + ", ".join(sorted(where))
    if len(mains) != 1:
        yield f"main() stands in {len(mains)} files: {', '.join(mains)}"


def read_table(path):
    table = {}
    for line in path.read_text().splitlines():
        room, _, used = line.partition(":")
        table[room] = used.split()
    return table


def main():
    found = list(faults(Path(sys.argv[1]), read_table(Path(sys.argv[2]))))
    print("\n".join(found) if found else "every file is in its room")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
