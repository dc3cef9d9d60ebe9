"""White furnaces of stacks and of closed forms."""

from __future__ import annotations

import json
from typing import Any, Optional, Union

import numpy as np

from . import _core
from .directions import FloatArray, incident, keywords
from .models import Model
from .progress import shown, warn
from .stacks import Stack, as_stack


class Furnace:
    """What a furnace found. `answer`: the JSON of `lamella furnace` as Python values."""

    def __init__(self, answer: dict[str, Any]) -> None:
        self.answer = answer

    @property
    def verdict(self) -> str:
        """"pass", "fail" or "inconclusive"."""
        return self.answer["verdict"]

    @property
    def passed(self) -> bool:
        return self.verdict == "pass"

    @property
    def interrupted(self) -> bool:
        """Whether some directions are missing."""
        return bool(self.answer.get("interrupted", False))

    @property
    def energy(self) -> FloatArray:
        """The light that leaves per light that came in, [direction, channel]."""
        return np.array([run["energy"] for run in self.answer["runs"]], float)

    @property
    def error(self) -> FloatArray:
        """Its standard error or bound, [direction, channel]."""
        return np.array([run.get("energy_standard_error", run.get("energy_error"))
                         for run in self.answer["runs"]], float)

    def __repr__(self) -> str:
        energies = "; ".join(" ".join(f"{v:.6f}" for v in row) for row in self.energy)
        return f"<lamella.Furnace {self.verdict}: energy {energies}>"


def furnace(of: Union[Stack, Model, str, Any], wi: Any = None, *, as_is: bool = False,
            estimator: Optional[str] = None,
            walks: Optional[float] = None, tolerance: Optional[float] = None,
            max_error: Optional[float] = None, time: Optional[float] = None,
            seed: Optional[int] = None, threads: Optional[int] = None, isa: Optional[str] = None,
            progress: Optional[bool] = None) -> Furnace:
    """The white furnace: energy that leaves per incident direction, 1 where nothing is lost.

    of: a Stack (or its name or path): all albedos, f0 and its substrate are set to 1 (`as_is` keeps
        them), and walks or the solver must find an energy of 1 within their error. Or a Model or a
        Python function, taken as it is: its energy must be 1 within max_error (default 1e-3), with
        `as_is` at most that.
    wi: incident directions as in simulate().
    """
    if isinstance(of, Model) or (callable(of) and not isinstance(of, Stack)):
        model = of if isinstance(of, Model) else Model(of)
        given = keywords(wi=incident(wi), as_is=as_is, max_error=max_error, threads=threads)
        return Furnace(json.loads(_core.model_furnace(model._core, given)))
    core = as_stack(of)._core
    given = keywords(wi=incident(wi), as_is=as_is, estimator=estimator, walks=walks,
                     tolerance=tolerance, time=time, seed=seed, threads=threads, isa=isa)
    answer, warnings = _core.furnace(core, "", given, shown(progress))
    found = Furnace(json.loads(answer))
    warn(warnings, found.interrupted)
    return found
