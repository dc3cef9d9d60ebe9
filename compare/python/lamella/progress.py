"""How far long work has got, on a terminal or in a notebook; warnings as Python's own."""

from __future__ import annotations

import sys
import warnings
from typing import Callable, Iterable, Optional

Show = Callable[[Optional[str]], None]


def _on_terminal(line: Optional[str]) -> None:
    sys.stderr.write("\r\x1b[K" if line is None else f"\r{line} \x1b[K")
    sys.stderr.flush()


class _InNotebook:
    """One output that is replaced, and emptied at the end."""

    def __init__(self) -> None:
        self._handle = None

    def __call__(self, line: Optional[str]) -> None:
        from IPython.display import Pretty, display

        if line is None and self._handle is None:
            return
        text = Pretty(line or "")
        if self._handle is None:
            self._handle = display(text, display_id=True)
        else:
            self._handle.update(text)


def shown(progress: Optional[bool]) -> Optional[Show]:
    """Who is told of progress. None: a notebook, or stderr if that is a terminal."""
    if progress is False:
        return None
    if "ipykernel" in sys.modules:
        return _InNotebook()
    if progress or sys.stderr.isatty():
        return _on_terminal
    return None


def warn(messages: Iterable[str], interrupted: bool) -> None:
    """Warnings of the compiled part, and of an interrupt, at the caller of the package."""
    for message in messages:
        warnings.warn(message, RuntimeWarning, stacklevel=4)
    if interrupted:
        warnings.warn("interrupted: what was done until then", RuntimeWarning, stacklevel=4)
