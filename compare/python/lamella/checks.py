"""A battery of checks for a BSDF: what its developer runs on every change."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Sequence
from typing import Any, Optional, Union

from . import _core
from .directions import keywords
from .fits import Family
from .lobes import Path
from .models import Model, ModelLike
from .progress import shown, warn
from .stacks import Stack, as_stack


class Check:
    """What the battery found. str() is the table of `lamella check`, in a notebook it draws its
    page; it is true where no check failed."""

    def __init__(self, core: Any) -> None:
        self._core = core
        self.answer: dict[str, Any] = json.loads(core.answer)

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return self.answer["verdict"] == "pass"

    @property
    def checks(self) -> dict[str, dict[str, Any]]:
        """By name: `claim`, `verdict` ("pass", "fail", "undecided", "skipped"), `cases`,
        `undecided`, and `worst`, the worst case found: `text`, `found`, `allowed`, `request`, `wi`,
        `wo`."""
        return {line["name"]: line for line in self.answer["checks"]}

    @property
    def failures(self) -> dict[str, str]:
        """The worst case of each check that failed, in words."""
        return {name: line["worst"]["text"] for name, line in self.checks.items()
                if line["verdict"] == "fail"}

    @property
    def interrupted(self) -> bool:
        """Whether cases are missing."""
        return self._core.interrupted

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the page, as `lamella check --html` does."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._core.page)

    def __bool__(self) -> bool:
        return self.passed

    def _repr_html_(self) -> str:
        return ('<iframe style="width: 100%; height: 800px; border: 0" srcdoc="'
                + html.escape(self._core.page) + '"></iframe>')

    def __str__(self) -> str:
        return self._core.text

    def __repr__(self) -> str:
        return f"<lamella.Check {self.answer['request']}: {self.answer['verdict']}" + "".join(
            f"; {name}: {text}" for name, text in self.failures.items()) + ">"


def check(model: Union[ModelLike, Family], *, stack: Union[Stack, str, None] = None,
          reciprocal: Optional[bool] = None, quick: bool = False,
          configurations: Optional[int] = None, samples: Optional[int] = None,
          time: Optional[float] = None, seed: Optional[int] = None,
          threads: Optional[int] = None, isa: Optional[str] = None,
          library: Optional[Path] = None, entries: Union[str, Sequence[str]] = (),
          max_error: Optional[float] = None, progress: Optional[bool] = None) -> Check:
    """Values, reciprocity, batches, energy, albedo, density, samples and weights of a model, as
    `lamella check` finds them.

    model: a text as --model takes it, or a shared object's path: keys that are given stay, the
        others vary over their ranges; a Family varies over its own; a Model or a Python function
        is checked as it is.
    stack: of a text that names a model which is built from a stack.
    reciprocal: whether f(w_i, w_o) = f(w_o, w_i) is claimed. None: as the model itself does; a
        Python function claims nothing.
    quick: 5 configurations, 3 angles and 4000 samples: seconds.
    configurations, samples (per direction): at most; default 24 and 20000. time [s]: after which
        no further case is begun, default 60.
    library: a folder of `lamella library build`, whose entries that the model claims are checks
        beside the battery: the relative RMSE over the cells of all directions and both sides, the
        noise of walks removed, may be `max_error` (default 0.1). A closed form claims the entries
        whose stack it is made for; any model, functions among them, those in `entries`, "NAME" or
        "NAME,key=value,..." with keys of a text or a Family.

    Functions are called with arrays; of the pairs that are looked at, few are asked for alone.
    """
    for option, number, least in ("configurations", configurations, 1), ("samples", samples, 256):
        if number is not None and not (number == int(number) and number >= least):
            raise ValueError(f"--{option}: found \"{number}\"; allowed: a whole number from {least}")
    given = keywords(quick=quick or None, time=time, seed=seed, threads=threads, isa=isa,
                     max_error=max_error)
    if isinstance(model, (Model, Family)):
        what: Any = model._core
    elif isinstance(model, (str, os.PathLike)):
        what = os.fspath(model)
    else:
        what = Model(model)._core
    if stack is not None and not isinstance(what, str):
        raise ValueError("check: found a stack beside a model; allowed: beside a text")
    found, warnings = _core.check(
        what, None if stack is None else as_stack(stack)._core, reciprocal,
        None if configurations is None else int(configurations),
        None if samples is None else int(samples), "" if library is None else os.fspath(library),
        [entries] if isinstance(entries, str) else list(entries), given, shown(progress))
    warn(warnings, found.interrupted)
    return Check(found)
