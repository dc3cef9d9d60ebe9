"""Closed forms against the truth of a stack."""

from __future__ import annotations

import html
import json
import os
from typing import Any, Iterable, Optional, Union, cast

from . import _core
from .directions import incident, keywords
from .lobes import Lobes
from .models import Model, ModelLike, as_model, is_measured
from .progress import shown, warn
from .stacks import Stack, as_stack


class Report:
    """Models judged by the truth of a stack, lobe by lobe. In a notebook it draws itself: the page
    of `lamella compare` with verdicts, lobes, error maps and all numbers.

    str(report) is the table of the command line.
    """

    def __init__(self, core: Any) -> None:
        self._core = core

    @property
    def table(self) -> list[dict[str, Any]]:
        """A dictionary per model, incident direction, side and order: `model`, `mu_i`, `phi_i`,
        `side`, `order`, `energy_truth`, `energy_standard_error`, `energy_model` (lists over
        channels), `rmse`, `relative_rmse`, `rmse_without_noise`, `relative_rmse_without_noise`,
        `max_error`, `p_value`, `verdict` ("agrees", "differs", "insufficient"), ... pandas takes
        it: pandas.DataFrame(report.table)."""
        return [{"model": name, **lobe}
                for name, model in zip(self._core.names, self.answer["models"])
                for lobe in model["lobes"]]

    @property
    def answer(self) -> dict[str, Any]:
        """The JSON of `lamella compare` as Python values."""
        return json.loads(self._core.answer)

    @property
    def truth(self) -> Lobes:
        """The lobes that the models were judged by."""
        return Lobes(self._core.truth())

    @property
    def worst_relative_rmse(self) -> float:
        """The largest relative RMSE over all orders that is certain, noise left out."""
        return self._core.worst_relative_rmse

    @property
    def interrupted(self) -> bool:
        """Whether it is less than what was asked for."""
        return self._core.interrupted

    def save(self, folder: Union[str, "os.PathLike[str]"],
             pictures: Iterable[str] = ()) -> None:
        """Writes what `lamella compare -o` does: report.html, report.json, summary.txt, truth.exr,
        an EXR file per model; `pictures`: formats of error maps, "png", "svg", "pdf"."""
        self._core.save(os.fspath(folder), list(pictures))

    def _repr_html_(self) -> str:
        return ('<iframe style="width: 100%; height: 800px; border: 0" srcdoc="'
                + html.escape(self._core.page) + '"></iframe>')

    def __str__(self) -> str:
        return self._core.summary

    def __repr__(self) -> str:
        verdicts = [row for row in self.table if row["order"] == "all"]
        return "<lamella.Report " + "; ".join(
            f"{row['model']} {row['side']}: {row['verdict']}" for row in verdicts) + ">"


def compare(stack: Union[Stack, Model, str], models: Union[ModelLike, Iterable[ModelLike], None] = None,
            wi: Any = None, *, grid: Optional[tuple[int, int]] = None,
            estimator: Optional[str] = None, walks: Optional[float] = None,
            tolerance: Optional[float] = None, target_error: Optional[float] = None,
            time: Optional[float] = None, max_order: Optional[int] = None,
            thin_from: Optional[int] = None, sampling: Optional[str] = None,
            walk_order_1: Optional[bool] = None,
            seed: Optional[int] = None,
            threads: Optional[int] = None, isa: Optional[str] = None,
            progress: Optional[bool] = None) -> Report:
    """Judges models by the truth of a stack, as `lamella compare` does.

    stack: as in simulate(); or the truth is a Model, or a measured material (.binary, .bsdf), whose
        reflection from above is projected onto cells: it has no orders, and of the other arguments
        wi and grid count.
    models: one or a list of Model, Python functions (see Model), and texts as --model takes them
        ("eon,roughness=0.5"); a text takes what it leaves open from the stack, a Model is fixed.
        None: every closed form that applies to the stack.
    The others are those of simulate().
    """
    if models is None:
        listed: list[Any] = []
    elif isinstance(models, (str, Model)) or callable(models):
        listed = [models]
    else:
        listed = list(models)
    given = keywords(wi=incident(wi), grid=grid, estimator=estimator, walks=walks,
                     tolerance=tolerance, target_error=target_error, time=time,
                     max_order=max_order, thin_from=thin_from, sampling=sampling,
                     walk_order_1=walk_order_1, seed=seed, threads=threads, isa=isa)
    judged = [as_model(m) for m in listed]
    if isinstance(stack, Model) or is_measured(stack):
        if not judged:
            raise ValueError("models: found none; allowed: one or more, as nothing says which "
                             "apply to a measured material")
        measured = stack if isinstance(stack, Model) else Model(cast(str, stack))
        report, warnings = _core.compare_measured(measured._core, judged, given, shown(progress))
    else:
        report, warnings = _core.compare(as_stack(stack)._core, judged, given, shown(progress))
    warn(warnings, report.interrupted)
    return Report(report)
