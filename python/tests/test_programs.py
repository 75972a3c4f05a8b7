"""Programs from files: closed forms, and the numbers of the command line."""

import math
import pickle
import time

import numpy as np
import pytest
from conftest import ctrl_c_after, without_seconds

import hangtime as ht


def heading(rows, nonlinear, variables, linear):
    return (
        f"g3 1 1 0\n 2 {rows} 1 0 0\n {nonlinear}\n 0 0\n {variables}\n 0 0 0 1\n 0 0 0 0 0\n {linear}\n 0 0\n 0 0 0 0 0\n"
    )


def lines(*words):
    return "".join(f"{word}\n" for word in words)


def corner(s, x="2 0", y="3"):
    """``min (x - 2)^2 + (y - 1)^2`` where ``0 <= x`` complements ``y - s >= 0``: 1 at (2, 0) for ``s = 0``."""
    body = ["C0", "o1", "v1", f"n{s}", "O0 0", "o0", "o5", "o1", "v0", "n2", "n2", "o5", "o1", "v1", "n1", "n2"]
    return heading(1, "0 1 1", "0 2 0", "0 0") + lines(*body, "r", "5 1 1", "b", x, y)


def chain(n):
    """The chained valley of Rosenbrock with ``n`` variables, far from its end: ``sum 100 (x_(i+1) - x_i^2)^2 + (1 - x_i)^2``."""
    sums = ["o54", str(2 * (n - 1))]
    for i in range(n - 1):
        sums += ["o2", "n100", "o5", "o1", f"v{i + 1}", "o5", f"v{i}", "n2", "n2"]
        sums += ["o5", "o1", "n1", f"v{i}", "n2"]
    top = f"g3 1 1 0\n {n} 0 1 0 0\n 0 1\n 0 0\n 0 {n} 0\n 0 0 0 1\n 0 0 0 0 0\n 0 0\n 0 0\n 0 0 0 0 0\n"
    starts = [f"x{n}", *(f"{i} {-1.2 if i % 2 else 1}" for i in range(n))]
    return top + lines("O0 0", *sums, *starts, "r", "b", *["3"] * n)


def valley(a):
    """``min x^2 + 3 y^2`` where ``x + y >= a`` and ``x <= 1``.

    Without the bound ``x = 3 y = 3 a/4``; for ``a > 4/3`` it holds ``x`` at 1, and ``y = a - 1``: the objective is
    ``1 + 3 (a - 1)^2``, its rate with the row ``6 (a - 1)``, and with the bound ``2 - 6 (a - 1)``.
    """
    body = ["C0", "n0", "O0 0", "o0", "o5", "v0", "n2", "o2", "n3", "o5", "v1", "n2"]
    body += ["r", f"2 {a!r}", "b", "1 1", "3", "k1", "1", "J0 2", "0 1", "1 1", "G0 2", "0 0", "1 0"]
    return heading(1, "0 1", "0 2 0", "2 2") + lines(*body)


@pytest.mark.parametrize("a", [2.5, 1.7])
def test_point_rows_and_bounds_have_the_rates_of_the_formula(tmp_path, a):
    path = tmp_path / "valley.nl"
    path.write_text(valley(a))
    (tmp_path / "valley.col").write_text("along\nacross\n")
    (tmp_path / "valley.row").write_text("wall\n")
    answer = ht.nlp(path)
    # Errors of a solution are its tolerance, 1e-8 times the scale of the program, over curvatures of the order of 1.
    assert answer.status == "solved" and answer.stationarity == "S" and answer.second_order
    assert answer.x == pytest.approx([1, a - 1], abs=1e-6)
    assert answer.objective == pytest.approx(1 + 3 * (a - 1) ** 2, rel=1e-6)
    assert answer.multipliers == pytest.approx([6 * (a - 1)], rel=1e-6)
    assert answer.upper_multipliers[0] == pytest.approx(2 - 6 * (a - 1), rel=1e-6)
    assert abs(answer.upper_multipliers[1]) + np.abs(answer.lower_multipliers).max() < 1e-6
    assert (answer.variables, answer.rows) == (["along", "across"], ["wall"])
    assert answer["across"] == answer.x[1] and not answer.x.flags.writeable
    with pytest.raises(ht.Mistake, match="along, across"):
        answer["accross"]


def test_program_has_the_digits_and_the_solution_file_of_the_command_line(command, tmp_path):
    path = tmp_path / "corner.nl"
    for s, x, y in [(0.0, "2 0", "3"), (3.0, "2 1", "1 1")]:
        path.write_text(corner(s, x, y))
        _, output, _ = command("nlp", path, "--sol", tmp_path / "c.sol", "--json")
        answer = ht.nlp(str(path))
        assert without_seconds(answer.json) == without_seconds(output)
        assert answer.sol == (tmp_path / "c.sol").read_text()
        # Everything in the document is an attribute.
        for name in set(answer.document) - {"schema", "file"}:
            assert name == "diagnosis" or getattr(answer, name) is not None
        again = pickle.loads(pickle.dumps(answer))
        assert again.json == answer.json and (again.x == answer.x).all()
        assert answer.status in repr(answer) and answer.status in answer._repr_html_()
    assert answer.status == "locally_infeasible" and "c[0]" in answer.diagnosis


def test_options_act_and_progress_is_told(tmp_path):
    path = tmp_path / "corner.nl"
    path.write_text(corner(0.0))
    limited = ht.nlp(path, max_iter=1)
    assert limited.status == "iteration_limit" and limited.iterations["interior_point"] <= 1
    close = ht.nlp(path, tol=1e-10, constr_viol_tol=1e-9, starts=3, warm_start=True)
    assert close.status == "solved" and close.iterations["interior_point"] > 3
    assert close.x == pytest.approx([2, 0], abs=1e-8)
    said = []
    ht.nlp(path, progress=lambda at, words: said.append(words))
    for words, options in [
        ("did you mean `max_iter`", {"max_iters": 3}),
        ("`tol`: found `-1", {"tol": -1}),
        ("`tol`: found `nan`", {"tol": math.nan}),
        ("`starts`: found `0`; give a whole number from 1", {"starts": 0}),
        ("`max_iter`: found `2.5`", {"max_iter": 2.5}),
        ("`warm_start` is list", {"warm_start": []}),
    ]:
        with pytest.raises(ht.Mistake) as caught:
            ht.nlp(path, **options)
        assert words in str(caught.value), str(caught.value)


def test_ctrl_c_ends_a_program_with_the_point_that_it_has_reached(tmp_path):
    path = tmp_path / "chain.nl"
    path.write_text(chain(20_000))
    said = []
    begin = time.monotonic()
    # Without a signal this takes minutes.
    with ctrl_c_after(1.0):
        answer = ht.nlp(path, starts=50, progress=lambda at, words: said.append(words))
    assert time.monotonic() - begin < 20
    assert answer.status == "interrupted" and answer.x.shape == (20_000,) and np.isfinite(answer.x).all()
    assert said

    def broken(at, words):
        raise ZeroDivisionError(words)

    with pytest.raises(ZeroDivisionError):
        ht.nlp(path, starts=50, progress=broken)


def test_files_that_are_no_programs_are_refused_as_by_the_command_line(command, tmp_path):
    path = tmp_path / "bad.nl"
    texts = ["", "g3 1 1 0\n", corner(0.0)[:120], corner(0.0).replace("o5", "o99"), "nonsense\n" * 20]
    for text in texts:
        path.write_text(text)
        status, _, error = command("nlp", path)
        with pytest.raises(ht.Mistake) as caught:
            ht.nlp(path)
        assert status == 2 and str(caught.value) == error.rstrip("\n")
    path.unlink()
    with pytest.raises(ht.Mistake, match="bad.nl"):
        ht.nlp(path)
    for wrong in (None, 3, b"bad.nl", ["bad.nl"]):
        with pytest.raises(ht.Mistake):
            ht.nlp(wrong)
