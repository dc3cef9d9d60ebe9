"""The truth of a stack: on cells of the hemisphere, or at pairs of directions."""

from __future__ import annotations

from typing import Any, Optional, Union

from . import _core
from .directions import ArrayLike, FloatArray, incident, keywords, rows, vectors
from .lobes import Lobes
from .progress import shown, warn
from .stacks import Stack, as_stack


def simulate(stack: Union[Stack, str], wi: Any = None, *, grid: Optional[tuple[int, int]] = None,
             estimator: Optional[str] = None, walks: Optional[float] = None,
             tolerance: Optional[float] = None, target_error: Optional[float] = None,
             time: Optional[float] = None, max_order: Optional[int] = None,
             thin_from: Optional[int] = None, sampling: Optional[str] = None,
             walk_order_1: Optional[bool] = None,
             seed: Optional[int] = None,
             threads: Optional[int] = None, isa: Optional[str] = None,
             progress: Optional[bool] = None) -> Lobes:
    """Ground-truth lobes of a stack, as `lamella simulate` finds them, bit by bit.

    stack: a Stack, the name of a built-in one, or the path of a stack file.
    wi: incident directions, each THETA or (THETA, PHI) in degrees: [0, 30, (60, 90)]. THETA above
        90 is light from below. Default: 0, 30, 60, 80.
    grid: cells per hemisphere along mu^2 and phi, default (16, 32).
    estimator: "auto" (default), "analog", "next-event" or "deterministic".
    walks: per direction, default 1e6. tolerance: of the solver, default 1e-4.
    target_error, time [s], max_order, thin_from, sampling, walk_order_1, seed, threads, isa: as on
        the command line.
    progress: None shows it in notebooks and on terminals; True, False.
    """
    core = as_stack(stack)._core
    given = keywords(wi=incident(wi), grid=grid, estimator=estimator, walks=walks,
                     tolerance=tolerance, target_error=target_error, time=time,
                     max_order=max_order, thin_from=thin_from, sampling=sampling,
                     walk_order_1=walk_order_1, seed=seed, threads=threads, isa=isa)
    lobes, warnings = _core.simulate(core, given, shown(progress))
    warn(warnings, lobes.interrupted)
    return Lobes(lobes)


def truth(stack: Union[Stack, str], wi: ArrayLike, wo: ArrayLike, *,
          estimator: Optional[str] = None, walks: Optional[float] = None,
          tolerance: Optional[float] = None, time: Optional[float] = None,
          max_order: Optional[int] = None, seed: Optional[int] = None,
          threads: Optional[int] = None, isa: Optional[str] = None,
          progress: Optional[bool] = None) -> tuple[FloatArray, FloatArray]:
    """f(w_i, w_o) of a stack [1/sr] and its error, as `lamella eval truth` finds them.

    wi, wo: unit vectors, shapes (..., 3), broadcast. The delta is left out; at most one of the two
        cosines may be 0.
    estimator: "auto" (default), "next-event" or "deterministic"; tolerance and walks as in
        simulate().

    Returns two arrays (..., channels): f, and one standard error, or the solver's error bound.
    """
    core = as_stack(stack)._core
    given = keywords(estimator=estimator, walks=walks, tolerance=tolerance, time=time,
                     max_order=max_order, seed=seed, threads=threads, isa=isa)
    shape, (i, o) = rows(vectors("wi", wi), vectors("wo", wo))
    f, error, interrupted, warnings = _core.truth(core, i, o, given, shown(progress))
    warn(warnings, interrupted)
    return f.reshape(shape + f.shape[1:]), error.reshape(shape + f.shape[1:])
