"""Directions: unit vectors from angles, and arrays of them as the compiled part takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core

if TYPE_CHECKING:  # for annotations alone: the module takes its time
    from numpy.typing import ArrayLike, NDArray
    FloatArray = NDArray[np.float64]
else:
    ArrayLike = Any
    FloatArray = np.ndarray


def directions(theta: ArrayLike, phi: ArrayLike = 0.0) -> FloatArray:
    """Unit vectors from angles in degrees.

    theta: polar angle from the normal, in [0, 180]; 90 is mu = 0 exactly, above 90 lies below the
        surface.
    phi: azimuth; multiples of 90 fall exactly on the axes. Both are broadcast, shape (...).

    Returns shape (..., 3).

    >>> directions([0, 60])[0]
    array([0., 0., 1.])
    """
    t, p = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    if not (np.all((t >= 0) & (t <= 180)) and np.all(np.isfinite(p))):
        raise ValueError("theta, phi: found values outside; allowed: theta in [0, 180], phi finite, "
                         "in degrees")
    flat = _core.directions_from_degrees(np.ascontiguousarray(t.ravel()),
                                         np.ascontiguousarray(p.ravel()))
    return flat.reshape(t.shape + (3,))


def vectors(what: str, array: ArrayLike, columns: int = 3) -> FloatArray:
    """The array as float64, its last axis of length `columns`."""
    vector = np.asarray(array, float)
    if vector.ndim == 0 or vector.shape[-1] != columns:
        raise ValueError(f"{what}: found an array of shape {vector.shape}; allowed: "
                         f"(..., {columns})")
    return vector


def rows(*arrays: FloatArray) -> tuple[tuple[int, ...], list[FloatArray]]:
    """The common shape of arrays (..., n), their last axis left out, and each as rows [m, n]."""
    try:
        shape = np.broadcast_shapes(*[a.shape[:-1] for a in arrays])
    except ValueError:
        raise ValueError("found arrays of shapes "
                         + ", ".join(str(a.shape) for a in arrays)
                         + ", which cannot be broadcast") from None
    flat = [np.ascontiguousarray(np.broadcast_to(a, shape + a.shape[-1:])
                                 .reshape(-1, a.shape[-1])) for a in arrays]
    return shape, flat


def keywords(**given: Any) -> dict[str, Any]:
    """The keywords that were given: those that are not None."""
    return {key: value for key, value in given.items() if value is not None}


def incident(wi: Any) -> Any:
    """`wi` as a list of THETA or (THETA, PHI): a single number is one direction."""
    if wi is None:
        return None
    if isinstance(wi, (int, float, np.integer, np.floating)):
        return [wi]
    if isinstance(wi, np.ndarray):
        return wi.tolist()
    return list(wi)
