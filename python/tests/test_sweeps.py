"""Sweeps: one table, whoever computes it."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from conftest import BALL

import hangtime as ht

OVER = {"h": np.linspace(0.2, 1.8, 40), "e": [0, 0.5, 1.5]}
RECORD = ["final.z", "final.dot(z)", "events"]


@pytest.fixture
def ball(ball_file):
    return ht.load(ball_file)


def test_table_is_that_of_the_command_line_for_any_executor(command, ball, ball_file, tmp_path):
    values = ",".join(repr(float(h)) for h in OVER["h"])
    words = ["--over", f"h={values}", "--over", "e=0,0.5,1.5", "--record", ",".join(RECORD), "--out", "c.csv"]
    assert command("sweep", ball_file, *words, cwd=tmp_path)[0] == 0
    wanted = (tmp_path / "c.csv").read_text()
    for executor in (ThreadPoolExecutor(1), ThreadPoolExecutor(3), ProcessPoolExecutor(2, multiprocessing.get_context("spawn"))):
        with executor:
            table = ht.sweep(ball, OVER, record=RECORD, executor=executor)
        # The mark holds the name under which the scene was read and its words: the same here.
        assert table.csv == wanted
    assert set(table["status"]) == {"solved", "refused"}
    assert np.isnan(table["final.z"][2]) and "restitution" in table[2]["message"]


def test_store_is_resumed_where_it_was_cut_and_refuses_other_sweeps(ball, tmp_path):
    store = tmp_path / "s.csv"
    with ThreadPoolExecutor(2) as executor:
        whole = ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store).csv
        assert store.read_text() == whole
        for cut in (0, 5, len(whole) // 2, len(whole) - 1):
            store.write_text(whole[:cut])
            assert ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store).csv == whole
            assert store.read_text() == whole
        with pytest.raises(ht.Mistake, match="another sweep"):
            ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store, method="event")
    # What is stored is not computed again: no executor is asked.
    assert ht.sweep(ball, OVER, record=RECORD, executor=object(), store=store).csv == whole


def test_stopped_consumer_leaves_whole_rows(ball, tmp_path):
    class Failing(ThreadPoolExecutor):
        left = 2

        def submit(self, *args):
            self.left -= 1
            if self.left < 0:
                raise OSError("worker lost")
            return super().submit(*args)

    store = tmp_path / "s.csv"
    with Failing(1) as executor, pytest.raises(OSError):
        ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store)
    text = store.read_text()
    assert text.endswith("\n")
    whole = ht.sweep(ball, OVER, record=RECORD, executor=ThreadPoolExecutor(2), store=store).csv
    assert whole.startswith(text) and len(whole) > len(text)


def test_sweep_draws_a_line_and_a_map_with_marked_changes(ball):
    import matplotlib

    matplotlib.use("Agg")
    with ThreadPoolExecutor(2) as executor:
        # From rest at h the first impact is at sqrt(2 h/g): within 0.6 s for h <= 1.7658 m.
        line = ht.sweep(ball, {"h": np.linspace(1.6, 1.9, 7)}, record=["final.z"], executor=executor)
        drawn = line.plot()
        marks = [each for each in drawn.lines if each.get_linestyle() == ":"]
        assert [mark.get_xdata()[0] for mark in marks] == [pytest.approx(1.775)]
        table = ht.sweep(
            ball, {"h": [1.6, 1.7, 1.9], "push": [-0.5, 0]}, record=["final.z"], executor=executor
        )
        assert len(table.plot("final.z").lines) > 0
    assert table.to_pandas().shape[0] == 6
