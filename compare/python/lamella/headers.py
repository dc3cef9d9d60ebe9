"""The C header of models in shared objects."""

from __future__ import annotations

import os


def include_folder() -> str:
    """The folder that holds lamella_model.h, which a model in C or C++ includes: cc -I..."""
    return os.path.dirname(os.path.abspath(__file__))
