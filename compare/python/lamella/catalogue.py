"""What there is: models, media, built-in stacks."""

from __future__ import annotations

from typing import Any

from . import _core


def models() -> list[dict[str, Any]]:
    """Every closed form: a list of dictionaries with `name`, `doc`, `source`, `lobes` (names),
    `needs_stack`, and `parameters` (each with `name`, `doc`, `unit`, `default`, `allowed`)."""
    return _core.models()


def media() -> list[dict[str, Any]]:
    """Every medium of layers: a list of dictionaries with `name`, `doc`, `source`, and
    `parameters` as in models(); albedo, thickness and density are keys of every layer."""
    return _core.media()


def stacks() -> list[dict[str, Any]]:
    """Every built-in stack: a list of dictionaries with `name`, `doc`, `source` and `toml`."""
    return _core.stacks()
