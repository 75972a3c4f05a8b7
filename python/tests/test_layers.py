"""Motions in PyTorch and JAX, against closed forms and differences."""

import numpy as np
import pytest

import hangtime as ht

#: Falls h, bounces with e.
BALL = """
parameters { h: m = 1, e = 0.5, push: m/s = 0 }
coordinates { z: m }
lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z
surface floor: z >= 0
impact floor: restitution e
start { z: h, dot(z): push }
horizon 0.6 [s]
"""

#: A rod that falls against a wall: a joint, an impact and friction.
ROD = """
parameters { l: m = 0.8, a0: rad = 1.1, e = 0.6, mu = 0.1 }
coordinates { x: m, z: m }
lagrangian 1[kg]/2*(dot(x)^2 + dot(z)^2) - 9.7[N]*z
joint rod: x^2 + z^2 == l^2
surface stop: x + 0.2[m] >= 0
impact stop: restitution e, friction mu, sliding dot(z)
start { x: l*sin(a0), z: -l*cos(a0) }
horizon 1.4 [s]
"""

#: A relay that switches while it drifts.
RELAY = """
parameters { a: 1/s^2 = 0.9, r: 1/s = 1.1, x0 = 0.3 }
states { x, y }
rates { x: a*t - sign(x)*r, y: sign(x)*0.7[1/s] + x*1[1/s] }
start { x: x0 }
horizon 2 [s]
"""

SCENES = [
    (BALL, {"h": 1.0, "e": 0.5, "push": 0.2}, ["z", "dot(z)", "event_times[0]"]),
    (ROD, {"l": 0.8, "a0": 1.1, "e": 0.6, "mu": 0.1}, ["x", "dot(z)"]),
    (RELAY, {"a": 0.9, "r": 1.1, "x0": 0.3}, ["y"]),
]

#: Motions for differences are accurate enough.
TIGHT = {"tolerance": 1e-12}


def differences(scene, parameters, of):
    """Central differences of the motion, shape (values, parameters): of an error of 1e-12/1e-5 and 1e-10."""
    from hangtime._layer import Layer

    layer = Layer(scene, list(parameters), of, TIGHT)
    place, columns = np.array(list(parameters.values())), []
    for k in range(len(place)):
        way = np.zeros(len(place))
        way[k] = 1e-5
        columns.append((layer.one(place + way)[0] - layer.one(place - way)[0]) / 2e-5)
    return np.array(columns).T


@pytest.mark.parametrize("text, parameters, of", SCENES)
def test_jax_has_the_derivatives_of_differences_forwards_and_backwards(text, parameters, of):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import hangtime.jax

    scene = ht.scene(text)
    right = differences(scene, parameters, of)

    def values(known):
        return hangtime.jax.simulate(scene, known, of, **TIGHT)

    for by in (jax.jacrev, jax.jacfwd, lambda f: jax.jit(jax.jacrev(f))):
        found = by(values)(parameters)
        rows = np.stack([np.asarray(found[name]) for name in parameters], -1)
        np.testing.assert_allclose(rows, right, rtol=1e-5, atol=1e-6)


def test_jax_simulates_batches():
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import hangtime.jax

    scene, heights = ht.scene(BALL), np.array([0.5, 1.0, 1.5])
    times = jax.vmap(lambda h: hangtime.jax.simulate(scene, {"h": h}, "event_times[0]", **TIGHT)[0])(heights)
    np.testing.assert_allclose(times, np.sqrt(2 * heights / 9.81), rtol=1e-9)
    by = jax.vmap(jax.grad(lambda h: hangtime.jax.simulate(scene, {"h": h}, "event_times[0]", **TIGHT)[0]))(heights)
    np.testing.assert_allclose(by, np.sqrt(0.5 / 9.81 / heights), rtol=1e-9)


@pytest.mark.parametrize("text, parameters, of", SCENES)
def test_torch_passes_its_check_of_gradients(text, parameters, of):
    torch = pytest.importorskip("torch")
    import hangtime.torch

    scene = ht.scene(text)
    tensors = [torch.tensor(value, dtype=torch.float64, requires_grad=True) for value in parameters.values()]

    def values(*known):
        return hangtime.torch.simulate(scene, dict(zip(parameters, known)), of, **TIGHT)

    assert torch.autograd.gradcheck(values, tensors, eps=1e-5, atol=1e-5, check_forward_ad=True)


def test_torch_learns_a_throw():
    torch = pytest.importorskip("torch")
    import hangtime.torch

    scene = ht.scene(BALL)
    push = torch.tensor(0.0, dtype=torch.float64, requires_grad=True)
    adam = torch.optim.Adam([push], lr=0.1)
    for _ in range(50):
        adam.zero_grad()
        loss = (hangtime.torch.simulate(scene, {"push": push}, "z")[0] - 0.3) ** 2
        loss.backward()
        adam.step()
    assert float(loss) < 1e-4


def test_what_a_layer_cannot_have_is_refused():
    from hangtime._layer import Layer

    with pytest.raises(ht.Mistake, match="objective"):
        Layer(ht.scene(BALL), ["h"], "objective", {})
    with pytest.raises(ht.Mistake, match="needs parameters"):
        Layer(ht.scene(BALL), [], "z", {})
