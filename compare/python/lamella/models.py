"""Closed forms, and Python functions judged like them."""

from __future__ import annotations

import os
import re
from typing import Any, Callable, Optional, Union, cast

import numpy as np

from . import _core
from .directions import ArrayLike, FloatArray, incident, keywords, rows, vectors
from .lobes import Lobes
from .progress import warn
from .stacks import Stack, as_stack

ModelLike = Union["Model", str, Callable[[FloatArray, FloatArray], ArrayLike]]

_MEASURED = (".binary", ".bsdf")


def is_measured(model: Any) -> bool:
    """Whether it is the path of a MERL or tensor file."""
    return isinstance(model, (str, os.PathLike)) and str(os.fspath(model)).endswith(_MEASURED)


def _text(value: Any) -> str:
    """A value as --model takes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if hasattr(value, "tolist"):
        return _text(value.tolist())
    if isinstance(value, (list, tuple)):
        return ",".join(_text(v) for v in value)
    return repr(value) if isinstance(value, float) else os.fspath(value) \
        if isinstance(value, os.PathLike) else str(value)


class Model:
    """A closed form with its parameters fixed, a shared object, or a Python function.

    Model("eon", albedo=[0.8, 0.4, 0.2], roughness=0.5)
    Model("eon,albedo=0.8")                   as --model takes it, "@FILE" too
    Model("./mine.so", ...)                   a plug-in (analytic/README.md)
    Model("single_scattering", stack=stack)   one that is made from a stack; others take from it
                                              what both have a name for
    Model("gold.binary")                      a measured material: MERL (.binary) or tensor file
                                              (.bsdf, Mitsuba 3 and pbrt-v4)
    Model(function)                           function(wi, wo) -> f

    A function takes two arrays [n, 3] of unit vectors, to the light and to the viewer, and gives f
    [1/sr], shape (n,), (n, 1) or (n, 3), finite and not negative. It is called with many pairs at
    a time, and from another thread in long work; what it raises reaches the caller. `name` is what
    reports call it; `transmits`: whether it has values where w_i and w_o lie on different sides
    (else it is only asked where they do not).

    Directions are broadcast against one another, shape (..., 3), and results have the shape (...)
    or (..., channels). mu = 0 is the limit from above.
    """

    def __init__(self, model: ModelLike, *, stack: Union[Stack, str, None] = None,
                 name: Optional[str] = None, transmits: bool = False, **parameters: Any) -> None:
        self._stack = None if stack is None else as_stack(stack)
        if is_measured(model):
            if parameters or stack is not None:
                raise ValueError("model: found keys beside a measured material; allowed: none")
            self._core = _core.read_measured(os.fspath(cast(str, model)))
        elif isinstance(model, (str, os.PathLike)):
            further = [(key, _text(value)) for key, value in parameters.items()]
            self._core = _core.make_model(os.fspath(model), further,
                                          None if self._stack is None else self._stack._core)
        elif isinstance(model, Model):
            raise ValueError("model: found a Model; allowed: a name or a function")
        elif callable(model):
            if parameters or stack is not None:
                raise ValueError("model: found keys beside a function; allowed: name, transmits")
            given = str(name or getattr(model, "__name__", type(model).__name__))
            # It becomes the name of files.
            clean = re.sub(r"[^A-Za-z0-9_-]+", "_", given).strip("_") or "function"
            self._core = _core.make_function(clean, model, transmits)
        else:
            raise ValueError(f"model: found {model!r}; allowed: a name or a function")

    @property
    def name(self) -> str:
        """Of the closed form, or of the function."""
        return self._core.name

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter by name: numbers, triples, texts."""
        return self._core.parameters

    @property
    def sources(self) -> dict[str, str]:
        """Where each parameter comes from: "given", "stack", "fitted", "default", ..."""
        return self._core.sources

    @property
    def request(self) -> str:
        """The model as --model takes it: NAME,key=value,..."""
        return self._core.request

    @property
    def lobe_names(self) -> tuple[str, ...]:
        """The model's own terms: what eval(lobe=...) takes."""
        return self._core.lobe_names

    @property
    def channels(self) -> int:
        """1 where all parameters are grey, else 3."""
        return self._core.channels

    def eval(self, wi: ArrayLike, wo: ArrayLike, *, lobe: str = "",
             isa: str = "scalar") -> FloatArray:
        """f(w_i, w_o) [1/sr], without the cosine.

        wi, wo: unit vectors, shapes (..., 3), broadcast.
        lobe: one of lobe_names; empty: their sum.
        isa: "auto" evaluates on the widest lanes, faster and equal up to rounding; "scalar" gives
            the bits of `lamella eval`.

        Returns shape (..., channels). Deltas are left out.
        """
        shape, (i, o) = rows(vectors("wi", wi), vectors("wo", wo))
        return self._core.eval(i, o, lobe, isa).reshape(shape + (self.channels,))

    def __call__(self, wi: ArrayLike, wo: ArrayLike) -> FloatArray:
        """eval(wi, wo)."""
        return self.eval(wi, wo)

    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> FloatArray:
        """Density [1/sr] with which sample(wo, u) gives w_i; shapes (..., 3), returns (...)."""
        shape, (i, o) = rows(vectors("wi", wi), vectors("wo", wo))
        return self._core.pdf(i, o).reshape(shape)

    def sample(self, wo: ArrayLike, u: ArrayLike) -> FloatArray:
        """Directions to the light given those to the viewer, by the model's own sampler.

        wo: unit vectors, shape (..., 3). u: uniform numbers in (0, 1), shape (..., 3); broadcast.

        Returns shape (..., 3); nan where no light is found that way.
        """
        shape, (o, uniform) = rows(vectors("wo", wo), vectors("u", u))
        return self._core.sample(o, uniform).reshape(shape + (3,))

    def albedo(self, wi: ArrayLike, *, with_error: bool = False) -> Any:
        """Directional albedo: the share of light from w_i that leaves anywhere, deltas left out.

        wi: unit vectors, shape (..., 3). Returns shape (..., channels), by closed form or adaptive
        cubature; `with_error`: a pair of that and a bound of its error (of a stochastic model one
        standard error).
        """
        shape, (i,) = rows(vectors("wi", wi))
        values, errors = (a.reshape(shape + (self.channels,)) for a in self._core.albedo(i))
        return (values, errors) if with_error else values

    def lobes(self, wi: Any = None, *, grid: Optional[tuple[int, int]] = None) -> Lobes:
        """The model on cells of the hemisphere, like lamella.simulate: cosine-weighted means of f,
        by quadrature within 1e-4; its `standard_error` is what the quadrature left open.

        wi, grid: as in lamella.simulate().
        """
        return Lobes(_core.lobes_of_model(self._core, keywords(wi=incident(wi), grid=grid)))

    def save(self, path: Union[str, "os.PathLike[str]"], to: str = "mitsuba", *,
             size: str = "large") -> float:
        """Writes the reflection from above as a measured material of other programs.

        to: "mitsuba" (tensor file of RGB), "pbrt" (tensor file of spectra: f at 450, 550, 650 nm
            is blue, green, red), "merl" (isotropic).
        size: of a tensor file: "small", "medium", "large", 4 MB.

        Returns the format's own error: the relative RMSE of what a reader of the file gets back.
        What such a file does not hold is told as a warning.
        """
        _, error, left_out = _core.save_brdf(self._core, os.fspath(path), to, size)
        warn([f"{to} holds reflection from above alone: {what} is left out" for what in left_out],
             False)
        return error

    def __repr__(self) -> str:
        return f"<lamella.Model {self.request}>"

    def __reduce__(self) -> tuple[Any, ...]:
        if not self._core.is_built_in:
            raise TypeError("a model of a Python function or a file cannot be pickled")
        return _restore, (self.request, self._stack)


def _restore(request: str, stack: Optional[Stack]) -> Model:
    return Model(request, stack=stack)


def as_model(model: ModelLike) -> Any:
    """What compare hands down: the compiled part's model, or text that takes the rest from the
    stack."""
    if isinstance(model, str):
        return model
    return (model if isinstance(model, Model) else Model(model))._core
