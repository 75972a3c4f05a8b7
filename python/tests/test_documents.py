"""Whatever the command line's JSON has, an attribute reaches: states, joints, derivatives, found parameters."""

import json
import math
import pickle

import numpy as np
import pytest
from conftest import BALL, CART, without_seconds

import hangtime as ht

G = 9.81
#: A coil that is switched on while a ball falls: `i = (volt/r) (1 - exp(-r t/ell))`.
COIL = """
parameters { r: Ohm = 2, ell: H = 0.5, volt: V = 3 }
coordinates { z: m }
states { i: A }
lagrangian 1[kg]/2*dot(z)^2 - 9.81[N]*z
rates { i: (volt - r*i)/ell }
surface floor: z >= 0
impact floor: restitution 0.5
start { z: 0.4 }
outputs { heat: W = r*i^2 }
horizon 0.5 [s]
"""
#: A pendulum on a rod, released where it is level; the force of the rod is `3 m g sin(angle)` along it.
PENDULUM = """
parameters { m: kg = 2, l: m = 1.5 }
coordinates { x: m, z: m }
lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*9.81[m/s^2]*z
joint rod: x^2 + z^2 == l^2
start { x: l }
horizon 0.4 [s]
"""
#: A sledge slides down a ramp whose angle is to be found: `s = t^2 g sin/2 = 2/cos`, fastest at 45 degrees.
RAMP = """
parameters { m: kg = 1, g: m/s^2 = 9.81 }
free angle: rad in 0.2..=1.4 = 0.5
coordinates { s: m }
lagrangian m/2*dot(s)^2 + m*g*s*sin(angle)
minimize time
finally { s*cos(angle) == 2 [m] }
horizon 1 [s]
"""
#: What the document calls otherwise, or has within others.
OTHERWISE = {"trajectory": "time", "quantities": "units"}


def reaches(run):
    """Every field of the document is an attribute, from numbers and, after pickling, from the text."""
    for name in run.document:
        assert getattr(run, OTHERWISE.get(name, name)) is not None, name
    again = pickle.loads(pickle.dumps(run))
    assert again.units == run.units
    for name in run:
        np.testing.assert_array_equal(again[name], run[name])
    trajectory = run.document["trajectory"]
    for part in set(trajectory) - {"numerical_time"}:
        np.testing.assert_array_equal(run._part(part), np.array(trajectory[part], dtype=float).reshape(run._part(part).shape))
    return again


def test_states_are_quantities_like_others(command, tmp_path):
    (tmp_path / "coil.hang").write_text(COIL)
    coil = ht.load(tmp_path / "coil.hang")
    run = coil.simulate()
    _, output, _ = command("simulate", tmp_path / "coil.hang", "--json")
    assert without_seconds(run.json) == without_seconds(output)
    again = reaches(run)
    # The default method is held to 1e-6 of the largest values.
    exact = 1.5 * (1 - np.exp(-4 * run.time))
    np.testing.assert_allclose(run["i"], exact, atol=2e-6)
    np.testing.assert_allclose(run["heat"], 2 * exact**2, atol=1e-5)
    assert run.units["i"] == "A" and again.final["i"] == run["i"][-1]
    fall = math.sqrt(2 * 0.4 / G)
    impact = run.events[0]
    assert impact.time == pytest.approx(fall, abs=1e-6)
    assert impact.states == pytest.approx([1.5 * (1 - math.exp(-4 * fall))], abs=2e-6)
    assert impact.contact_impulse == pytest.approx([1.5 * G * fall], rel=1e-5)
    assert run.at(fall / 2)["i"] == pytest.approx(1.5 * (1 - math.exp(-2 * fall)), abs=0.02)
    gradient = coil.gradient("volt", "ell")
    t = 0.5
    assert gradient.final["i"] == pytest.approx([(1 - math.exp(-4 * t)) / 2, -1.5 * math.exp(-4 * t) * 2 * t / 0.25], abs=2e-5)
    assert gradient.outputs["heat"].shape == (len(run.time), 2)


def test_forces_of_joints_are_arrays():
    run = ht.scene(PENDULUM, "pendulum").simulate()
    reaches(run)
    np.testing.assert_allclose(np.hypot(run["x"], run["z"]), 1.5, atol=1e-9)
    # The equation is a square: its force is that along the rod over the gradient's length, 2 l, or -3 m g z/l of it.
    force = run.joints["rod"]
    assert force.shape == run.time.shape
    np.testing.assert_allclose(np.abs(force), np.abs(3 * 2 * G * run["z"] / 1.5) / (2 * 1.5), atol=1e-4)


def test_parameters_that_are_found_and_derivatives_of_an_optimum():
    ramp = ht.scene(RAMP, "ramp")
    best = ramp.solve(intervals=2, gradient=["g", "m"])
    reaches(best)
    assert best.parameters["angle"] == best.free["angle"]["value"] == pytest.approx(math.pi / 4, abs=1e-7)
    assert best.free["angle"]["range"] == [0.2, 1.4] and best.free["angle"]["unit"] == "rad"
    # t = sqrt(2 2/(g sin cos)) = sqrt(8/g): dt/dg = -t/(2 g).
    t = math.sqrt(8 / G)
    assert best.objective == pytest.approx(t, rel=1e-8) and best.resimulated_objective == pytest.approx(t, rel=1e-6)
    assert best.gradient.with_respect_to == ["g", "m"]
    assert best.gradient.objective == pytest.approx([-t / (2 * G), 0], abs=1e-7)
    assert best.gradient.final_time == pytest.approx([-t / (2 * G), 0], abs=1e-7)
    given = ramp.solve(intervals=2, angle=0.6)
    assert given.free == {} and given.gradient is None
    assert given.objective == pytest.approx(math.sqrt(4 / (G * math.sin(0.6) * math.cos(0.6))), rel=1e-8)


def test_derivatives_of_a_motion_through_its_impact():
    ball = ht.scene(BALL, "ball")
    e, t = 0.5, 0.6
    fall = math.sqrt(2 / G)
    after = t - fall
    gradient = ball.gradient("h", "e", method="event")
    # z = e g fall after - g/2 after^2, with d fall/dh = fall/2 at h = 1.
    by_h = (e * G * (after - fall) + G * after) * fall / 2
    assert gradient.final["z"] == pytest.approx([by_h, G * fall * after], rel=1e-6)
    assert gradient.final["dot(z)"] == pytest.approx([(e + 1) * G * fall / 2, G * fall], rel=1e-6)
    assert gradient.event_times == pytest.approx(np.array([[fall / 2, 0]]), abs=1e-7)
    assert gradient.obstacle is None and "h, e" in repr(gradient)
    # Without names by all parameters; a coefficient at the end of its range has no derivative, and says why.
    assert ball.gradient().with_respect_to == ["h", "e", "push"]
    assert "restitution" in ball.gradient("e", e=0).obstacle
    for wrong in ({"gradient": []}, {"gradient": ["h", 3]}, {"gradient": 3}, {"gradient": "springiness"}):
        with pytest.raises(ht.Mistake):
            ball.simulate(**wrong)


def test_arrays_are_made_without_text():
    run = ht.scene(BALL, "ball").simulate()
    assert run["z"][-1] > 0 and run.final["dot(z)"] and run.units and run.at(0.1)["z"] > 0 and run.status == "solved"
    assert run._json is None and run._document is None, "a document was written for numbers that need none"
    assert run["z"].base is not None and not run["z"].flags.writeable


def test_fields_without_an_attribute_of_their_own_are_reached_and_others_are_not():
    run = ht.scene(BALL, "ball").simulate()
    run.document["measured"] = {"rows": 3}
    assert run.measured == {"rows": 3}
    for name in ("no_such_field", "_private", "__array_interface__"):
        assert not hasattr(run, name)


def test_solve_starts_from_another_plan():
    cart = ht.scene(CART, "cart")
    first = cart.solve(intervals=8)
    second = cart.solve(d=1.3, intervals=12, start=first)
    assert second.objective == pytest.approx(2 * math.sqrt(2 * 1.3), rel=1e-7)
    assert second.starts == 1 and second.status == "solved"
    cold = cart.solve(d=1.3, intervals=12)
    assert json.loads(second.json)["iterations"]["interior_point"] < cold.iterations["interior_point"]
    other = ht.scene(CART.replace("y: m }", "y: m, z: m }", 1).replace("dot(y)^2", "(dot(y)^2 + dot(z)^2)", 1), "two")
    for start, words in [(3, "what solve returned"), (pickle.loads(pickle.dumps(first)), "pickled")]:
        with pytest.raises(ht.Mistake, match=words):
            cart.solve(start=start)
    with pytest.raises(ht.Mistake, match="another scene"):
        other.solve(intervals=8, start=first)


def test_program_hangtime_comes_with_the_package(command, capfd, monkeypatch):
    from hangtime.__main__ import main

    for words in (["-v"], ["list"], ["simulate", "no-such-scene"]):
        status, output, error = command(*words)
        monkeypatch.setattr("sys.argv", ["hangtime", *words])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capfd.readouterr()
        assert (ended.value.code, said.out, said.err) == (status, output, error)
