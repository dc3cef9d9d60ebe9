import subprocess
import os

import numpy as np
import pytest

import lamella as lm


@pytest.fixture(autouse=True, scope="session")
def few_digits_lost():
    np.set_printoptions(precision=17)


@pytest.fixture
def run(tmp_path):
    """Runs the command line in a folder of its own and returns stdout; it must succeed."""
    def run(*arguments, stdin=""):
        done = subprocess.run([os.environ["LAMELLA"], *map(str, arguments)], input=stdin,
                              cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return done.stdout
    return run


@pytest.fixture
def refusal(tmp_path):
    """The text with which the command line refuses its arguments, without the program's name."""
    def refusal(*arguments, stdin=""):
        done = subprocess.run([os.environ["LAMELLA"], *map(str, arguments)], input=stdin,
                              cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == 2, (done.returncode, done.stderr)
        return done.stderr.strip().removeprefix("lamella: ")
    return refusal


@pytest.fixture(scope="session")
def pairs():
    """Forty pairs of directions above the surface, fixed."""
    rng = np.random.default_rng(1)
    def draw():
        return lm.directions(np.degrees(np.arccos(rng.uniform(0.05, 1, 40))),
                             rng.uniform(0, 360, 40))
    return draw(), draw()
