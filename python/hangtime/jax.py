"""Motions in JAX: ``import hangtime.jax``.

Exact derivatives through impacts, as of :meth:`hangtime.Scene.gradient`, under ``grad``, ``jvp``, ``jacrev``, ``vmap`` and ``jit``. They
are NaN by what they do not exist by. With ``jax_enable_x64`` they have all digits.
"""

from __future__ import annotations

from typing import Any, Mapping, Sequence, Union

import jax
import jax.numpy as jnp
import numpy as np

from ._layer import Layer
from ._scene import Scene


def simulate(
    scene: Scene,
    parameters: Mapping[str, Any],
    of: Union[str, Sequence[str]],
    **keywords: Any,
) -> jax.Array:
    """Values at the end of a motion as an array, shape (.., values), that is differentiable by its parameters.

    ``parameters`` are arrays by name, in the declared units; together they are broadcast to batches, which are simulated side by side.
    ``of`` names coordinates, velocities ``dot(z)``, states, outputs, and times of events ``event_times[0]``. Keywords are those of
    :meth:`hangtime.Scene.simulate`.
    """
    layer = Layer(scene, list(parameters), of, keywords)

    def called(places: jax.Array) -> Any:
        shape = (*places.shape[:-1], len(layer.of))
        shapes = [jax.ShapeDtypeStruct(shape, places.dtype), jax.ShapeDtypeStruct((*shape, places.shape[-1]), places.dtype)]

        def host(places: Any) -> Any:
            return [np.asarray(array, dtype=places.dtype) for array in layer.all(np.asarray(places))]

        return jax.pure_callback(host, shapes, places, vmap_method="broadcast_all")

    @jax.custom_jvp
    def values(places: jax.Array) -> jax.Array:
        return called(places)[0]

    # The rows are linear in the tangent, so that this gives derivatives backwards as well.
    @values.defjvp
    def _tangents(primals: Any, tangents: Any) -> Any:
        found, rows = called(primals[0])
        return found, jnp.einsum("...vp,...p->...v", rows, tangents[0])

    arrays = [jnp.asarray(value, dtype=jnp.result_type(float)) for value in parameters.values()]
    return values(jnp.stack(jnp.broadcast_arrays(*arrays), -1))
