"""Walks one by one, for training."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Optional, Union

from . import _core
from .directions import FloatArray, incident, keywords
from .lobes import Path
from .progress import shown, warn
from .stacks import Stack, as_stack

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Samples:
    """Light that left a stack, walk by walk: arrays of n rows, views without a copy, read only.

    w_i, w_o: [n, 3] float32, unit vectors that point away from the stack.
    weight: [n, channels] float32, dimensionless: weight.sum(0) / walks is the energy that left.
        Each w_o is drawn with a density whose mean weight is f(w_i, w_o) |mu_o| per steradian.
    order: [n] uint32, scattering events. side: [n] int8, 1 reflected, -1 transmitted; 2 and -2
        where the light met nothing, or deltas alone: such rows are no part of f.
    walks: how many began; those that were absorbed have no row.

    Rows stand direction by direction, `direction_rows` [d] of each of `directions` [d, 3], within
    one by the number of the walk. Where w_i was drawn, d is 0.
    """

    def __init__(self, core: Any) -> None:
        self._core = core

    @property
    def w_i(self) -> NDArray[np.float32]:
        """Towards the light, [n, 3]."""
        return self._core.w_i

    @property
    def w_o(self) -> NDArray[np.float32]:
        """Towards the viewer, [n, 3]."""
        return self._core.w_o

    @property
    def weight(self) -> NDArray[np.float32]:
        """[n, channels]."""
        return self._core.weight

    @property
    def order(self) -> NDArray[np.uint32]:
        """Scattering events, [n]."""
        return self._core.order

    @property
    def side(self) -> NDArray[np.int8]:
        """1 reflected, -1 transmitted; deltas 2 and -2, [n]."""
        return self._core.side

    @property
    def walks(self) -> int:
        """How many began, over all directions."""
        return self._core.walks

    @property
    def directions(self) -> FloatArray:
        """Incident directions, unit vectors [d, 3]; d is 0 where w_i was drawn."""
        return self._core.directions

    @property
    def direction_walks(self) -> NDArray[np.uint64]:
        """Walks of each direction, [d]."""
        return self._core.direction_walks

    @property
    def direction_rows(self) -> NDArray[np.uint64]:
        """Rows of each direction, [d]."""
        return self._core.direction_rows

    @property
    def about(self) -> dict[str, Any]:
        """What the rows depend on: stack, seed, instruction set, limits."""
        return json.loads(self._core.about)

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it: the walks are those that were whole."""
        return self._core.interrupted

    def __len__(self) -> int:
        return len(self.side)

    def save(self, path: Path) -> int:
        """Writes the file that `lamella samples -o` writes; returns its size in bytes."""
        path = os.fspath(path)
        if not path.endswith(".npz"):
            raise ValueError(f'save: found "{path}"; allowed: a name that ends in .npz')
        return self._core.save(path)

    def __repr__(self) -> str:
        return f"<Samples: {self.walks} walks, {len(self)} rows>"


def samples(stack: Union[Stack, str], wi: Any = None, *, distribution: Optional[str] = None,
            walks: Optional[float] = None, max_order: Optional[int] = None,
            thin_from: Optional[int] = None, seed: Optional[int] = None,
            threads: Optional[int] = None, isa: Optional[str] = None,
            progress: Optional[bool] = None) -> Samples:
    """Walks one by one, as `lamella samples` finds them, bit by bit.

    stack: a Stack, the name of a built-in one, or the path of a stack file.
    wi: incident directions, each THETA or (THETA, PHI) in degrees. Default: 0, 30, 60, 80.
    distribution: instead of wi: every walk draws its own over the upper hemisphere, "uniform" per
        solid angle or by the "cosine".
    walks: per direction (drawn: in all), default 1e6. The walks are those that simulate()
        counts with the same seed and sampling="random".

    All rows are in memory: about 33 bytes each where grey, 41 in colour. `lamella samples` writes
    files of any size.
    """
    given = keywords(wi=incident(wi), distribution=distribution, walks=walks, max_order=max_order,
                     thin_from=thin_from, seed=seed, threads=threads, isa=isa)
    core, warnings = _core.samples(as_stack(stack)._core, given, shown(progress))
    warn(warnings, core.interrupted)
    return Samples(core)
