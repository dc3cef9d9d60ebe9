"""Pictures of lobes by matplotlib."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

# ITU-R BT.709-6, as wherever one number stands for three channels.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def _grey(values: Any) -> Any:
    return values[..., 0] if values.shape[-1] == 1 else values @ _LUMINANCE


def _in_plane(lobes: Any, values: Any) -> tuple[Any, Any]:
    """theta_o [degrees], negative on the side of the light, and f there: the columns next to the
    plane of incidence."""
    mu2 = lobes.mu_edges**2
    theta = np.degrees(np.arccos(np.sqrt((mu2[1:] + mu2[:-1]) / 2)))
    near = values[:, 0] if lobes.folded else (values[:, 0] + values[:, -1]) / 2
    columns = values.shape[1]
    far = values[:, -1] if lobes.folded else (values[:, (columns - 1) // 2]
                                              + values[:, columns // 2]) / 2
    return np.concatenate([-theta[::-1], theta]), np.concatenate([near[::-1], far])


def plot_lobes(lobes: Any, kind: str, side: str, lobe: str, direction: Optional[int],
               ax: Any) -> Any:
    if kind not in ("plane", "polar", "disc"):
        raise ValueError(f'kind: found "{kind}"; allowed: plane, polar, disc')
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError("plot needs the package matplotlib (Debian: python3-matplotlib)") \
            from None
    values = _grey(lobes[side, lobe])
    if kind == "disc":
        k = direction or 0
        picture = values[k]
        edges = lobes.phi_edges
        if lobes.folded:
            picture = np.concatenate([picture, picture[:, ::-1]], axis=1)
            edges = np.concatenate([edges, 2 * np.pi - edges[-2::-1]])
        if ax is None:
            ax = plt.subplot(projection="polar")
        # Radius sin(theta_o): equal areas for equal projected solid angles.
        radius = np.sqrt(np.maximum(1 - lobes.mu_edges**2, 0))
        ax.grid(False)
        mesh = ax.pcolormesh(edges, radius, picture, shading="flat")
        ax.figure.colorbar(mesh, ax=ax, label="f [1/sr]")
        ax.set_yticks([])
        ax.set_title(f"theta_i = {lobes.theta_i[k]:g}, {side}, {lobe}")
        return ax
    if ax is None:
        ax = plt.subplot(projection="polar") if kind == "polar" else plt.subplot()
    for k in range(len(values)) if direction is None else [direction]:
        theta, f = _in_plane(lobes, values[k])
        ax.plot(np.radians(theta) if kind == "polar" else theta, f,
                label=f"theta_i = {lobes.theta_i[k]:g}")
    if kind == "polar":
        ax.set_theta_zero_location("N" if side == "reflect" else "S")
        ax.set_theta_direction(-1 if side == "reflect" else 1)
    else:
        ax.set_xlabel("theta_o [degrees], negative on the side of the light")
        ax.set_ylabel("f [1/sr]")
    ax.legend()
    return ax
