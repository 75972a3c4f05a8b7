"""Motions in PyTorch: ``import hangtime.torch``.

Exact derivatives through impacts, as of :meth:`hangtime.Scene.gradient`: of a loss backwards, and of tangents forwards. They are NaN by
what they do not exist by.
"""

from __future__ import annotations

from typing import Any, Mapping, Sequence, Union

import numpy as np
import torch

from ._layer import Layer
from ._scene import Scene


class _Simulate(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, layer: Layer, places: torch.Tensor) -> torch.Tensor:
        values, rows = layer.all(places.detach().cpu().double().numpy())
        ctx.rows = torch.as_tensor(rows, dtype=places.dtype, device=places.device)
        return torch.as_tensor(values, dtype=places.dtype, device=places.device)

    @staticmethod
    def backward(ctx: Any, by: torch.Tensor) -> Any:
        return None, torch.einsum("...v,...vp->...p", by, ctx.rows)

    @staticmethod
    def jvp(ctx: Any, _layer: None, tangent: torch.Tensor) -> torch.Tensor:
        return torch.einsum("...vp,...p->...v", ctx.rows, tangent)


def simulate(
    scene: Scene,
    parameters: Mapping[str, Union[torch.Tensor, float]],
    of: Union[str, Sequence[str]],
    **keywords: Any,
) -> torch.Tensor:
    """Values at the end of a motion as a tensor, shape (.., values), that is differentiable by its parameters.

    ``parameters`` are tensors by name, in the declared units; together they are broadcast to batches, which are simulated side by side.
    ``of`` names coordinates, velocities ``dot(z)``, states, outputs, and times of events ``event_times[0]``. Keywords are those of
    :meth:`hangtime.Scene.simulate`.
    """
    tensors = [value if isinstance(value, torch.Tensor) else torch.as_tensor(np.float64(value)) for value in parameters.values()]
    return _Simulate.apply(Layer(scene, list(parameters), of, keywords), torch.stack(torch.broadcast_tensors(*tensors), -1))
