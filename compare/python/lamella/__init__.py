"""Lamella: layered scattering media as ground truth for BSDF models.

A stack of layers is simulated (random walks) or solved (adding and doubling), closed forms are
evaluated beside it, and a report says lobe by lobe how far they are apart, noise told from error.

    import lamella as lm

    stack = lm.Stack.builtin("vmf_sand")              # or Stack.read(path), Stack.parse(text)
    lobes = lm.simulate(stack, wi=[60])               # truth on cells of the hemisphere
    lobes["reflect", "all"]                           # [direction, mu, phi, channel], f in 1/sr
    f, error = lm.truth(stack, wi, wo)                # truth at pairs of directions
    model = lm.Model("eon", albedo=0.8, roughness=0.5)
    report = lm.compare(stack, [model, my_function])  # my_function(wi, wo) -> f, on arrays
    lm.samples(stack, distribution="cosine")          # walks one by one, for training
    lm.furnace(stack)
    lm.check(my_function)                             # a battery for what you write
    lm.library("lamella-library")                     # reference lobes that were kept
    lm.fit("gold.binary", "eon,vmf_diffuse")          # the parameters that come nearest

Conventions. z is up, the macroscopic normal. Directions are unit vectors that point away from the
stack, w_i to the light, w_o to the viewer; arrays of them have shape (..., 3). f(w_i, w_o) [1/sr]
is the BSDF without the cosine: reflection where both lie on one side, else transmission. Arrays of
f end with an axis of channels: 1 (grey) or 3 (red, green, blue). Angles that are typed (`wi=`) are
degrees. All arrays are float64.

The same request gives the same numbers as the command line `lamella`, bit by bit.

Errors. What the command line refuses with status 2 raises ValueError with the same text; numbers
that are not finite raise ArithmeticError, files OSError. Ctrl-C ends long work at its next
checkpoint: simulate, truth, compare and furnace give what is there, with a RuntimeWarning and
`interrupted` set; a second Ctrl-C raises KeyboardInterrupt.
"""

from ._core import __version__
from .directions import directions
from .fits import Family, Fit, Fits, fit
from .furnaces import Furnace, furnace
from .checks import Check, check
from .catalogue import media, models, stacks
from .headers import include_folder
from .libraries import Library, LibraryEntry, library
from .lobes import Energies, Lobes, StandardErrors, read
from .models import Model
from .reports import Report, compare
from .samples import Samples, samples
from .stacks import Stack, interface, layer, substrate
from .truths import simulate, truth

__all__ = [
    "Check", "Energies", "Family", "Fit", "Fits", "Furnace", "Library", "LibraryEntry", "Lobes",
    "Model", "Report", "Samples", "Stack", "StandardErrors", "__version__", "check", "compare",
    "directions", "fit", "furnace", "include_folder", "interface", "layer", "library", "media",
    "models", "read", "samples", "simulate", "stacks", "substrate", "truth",
]
