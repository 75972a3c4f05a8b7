"""Simulations and solves: closed forms, and the numbers of the command line."""

import math
import pickle
import threading
import time

import numpy as np
import pytest
from conftest import BALL, CART, ROOT, ctrl_c_after, without_seconds

import hangtime as ht

G = 9.81


def test_ball_falls_and_bounces_as_the_formula_says():
    run = ht.scene(BALL, "ball").simulate(h="120 cm", e=0.7, method="event")
    fall = math.sqrt(2 * 1.2 / G)
    assert run.status == "solved"
    assert [event.kind for event in run.events] == ["impact"]
    event = run.events[0]
    assert event.time == pytest.approx(fall, abs=1e-8)
    assert event.v_after[0] == pytest.approx(-0.7 * event.v_before[0], rel=1e-9)
    t = 0.55
    after = t - fall
    state = run.at(t)
    # Between rows the motion is a parabola, which the cubic holds exactly.
    assert state["z"] == pytest.approx(0.7 * G * fall * after - G / 2 * after**2, abs=1e-7)
    assert state["dot(z)"] == pytest.approx(0.7 * G * fall - G * after, abs=1e-6)
    assert run.at(0.2)["dot(z)"] == pytest.approx(-G * 0.2, abs=1e-7)
    assert run.units["z"] == "m" and run.units["dot(z)"] == "m/s"
    assert run["z"].shape == run.time.shape and not run["z"].flags.writeable


@pytest.mark.parametrize(
    "name, words, keywords",
    [
        ("ski-jump", [], {}),
        ("ski-jump", ["--set", "start_y=8.264m", "--method", "event"], {"start_y": "8.264m", "method": "event"}),
        ("pump-track", ["--set", "speed=15km/h", "--horizon", "2"], {"speed": "15 km/h", "horizon": 2}),
        ("bouncing-ball", ["--method", "moreau", "--steps", "300"], {"method": "moreau", "steps": 300}),
    ],
)
def test_simulation_is_that_of_the_command_line_digit_for_digit(command, name, words, keywords):
    status, output, _ = command("simulate", name, *words, "--json")
    run = ht.scenes[name].simulate(**keywords)
    assert without_seconds(run.json) == without_seconds(output)
    assert (status == 0) == (run.status == "solved")


def test_solve_has_the_optimum_of_the_formula_and_the_digits_of_the_command_line(command, tmp_path):
    (tmp_path / "cart.hang").write_text(CART)
    _, output, _ = command("solve", tmp_path / "cart.hang", "--set", "d=1.5", "--intervals", 10, "--json")
    best = ht.load(tmp_path / "cart.hang").solve(d=1.5, intervals=10)
    assert without_seconds(best.json) == without_seconds(output)
    assert best.objective == pytest.approx(2 * math.sqrt(2 * 1.5), rel=1e-6)
    assert best.stationarity in ("S", "B") and best.optima and best.resimulated < 1e-6
    assert np.abs(best.controls).max() == pytest.approx(1, abs=1e-5)
    again = pickle.loads(pickle.dumps(best))
    assert again.json == best.json and again.svg == best.svg


def test_mistakes_print_as_the_command_line_prints_them(command, tmp_path, ball_file):
    bad = tmp_path / "bad.hang"
    bad.write_text("coordinates { z: m }\nlagrangian dot(z)^2*weight\n")
    _, _, error = command("simulate", bad)
    with pytest.raises(ht.Mistake) as caught:
        ht.load(bad)
    assert str(caught.value) == error.rstrip("\n")
    ball = ht.load(ball_file)
    for words, keywords in [
        (["--set", "hh=1"], {"hh": 1}),
        (["--set", "h=1kg"], {"h": "1kg"}),
        (["--set", "h=nan"], {"h": math.nan}),
        (["--set", "e=2"], {"e": 2}),
        (["--steps=0"], {"steps": 0}),
        (["--method=other"], {"method": "other"}),
        (["--horizon=-1s"], {"horizon": "-1s"}),
    ]:
        _, _, error = command("simulate", ball_file, *words)
        with pytest.raises(ht.Mistake) as caught:
            ball.simulate(**keywords)
        assert str(caught.value) == error.rstrip("\n")


def test_runs_pickle_and_show_themselves():
    ball = pickle.loads(pickle.dumps(ht.scene(BALL, "ball")))
    run = ball.simulate(h=2)
    again = pickle.loads(pickle.dumps(run))
    assert again.json == run.json
    np.testing.assert_array_equal(again["z"], run["z"])
    assert again.svg.startswith("<svg") or "<svg" in again.svg
    assert "<table>" in run._repr_html_() and "<iframe" in run.play()._repr_html_()
    assert "h" in ball._repr_html_() and "ball" in repr(run)
    frame = run.to_pandas()
    assert list(frame["z"]) == list(run["z"]) and frame.attrs["units"]["z"] == "m"
    assert run.plot("z", "dot(z)").get_legend() is not None


def test_ctrl_c_ends_a_solve_with_the_best_motion_or_at_once():
    begin = time.monotonic()
    try:
        # Without a signal this takes minutes.
        with ctrl_c_after(1.5):
            best = ht.scenes.pump_track.solve(intervals=400, starts=500)
        assert best.status == "interrupted" and len(best.time)
    except KeyboardInterrupt:
        pass
    assert 1.4 < time.monotonic() - begin < 30


def test_ctrl_c_ends_a_simulation():
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt), ctrl_c_after(0.3):
        ht.scene(BALL, "ball").simulate(method="moreau", steps=1_000_000)
    assert time.monotonic() - begin < 30


def test_lock_is_released_while_a_run_goes_on_and_progress_is_told():
    said, counted = [], 0
    ball = ht.scene(BALL, "ball")

    def run():
        ball.simulate(method="moreau", steps=1_000_000, progress=lambda at, words: said.append((at, words)))

    thread = threading.Thread(target=run)
    thread.start()
    while thread.is_alive():
        counted += 1
        time.sleep(0.001)
    # While the lock is held, this thread sleeps; it would count to 2.
    assert counted > 20
    assert said and all(0 <= at <= 0.6 and words for at, words in said)
    assert [at for at, _ in said] == sorted(at for at, _ in said)


def test_readme_runs(tmp_path, monkeypatch):
    text = (ROOT / "python" / "README.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    said = {}
    exec(text.split("```python\n")[1].split("```")[0], said)
    assert said["best"].status == "solved" and len(said["table"]) == 3


def test_the_chapter_of_the_book_runs(tmp_path, monkeypatch):
    text = (ROOT / "docs" / "book" / "src" / "python.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    blocks = text.split("```python\n")[1:]
    said = {"__name__": "__main__"}
    for block in blocks:
        exec(block.split("```")[0], said)
    assert said["run"].status == said["best"].status == "solved"
    assert list(said["table"]["max(z)"]) == [0.5, 0.7, 0.9]
    # Nothing pushes it along the floor: x = speed t.
    assert said["speed"] == pytest.approx(2.0 / 0.6, rel=1e-9)


def test_restitution_of_a_measured_drop_is_found_with_its_deviation(tmp_path):
    fall, times = math.sqrt(2 / G), [0.05 * k for k in range(1, 20)]
    z = [1 - G / 2 * t**2 if t < fall else 0.8 * G * fall * (t - fall) - G / 2 * (t - fall) ** 2 for t in times]
    (tmp_path / "drop.csv").write_text("t,z\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(times, z)))
    (tmp_path / "ball.hang").write_text(
        "parameters { m: kg = 1, g: m/s^2 = 9.81 } free e in 0..=1 = 0.5 coordinates { z: m } "
        "lagrangian m/2*dot(z)^2 - m*g*z surface floor: z >= 0 impact floor: restitution e start { z: 1 [m] } "
        'measured drop: "drop.csv" { z within 1 [cm] } minimize misfit(drop)'
    )
    found = ht.load(str(tmp_path / "ball.hang")).solve()
    assert isinstance(found, ht.Estimate) and found.status == "solved"
    assert found.values["e"] == pytest.approx(0.8, abs=1e-9)
    slopes = [G * fall * (t - fall) / 0.01 for t in times if t > fall]
    assert found.deviations["e"] == pytest.approx(sum(s * s for s in slopes) ** -0.5, rel=1e-6)
    assert found.covariance.shape == (1, 1) and found.correlation[0, 0] == 1
    assert len(found.experiments[0]["time"]) == 19 and "+-" in repr(found)


def test_mistakes_are_what_python_calls_them_as_well(tmp_path):
    ball = ht.scene(BALL)
    run = ball.simulate()
    for kind, wrong in [
        (KeyError, lambda: run["y"]),
        (KeyError, lambda: run.final["y"]),
        (KeyError, lambda: ht.scenes["no-such"]),
        (FileNotFoundError, lambda: ht.load(tmp_path / "no.hang")),
        (TypeError, lambda: ball.simulate(metod="event")),
        (TypeError, lambda: ball.simulate(h=[1])),
        (TypeError, lambda: run.at("now")),
        (ValueError, lambda: run.at(1e9)),
    ]:
        with pytest.raises(kind) as raised:
            wrong()
        assert isinstance(raised.value, ht.Mistake) and str(raised.value).startswith("error: ")
    assert "did you mean" in str(pytest.raises(ht.Mistake, lambda: ball.simulate(horizn=1)).value)


def test_sample_is_the_motion_at_times_of_ones_own():
    run = ht.scene(BALL).simulate(h=1.0, e=0.5)
    times = [0.1, 0.4, 0.55, 0.2]
    sampled = run.sample(times)
    fall = math.sqrt(2 / G)
    assert list(sampled) == list(run) and list(sampled["time"]) == times
    for t, z in zip(times, sampled["z"]):
        wanted = 1 - G / 2 * t**2 if t < fall else 0.5 * G * fall * (t - fall) - G / 2 * (t - fall) ** 2
        # The tolerance of a simulation is 1e-6.
        assert z == pytest.approx(wanted, abs=1e-5)
    with pytest.raises(ht.Mistake, match="was not simulated"):
        run.sample([0.1, 2.0])


def test_tables_are_looked_for_beside_the_scene_wherever_the_working_folder_is(tmp_path, monkeypatch):
    fall = math.sqrt(2 / G)
    rows = "".join(f"{t!r},{1 - G / 2 * t * t!r}\n" for t in (0.1, 0.2, 0.3, 0.9 * fall))
    (tmp_path / "fall.csv").write_text("t,z\n" + rows)
    (tmp_path / "fall.hang").write_text(
        "free g: m/s^2 in 1..=20 = 9 coordinates { z: m } lagrangian 1[kg]/2*dot(z)^2 - 1[kg]*g*z "
        'start { z: 1 [m] } measured fall: "fall.csv" { z within 1 [cm] } minimize misfit(fall)'
    )
    monkeypatch.chdir(tmp_path)
    scene = ht.load("fall.hang")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert scene.solve().values["g"] == pytest.approx(G, abs=1e-8)
