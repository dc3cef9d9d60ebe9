"""The parameters of closed forms that come nearest to a stack, to lobes or to a material."""

from __future__ import annotations

import functools
import json
import os
import re
from collections.abc import Sequence
from typing import Any, Callable, Iterable, Mapping, Optional, Union, cast, overload

import numpy as np

from . import _core
from .directions import ArrayLike, FloatArray, incident, keywords
from .lobes import Lobes, read
from .models import Model, is_measured
from .progress import shown, warn
from .reports import Report
from .stacks import Stack, as_stack

Range = tuple[float, float]


class Family:
    """A Python function with parameters, of which fit() finds the values.

    function(wi, wo, **parameters) -> f: the directions and values as of a Model; a number comes as
        a float, a colour as an array of shape (3,).
    numbers, colors: the ranges, a pair (lowest, highest) by name.

    Family(lobe, numbers={"roughness": (0.05, 1)}, colors={"albedo": (0, 1)})
    """

    def __init__(self, function: Callable[..., ArrayLike], *,
                 numbers: Optional[Mapping[str, Range]] = None,
                 colors: Optional[Mapping[str, Range]] = None, name: Optional[str] = None,
                 transmits: bool = False) -> None:
        self.function = function
        self.transmits = transmits
        self.numbers = dict(numbers or {})
        self.colors = dict(colors or {})
        ranges = []
        for key, (low, high) in [*self.numbers.items(), *self.colors.items()]:
            if not (np.isfinite([low, high]).all() and low < high):
                raise ValueError(f'family: key "{key}": found ({low}, {high}); allowed: two finite '
                                 "numbers, the lower first")
            ranges.append((key, float(low), float(high), key in self.colors))
        given = str(name or getattr(function, "__name__", type(function).__name__))
        self.name = re.sub(r"[^A-Za-z0-9_-]+", "_", given).strip("_") or "function"
        self._core = _core.make_family(self.name, function, ranges, transmits)

    def __repr__(self) -> str:
        return f"<lamella.Family {self.name}: {', '.join([*self.numbers, *self.colors])}>"


class Fit:
    """One model, or a stack, with the parameters that come nearest."""

    def __init__(self, answer: dict[str, Any], family: Optional[Family]) -> None:
        self.answer = answer
        self._family = family

    @property
    def name(self) -> str:
        """Of the closed form, or of the function."""
        return self.answer["name"]

    @property
    def request(self) -> str:
        """The model as --model takes it; of a stack its name."""
        return self.answer.get("model", self.answer["name"])

    @property
    def values(self) -> dict[str, float]:
        """What was found, by name: "roughness", "albedo.r", ..."""
        return {p["name"]: p["value"] for p in self.answer["parameters"]}

    @property
    def deviations(self) -> dict[str, float]:
        """One standard deviation of each, as if what is left over were independent from cell to
        cell; inf where the target does not determine it, 0 at an end of its range."""
        return {p["name"]: float(p["deviation"]) for p in self.answer["parameters"]}

    @property
    def errors_of_truth(self) -> dict[str, float]:
        """The part of each that the target's own error makes: one standard error, or the most
        that its bounds allow."""
        return {p["name"]: float(p["of_truth"]) for p in self.answer["parameters"]}

    @property
    def states(self) -> dict[str, str]:
        """"found", "at its lowest", "at its highest", "no effect" or "undetermined"."""
        return {p["name"]: p["state"] for p in self.answer["parameters"]}

    @property
    def covariance(self) -> FloatArray:
        """[parameter, parameter] in the order of `values`; 0 for those that are not "found"."""
        n = len(self.answer["parameters"])
        return np.array(self.answer["covariance"], float).reshape(n, n)

    @property
    def relative_rmse(self) -> float:
        """What is left over: root mean square over the cells, relative to the target's; every
        incident direction counts the same."""
        return self.answer["relative_rmse"]

    @property
    def relative_rmse_without_noise(self) -> float:
        """The same with the variance of the target's noise removed."""
        return self.answer["relative_rmse_without_noise"]

    @property
    def misfit(self) -> float:
        """What was made least: relative_rmse, or the RMS of ln f."""
        return self.answer["misfit"]

    @property
    def residues(self) -> list[dict[str, Any]]:
        """What is left over per incident direction and side: `mu_i`, `phi_i`, `side`,
        `energy_truth`, `energy_model`, `relative_rmse`, `noise`."""
        return self.answer["residues"]

    @property
    def model(self) -> Model:
        """The model with these parameters."""
        if "stack" in self.answer:
            raise ValueError(f"fit: {self.name} is a stack; allowed: .stack")
        if self._family is None:
            return Model(self.request)
        values: dict[str, Any] = {key: self.values[key] for key in self._family.numbers}
        for key in self._family.colors:
            channels = [self.values.get(f"{key}.{c}", self.values.get(key)) for c in "rgb"]
            values[key] = np.array(channels, float)
        return Model(functools.partial(self._family.function, **values), name=self.name,
                     transmits=self._family.transmits)

    @property
    def stack(self) -> Stack:
        """The stack with these numbers, where a stack was fitted."""
        if "stack" not in self.answer:
            raise ValueError(f"fit: {self.name} is a closed form; allowed: .model")
        return Stack.parse(self.answer["stack"])

    def __repr__(self) -> str:
        return f"<lamella.Fit {self.request}: {100 * self.relative_rmse:.3g} % left over>"


class Fits(Sequence):
    """Fits of several models to one target, the nearest first. str() is the table of the command
    line; in a notebook it draws the page of a comparison."""

    def __init__(self, core: Any, families: dict[str, Family]) -> None:
        self._core = core
        self.answer: dict[str, Any] = json.loads(core.answer)
        self._fits = [Fit(m, families.get(m["name"])) for m in self.answer["models"]]

    @overload
    def __getitem__(self, key: int) -> Fit: ...
    @overload
    def __getitem__(self, key: slice) -> list[Fit]: ...
    def __getitem__(self, key: Union[int, slice]) -> Union[Fit, list[Fit]]:
        return self._fits[key]

    def __len__(self) -> int:
        return len(self._fits)

    @property
    def refused(self) -> list[str]:
        """Models that have no values there, a line each."""
        return self.answer["refused"]

    @property
    def interrupted(self) -> bool:
        """Whether models are missing."""
        return self._core.interrupted

    @functools.cached_property
    def report(self) -> Report:
        """All of them judged by the target, as compare() does; of a stack its lobes."""
        return Report(self._core.report())

    def save(self, folder: Union[str, "os.PathLike[str]"], pictures: Iterable[str] = ()) -> None:
        """Writes the comparison as Report.save does, fit.json, and a fitted stack as stack.toml."""
        self.report.save(folder, pictures)
        if "stack" in self._fits[0].answer:
            self._fits[0].stack.save(os.path.join(folder, "stack.toml"))
        with open(os.path.join(folder, "fit.json"), "w", encoding="utf-8") as file:
            json.dump(self.answer, file, indent=2)
            file.write("\n")

    def _repr_html_(self) -> str:
        return self.report._repr_html_()

    def __str__(self) -> str:
        return self._core.summary

    def __repr__(self) -> str:
        return "<lamella.Fits " + "; ".join(
            f"{f.name}: {100 * f.relative_rmse:.3g} %" for f in self._fits) + ">"


def _ranges(vary: Mapping[str, Any]) -> list[str]:
    """PATH=FROM:TO[:log] with every digit."""
    texts = []
    for path, ends in vary.items():
        if not isinstance(ends, (tuple, list)) or len(ends) not in (2, 3) or (len(ends) == 3 and ends[2] != "log"):
            raise ValueError(f'--vary: found {path!r}: {ends!r}; allowed: (FROM, TO) or '
                             '(FROM, TO, "log")')
        texts.append(f"{path}={float(ends[0])!r}:{float(ends[1])!r}"
                     + (":log" if len(ends) == 3 else ""))
    return texts


def fit(target: Union[Stack, Lobes, Model, str, Any],
        models: Union[None, str, Family, Iterable[Union[str, Family]]] = None, wi: Any = None, *,
        stack: Union[None, Stack, str] = None, vary: Optional[Mapping[str, Any]] = None,
        norm: str = "relative", sides: str = "all", grid: Optional[tuple[int, int]] = None,
        estimator: Optional[str] = None, walks: Optional[float] = None,
        tolerance: Optional[float] = None, time: Optional[float] = None,
        seed: Optional[int] = None, threads: Optional[int] = None, isa: Optional[str] = None,
        progress: Optional[bool] = None) -> Fits:
    """The parameters of models that come nearest to a target, as `lamella fit --model` finds them,
    or the numbers of a stack (`--stack`).

    target: a Stack (or the name of a built-in one, or its path), whose truth is found as by
        simulate(); Lobes, or a file of them (.exr); a measured material (.binary, .bsdf); a Model
        or a Python function.
    models: texts as --model takes them ("eon", "coated,base=eon,ior=1.5": what is given stays, the
        rest is fitted; "eon,vmf_diffuse": two; "all", the default), and Family objects.
    stack, vary: instead of models, a stack and its numbers that are free, by paths as in
        `lamella sweep --set`: {"layer.0.roughness": (0.1, 1), "layer.0.thickness": (0.1, 10,
        "log")}. Colours have a number per channel where the target has three.
    wi, grid: incident directions and cells; of Lobes their own.
    norm: what is made least. "relative": root of the mean over the incident directions of
        sum (m - t)^2 / sum t^2 over cells of equal projected solid angle; "log": RMS of ln f.
    sides: "all", or "reflect": reflection alone.
    The others are those of simulate(), and of a Stack alone; where a stack is fitted, its own.
    """
    for what, found, allowed in ("norm", norm, ("relative", "log")), \
            ("sides", sides, ("all", "reflect")):
        if found not in allowed:
            raise ValueError(f'--{what}: found "{found}"; allowed: {", ".join(allowed)}')
    if stack is not None and models is not None:
        raise ValueError("--stack: found beside --model; allowed: one of the two")
    if vary is not None and stack is None:
        raise ValueError("--vary: found no --stack; allowed: beside it")
    models = "all" if models is None else models
    listed: list[Union[str, Family]] = [models] if isinstance(models, (str, Family)) \
        else list(models)
    for model in listed:
        if not isinstance(model, (str, Family)):
            raise ValueError(f"models: found {model!r}; allowed: texts as --model takes them, and "
                             "Family objects (Python functions with parameters)")
    if not listed:
        raise ValueError("models: found none; allowed: one or more")
    if is_measured(target):
        core: Any = Model(cast(str, target))._core
    elif isinstance(target, (str, os.PathLike)) and os.fspath(target).endswith(".exr"):
        core = read(target)._core
    elif isinstance(target, (Lobes, Model)):
        core = target._core
    elif callable(target):
        core = Model(target)._core
    else:
        core = as_stack(target)._core
    if isinstance(core, _core.Lobes) and (wi is not None or grid is not None):
        raise ValueError("fit: found wi or grid beside lobes; allowed: neither, as lobes have "
                         "their own")
    given = keywords(wi=incident(wi), grid=grid, estimator=estimator, walks=walks,
                     tolerance=tolerance, time=time, seed=seed, threads=threads, isa=isa)
    if stack is not None:
        fits, warnings = _core.fit_stack(core, as_stack(stack)._core, _ranges(vary or {}), norm,
                                         sides, given, shown(progress))
        warn(warnings, fits.interrupted)
        return Fits(fits, {})
    fits, warnings = _core.fit(core, [m if isinstance(m, str) else m._core for m in listed],
                               norm, sides, given, shown(progress))
    warn(warnings, fits.interrupted)
    return Fits(fits, {m.name: m for m in listed if isinstance(m, Family)})
