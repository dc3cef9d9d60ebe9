"""lamella check: right models pass, wrong ones fail with the worst case, all end in finite time."""

import os
import time

from lamella_program import ProgramTest

PLUGINS = os.environ["LAMELLA_PLUGINS"]


def plugin(name):
    return os.path.join(PLUGINS, name + ".so")


def verdicts(answer):
    return {line["name"]: line["verdict"] for line in answer["checks"]}


def line_of(answer, name):
    return next(line for line in answer["checks"] if line["name"] == name)
