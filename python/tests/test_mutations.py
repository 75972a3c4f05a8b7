"""Calls with arguments of wrong types, shapes and values: exceptions by name, and an interpreter that lives on."""

import json
import math
import random
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import BALL
from matplotlib import pyplot
from test_programs import corner

import hangtime as ht

VALUES = [
    None, True, False, 0, -1, 1, 10**30, 1e308, -0.0, math.nan, math.inf, -math.inf, "", " ", "nan", "1e999",
    "5 furlong", "15 km/h", "-3 m", "\x00", "\ud800", "é", "a" * 10_000, "--help", "=", "h=1", b"bytes", [], [1, 2], (),
    {}, {"h": 1},
    set(), object(), 1j, np.float64(0.5), np.int32(3), np.array(2.0), np.array([1.0, 2.0]), np.zeros((2, 2)), np.nan,
    np.datetime64("2020-01-01"), lambda: 1, Exception, range(3), ht,
]
KEYS = [
    "h", "e", "push", "horizon", "method", "tolerance", "steps", "stages", "elements", "scheme", "rows", "time_limit",
    "parameters", "no_exit_condition", "unknown", "out", "json", "set", "gradient", "progress",
]
OPTIONS = ["tol", "constr_viol_tol", "max_iter", "time_limit", "starts", "warm_start", "progress", "unknown"]  # fmt: skip
#: What Python and the package raise by name; anything else is a mistake in the package.
NAMED = (ht.Mistake, TypeError, AttributeError, IndexError)


def mutated(choose, ball, run, table, program):
    """One call with something wrong in it."""
    value, other = choose.choice(VALUES), choose.choice(VALUES)
    key = choose.choice(KEYS)
    return choose.choice(
        [
            lambda: ball.simulate(**{"time_limit": 2, key: value}),
            lambda: ball.simulate(**{"method": "event", key: value, choose.choice(KEYS): other, "time_limit": 2}),
            lambda: ball.simulate(parameters={value if isinstance(value, str) else "h": other}, time_limit=2),
            lambda: ball.solve(**{key: value}),
            lambda: ball.explain(**{key: value}),
            lambda: ht.scene(value),
            lambda: ht.scene(BALL, value),
            lambda: ht.scene(mutilated(choose, BALL)).simulate(time_limit=2),
            lambda: ht.load(value),
            lambda: ht.scenes[value],
            lambda: run[value],
            lambda: run.at(value),
            lambda: run.plot(value),
            lambda: ball.gradient(value, other, time_limit=2),
            lambda: ball.solve(start=value),
            lambda: ht.nlp(value),
            lambda: ht.sweep(ball, {"h": [1, 2]}, executor=object(), store=choose.choice([value, f"{other}.csv"])),
            lambda: table[value],
            lambda: table.plot(value),
            lambda: run.play(value)._repr_html_(),
            lambda: run.play().save(value),
            lambda: ht.scene(BALL, "ball").simulate(parameters={"h": value, "e": other}, time_limit=2),
            lambda: ht.nlp(program, **{"time_limit": 2, choose.choice(OPTIONS): value}),
            lambda: mutilate_file(choose, program, value),
            lambda: ht.sweep(ball, {"h": [1, 2]}, executor=object(), warm=value),
            lambda: ht.sweep(ball, {"h": value}, executor=value),
            lambda: ht.sweep(ball, value, what=other),
            lambda: ht.sweep(value, {"h": [1]}),
            lambda: ht.sweep(ball, {"h": [value, other]}, record=value, executor=object()),
        ]
    )


def mutilate_file(choose, program, value):
    """A program with a part of it missing or replaced, or a file that is gone."""
    other = program.with_name("mutilated.nl")
    other.write_text(mutilated(choose, program.read_text()), encoding="utf-8")
    if value is None:
        other.unlink()
    ht.nlp(other, time_limit=2, max_iter=50)


def mutilated(choose, text):
    at, length = choose.randrange(len(text)), choose.randrange(1, 20)
    return text[:at] + choose.choice(["", "(", "}", "1e999", "z", "é", "\x00", "-"]) + text[at + length :]


@pytest.mark.parametrize("block", range(10))
def test_fifty_mutated_calls_raise_by_name(block, tmp_path, monkeypatch):
    program = tmp_path / "corner.nl"
    program.write_text(corner(0.0))
    choose = random.Random(block)
    ball = ht.scene(BALL, "ball")
    run = ball.simulate()
    with ThreadPoolExecutor(1) as executor:
        table = ht.sweep(ball, {"h": [1, 2]}, record=["final.z"], executor=executor)
    # Files that a call writes by a name that is none of ours.
    monkeypatch.chdir(tmp_path)
    for _ in range(50):
        call = mutated(choose, ball, run, table, program)
        try:
            call()
        except NAMED as error:
            assert "internal_error" not in str(error) and "panic" not in str(error)
    pyplot.close("all")
    np.testing.assert_array_equal(ball.simulate()["z"], run["z"])


def test_deleted_file_is_named_and_a_scene_stays_what_it_was(ball_file):
    ball = ht.load(ball_file)
    before = ball.simulate().json
    ball_file.write_text("nonsense")
    assert ball.simulate()["z"][-1] == ht.scene(BALL, "x").simulate()["z"][-1]
    ball_file.unlink()
    assert ball.simulate().document["final"] == json.loads(before)["final"]
    with pytest.raises(ht.Mistake, match="ball.hang"):
        ht.load(ball_file)
