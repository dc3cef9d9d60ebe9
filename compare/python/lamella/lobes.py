"""Lobes on cells of the hemisphere: arrays, energies, files, plots."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from typing import Any, Optional, Union

import numpy as np

from . import _core
from .directions import FloatArray

Path = Union[str, "os.PathLike[str]"]
Key = tuple[str, str]


class Energies(Mapping):
    """Shares of the light that comes in, by name: arrays [direction, channel].

    Names: ("reflect", "all"), ("transmit", "1"), ..., ("reflect", "specular") (deltas, in "all"
    too), and "uncollided", "absorbed", "unresolved", "lost", "thinned". reflect, transmit and the
    last five sum to 1.

    `standard_error[name]`: the standard errors, or the solver's bounds.
    """

    def __init__(self, listed: list[tuple[str, str, Any, Any]], errors: bool = False) -> None:
        self._listed = listed
        self._errors = errors
        self._arrays: dict[Any, FloatArray] = {}
        for item in listed:
            key: Any = (item[0], item[1]) if item[0] else item[1]
            array: Any = item[3] if errors else item[2]
            if array is not None:
                self._arrays[key] = array

    @property
    def standard_error(self) -> "Energies":
        return Energies(self._listed, True)

    def __getitem__(self, key: Any) -> FloatArray:
        if key not in self._arrays:
            raise KeyError(f"{key!r}: not there; allowed: "
                           + ", ".join(repr(name) for name in self._arrays))
        return self._arrays[key]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        lines = [f"{' '.join(k) if isinstance(k, tuple) else k:<20} "
                 + "  ".join(" ".join(f"{v:.6f}" for v in row) for row in array)
                 for k, array in self._arrays.items() if np.any(array)]
        return "\n".join(lines)


class StandardErrors(Mapping):
    """The standard errors of lobes, or the solver's error bounds: like the lobes themselves."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __getitem__(self, key: Key) -> FloatArray:
        side, name = key
        return self._core.errors(side, str(name))

    def __iter__(self) -> Iterator[Key]:
        return iter(self._core.keys)

    def __len__(self) -> int:
        return len(self._core.keys)


class Lobes(Mapping):
    """The lobes of some incident directions on cells of the hemisphere.

    lobes["reflect", "all"] is an array [direction, mu, phi, channel] of cosine-weighted means of f
    [1/sr] over each cell, a view of the numbers without a copy, read only. Sides: "reflect",
    "transmit", relative to the light. Names: the orders "1", "2", "3", "4+", and "all"; with rough
    interfaces "0" (light that met interfaces alone) and "1+". Deltas are in none.

    Row k of mu lies between mu_edges[k + 1] and mu_edges[k] (equal steps in mu^2, the normal
    first), column k of phi between phi_edges[k] and phi_edges[k + 1] [radians], from the azimuth
    of the light on. Where `folded`, each column stands for phi and -phi.
    """

    def __init__(self, core: Any) -> None:
        self._core = core

    def __getitem__(self, key: Key) -> FloatArray:
        if not isinstance(key, tuple) or len(key) != 2:
            raise KeyError(f'{key!r}: not there; allowed: (side, order), such as '
                           '("reflect", "all")')
        return self._core.values(key[0], str(key[1]))

    def __iter__(self) -> Iterator[Key]:
        return iter(self._core.keys)

    def __len__(self) -> int:
        return len(self._core.keys)

    @property
    def standard_error(self) -> StandardErrors:
        """By the same keys and of the same shapes; where `is_bounded`, the solver's bounds."""
        return StandardErrors(self._core)

    @property
    def energies(self) -> Energies:
        """Shares of the light that comes in: lobes and what else becomes of it."""
        return Energies(self._core.energies())

    @property
    def directions(self) -> FloatArray:
        """The incident directions, [direction, 3], unit."""
        return self._core.directions

    @property
    def theta_i(self) -> FloatArray:
        """Their polar angles in degrees, [direction]."""
        return self._core.theta

    @property
    def phi_i(self) -> FloatArray:
        """Their azimuths in degrees, [direction]."""
        return self._core.phi

    @property
    def mu_edges(self) -> FloatArray:
        """Cosines at the edges of the rows, from 1 down to 0."""
        return self._core.mu_edges

    @property
    def phi_edges(self) -> FloatArray:
        """Azimuths [radians] relative to w_i at the edges of the columns, from 0 on."""
        return self._core.phi_edges

    @property
    def folded(self) -> bool:
        """Whether the columns cover 0 to pi, each for phi and -phi."""
        return self._core.folded

    @property
    def channels(self) -> int:
        """1 (grey) or 3 (red, green, blue)."""
        return self._core.channels

    @property
    def is_bounded(self) -> bool:
        """Whether the solver found them: error bounds stand in the place of standard errors."""
        return self._core.is_bounded

    @property
    def estimator(self) -> str:
        """Which estimator found them, and why."""
        return self._core.estimator

    @property
    def interrupted(self) -> bool:
        """Whether they are less than what was asked for."""
        return self._core.interrupted

    @property
    def attributes(self) -> dict[str, str]:
        """How they were made, as in the header of an EXR file: stack, seed, walks, ..."""
        return self._core.attributes

    @property
    def answer(self) -> Any:
        """The JSON of `lamella simulate`, as Python values; None of lobes that were read."""
        return json.loads(self._core.answer)

    def save(self, path: Path) -> None:
        """Writes them to a file, by its ending.

        .exr: float32, with all that `attributes` has; byte for byte what `lamella simulate -o`
            writes.
        .npz: NumPy's archive of float64: "directions", "mu_edges", "phi_edges", "folded",
            "reflect.all" [direction, mu, phi, channel], "reflect.all.se", ...
        .csv: a row per direction, side, lobe and cell.
        """
        text = os.fspath(path)
        if text.endswith(".exr"):
            self._core.save_exr(text)
        elif text.endswith((".npz", ".csv")):
            self._core.save_archive(text)
        else:
            raise ValueError(f'save: found "{text}"; allowed: a name that ends in .exr, .npz or '
                             ".csv")

    def to_xarray(self) -> Any:
        """An xarray.Dataset: a variable per lobe ("reflect_all", and "reflect_all_se"), dimensions
        direction, mu, phi, channel, coordinates at the middles of cells (mu: of mu^2). Needs
        xarray; shares the numbers."""
        try:
            import xarray
        except ImportError:
            raise ImportError("to_xarray needs the package xarray (Debian: python3-xarray)") \
                from None
        dimensions = ("direction", "mu", "phi", "channel")
        mu2, phi = self.mu_edges**2, self.phi_edges
        channel = ["Y"] if self.channels == 1 else ["R", "G", "B"]
        coordinates = {
            "theta_i": ("direction", self.theta_i, {"units": "degree"}),
            "phi_i": ("direction", self.phi_i, {"units": "degree"}),
            "mu": ("mu", np.sqrt((mu2[1:] + mu2[:-1]) / 2)),
            "phi": ("phi", (phi[1:] + phi[:-1]) / 2, {"units": "radian"}),
            "channel": channel}
        variables: dict[str, Any] = {}
        for side, name in self:
            variables[f"{side}_{name}"] = (dimensions, self[side, name], {"units": "1/sr"})
            try:
                error = self.standard_error[side, name]
            except KeyError:
                continue
            variables[f"{side}_{name}_se"] = (dimensions, error, {"units": "1/sr"})
        return xarray.Dataset(variables, coordinates, dict(self.attributes))

    def plot(self, kind: str = "plane", side: str = "reflect", lobe: str = "all",
             direction: Optional[int] = None, ax: Any = None) -> Any:
        """Draws a lobe by matplotlib and returns the axes.

        kind: "plane" (f over theta_o in the plane of incidence), "polar" (the same as a polar
            curve) or "disc" (the whole hemisphere, seen from above; one direction).
        direction: index of an incident direction; None: all of them ("disc": the first).
        """
        from .plots import plot_lobes

        return plot_lobes(self, kind, side, lobe, direction, ax)

    def __repr__(self) -> str:
        n, (mu, phi) = len(self.directions), (len(self.mu_edges) - 1, len(self.phi_edges) - 1)
        return (f"<lamella.Lobes of {n} direction{'s' if n != 1 else ''}, {mu} x {phi} cells, "
                f"{self.channels} channel{'s' if self.channels != 1 else ''}: "
                + ", ".join(" ".join(key) for key in self) + ">")


def read(path: Path, part: str = "") -> Lobes:
    """Lobes from an EXR file of `lamella simulate`, `lamella compare` or Lobes.save.

    part: of a file of `compare`: "truth" (the default), "model", "difference" or "z".

    The values are float32 there; energies are those of the lobes, summed over their cells.
    """
    return Lobes(_core.read_lobes(os.fspath(path), part))
