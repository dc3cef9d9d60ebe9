"""Reference lobes of many stacks, as `lamella library build` keeps them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from . import _core
from .directions import FloatArray
from .lobes import Lobes, Path
from .stacks import Stack


class Points(NamedTuple):
    """f at pairs of directions.

    wi, wo: unit vectors, [n, 3], off every mirror direction. f [1/sr] and error: [n, channels],
    error a bound or a standard error, as LibraryEntry.points_method says.
    """

    wi: FloatArray
    wo: FloatArray
    f: FloatArray
    error: FloatArray


class LibraryEntry:
    """One stack of a library: its text, its lobes, f at points. Files are read when they are asked
    for, and are refused (ValueError) where they have another SHA-256 than the index says."""

    def __init__(self, folder: str, known: dict[str, Any]) -> None:
        self._folder = folder
        self._known = known
        self._found: Any = None

    def _read(self) -> Any:
        if self._found is None:
            self._found = _core.library_entry(self._folder, self.name)
        return self._found

    @property
    def name(self) -> str:
        """As `lamella library show` lists it."""
        return self._known["name"]

    @property
    def group(self) -> str:
        """"paper", "coat", "plate", "problem" or "hard"."""
        return self._known["group"]

    @property
    def about(self) -> dict[str, Any]:
        """What index.json has: description, source, version, seed, time, files with SHA-256."""
        return self._known

    @property
    def stack(self) -> Stack:
        """The stack, every default filled in."""
        return Stack.parse(self._known["stack"], self.name)

    @property
    def lobes(self) -> Lobes:
        """Lobes of all orders on cells, for 8 incident directions, with energies; `is_bounded`
        says whether errors are bounds or standard errors."""
        return Lobes(self._read()[0])

    @property
    def points(self) -> Points:
        """f [1/sr] at pairs of directions."""
        return Points(*self._read()[1:])

    @property
    def lobes_method(self) -> dict[str, Any]:
        """How the lobes were found: `method`; `bound` and `reached` (of the solver), or `walks` and
        `relative_standard_error`, that of energies."""
        return self._known["lobes"]

    @property
    def points_method(self) -> dict[str, Any]:
        """The same of the points."""
        return self._known["points"]

    def __repr__(self) -> str:
        return (f"<lamella.LibraryEntry {self.name}: lobes by {self.lobes_method['method']}, "
                f"points by {self.points_method['method']}>")


class Library(Mapping):
    """The entries of a library by name, in the order of its index: library["vmf_sand"]."""

    def __init__(self, folder: str) -> None:
        self._folder = folder
        known = json.loads(_core.library_index(folder))
        self._entries = {entry["name"]: LibraryEntry(folder, entry) for entry in known["entries"]}

    @property
    def folder(self) -> str:
        """Where it lies."""
        return self._folder

    def __getitem__(self, name: str) -> LibraryEntry:
        if name not in self._entries:
            raise KeyError(f"{name!r}: not there; allowed: " + ", ".join(self._entries))
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __repr__(self) -> str:
        return f"<lamella.Library {self._folder}: {len(self)} entries>"


def library(folder: Path = "lamella-library") -> Library:
    """Reads the index of a library of reference lobes.

    folder: what `lamella library build` wrote. ValueError where it has no index.

    >>> for entry in lm.library().values():                                     # doctest: +SKIP
    ...     wi, wo, f, error = entry.points
    ...     off = np.abs(my_bsdf(wi, wo, entry.stack) - f)

    check(model, library=folder) holds a model against the entries that it claims.
    """
    return Library(os.fspath(folder))
