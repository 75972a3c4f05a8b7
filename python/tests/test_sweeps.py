"""Sweeps: one table, whoever computes it."""

import fcntl
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from conftest import BALL, CART

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
    fresh = ProcessPoolExecutor(2, multiprocessing.get_context("spawn"))
    for executor in (ThreadPoolExecutor(1), ThreadPoolExecutor(3), fresh):
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
    with pytest.raises(ht.Mistake, match="ends with .csv"):
        ht.sweep(ball, OVER, record=RECORD, store=tmp_path / "s.feather")
    # What is stored is not computed again: no executor is asked.
    assert ht.sweep(ball, OVER, record=RECORD, executor=object(), store=store).csv == whole


def test_parquet_is_written_when_all_rows_are_known_and_read_to_the_last_digit(ball, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    store, rows = tmp_path / "s.parquet", tmp_path / "s.parquet.csv"
    with ThreadPoolExecutor(2) as executor:
        table = ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store)
    assert not rows.exists()
    pandas.testing.assert_frame_equal(pandas.read_parquet(store), table.to_pandas())
    # What is stored is not computed again: no executor is asked.
    assert ht.sweep(ball, OVER, record=RECORD, executor=object(), store=store).csv == table.csv
    with pytest.raises(ht.Mistake, match="another sweep"):
        ht.sweep(ball, OVER, record=RECORD, store=store, method="event")
    # A killed run has left rows beside it.
    store.unlink()
    rows.write_text(table.csv[: len(table.csv) // 2])
    with ThreadPoolExecutor(2) as executor:
        assert ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store).csv == table.csv
    assert store.exists() and not rows.exists()
    # A file of others holds none of its rows.
    table.to_pandas().to_parquet(store)
    with pytest.raises(ht.Mistake, match="another sweep"):
        ht.sweep(ball, OVER, record=RECORD, store=store)


def test_store_of_either_is_resumed_by_the_other(command, ball, ball_file, tmp_path):
    store = tmp_path / "s.csv"
    over = {"h": [0.5, 1.0, 1.5], "e": [0, 0.5]}
    words = ["--over", "h=0.5,1.0,1.5", "--over", "e=0,0.5", "--record", "final.z", "--out", store, "--resume"]
    with ThreadPoolExecutor(1) as executor:
        whole = ht.sweep(ball, over, record=["final.z"], executor=executor, store=store).csv
        lines = whole.splitlines(keepends=True)
        store.write_text("".join(lines[:3]))
        status, output, _ = command("sweep", ball_file, *words)
        assert status == 0 and "2 of them from before" in output
        assert store.read_text() == whole
        store.write_text("".join(lines[:5]))
        assert ht.sweep(ball, over, record=["final.z"], executor=executor, store=store).csv == whole


def test_lost_worker_leaves_whole_rows_from_which_the_sweep_goes_on(ball, tmp_path):
    class Failing(ThreadPoolExecutor):
        calls = 0

        def submit(self, call, *args):
            self.calls += 1
            if self.calls == 3:
                call, args = lost, ()
            return super().submit(call, *args)

    def lost():
        raise OSError("worker lost")

    store = tmp_path / "s.csv"
    with Failing(1) as executor, pytest.raises(OSError, match="worker lost"):
        ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store)
    text = store.read_text()
    # The rows of two calls, and the headings.
    assert text.endswith("\n") and 2 < text.count("\n") < 120
    with ThreadPoolExecutor(2) as executor:
        whole = ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store).csv
        assert whole.startswith(text) and whole.count("\n") == 121
        assert whole == ht.sweep(ball, OVER, record=RECORD, executor=executor).csv


def test_sweep_draws_a_line_and_a_map_with_marked_changes(ball):
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
    frame = table.to_pandas()
    assert list(frame["point"]) == list(range(6)) and set(frame["message"]) == {""}
    assert list(frame["final.z [m]"]) == list(table["final.z"])


def test_warm_table_is_that_of_the_command_line_however_it_is_computed(command, tmp_path):
    path, store = tmp_path / "cart.hang", tmp_path / "s.csv"
    path.write_text(CART)
    cart = ht.load(path)
    over = {"m": [2, 2.6], "d": np.linspace(0.5, 1.7, 5)}
    values = ",".join(repr(float(d)) for d in over["d"])
    words = ["--what", "solve", "--warm=2", "--over", "m=2,2.6", "--over", f"d={values}", "--record", "objective"]
    assert command("sweep", path, *words, "--out", "c.csv", "--", "--intervals", 4, cwd=tmp_path)[0] == 0
    wanted = (tmp_path / "c.csv").read_text()
    more = {"what": "solve", "record": ["objective"], "intervals": 4, "warm": 2}
    with ThreadPoolExecutor(2) as executor:
        table = ht.sweep(cart, over, executor=executor, store=store, **more)
        assert table.csv == wanted
        # Cut within a chain and at its end.
        for rows in (2, 3, 8):
            store.write_text("".join(wanted.splitlines(keepends=True)[: 1 + rows]))
            assert ht.sweep(cart, over, executor=executor, store=store, **more).csv == wanted
            assert store.read_text() == wanted
        with pytest.raises(ht.Mistake, match="another sweep"):
            ht.sweep(cart, over, executor=executor, store=store, **{**more, "warm": 3})
    m, d = table["m"], table["d"]
    # The tolerance of the solver is 1e-8, and the plan is polished.
    np.testing.assert_allclose(table["objective"], 2 * np.sqrt(m * d), rtol=1e-7)
    for warm in (0, 1, -1, 2.5, "3", [2]):
        with pytest.raises(ht.Mistake, match="warm"):
            ht.sweep(cart, over, executor=object(), **{**more, "warm": warm})
    with pytest.raises(ht.Mistake, match="what solve"):
        ht.sweep(cart, over, executor=object(), what="simulate", warm=True)


LONG = """
import hangtime as ht, sys
if __name__ == "__main__":
    ball = ht.load(sys.argv[1])
    ht.sweep(ball, {"h": [0.5 + 0.01 * k for k in range(400)]}, record=["max(z)"], store=sys.argv[2], method="moreau", steps=STEPS)
"""


def _started(folder, ball_file, steps):
    script = folder / "long.py"
    script.write_text(LONG.replace("STEPS", str(steps)))
    return subprocess.Popen([sys.executable, script, ball_file, folder / "s.csv"], stderr=subprocess.PIPE, text=True)


def _children(process):
    found = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=False)
    return [int(child) for child in found.stdout.split()]


def _wait(until, seconds=60):
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_rows_come_by_time_and_ctrl_c_ends_with_a_word_and_whole_rows(ball_file, tmp_path):
    # A point takes about half a second: sixteen of them would take eight.
    process = _started(tmp_path, ball_file, 100_000)
    store = tmp_path / "s.csv"
    _wait(lambda: store.exists() and store.read_text().count("\n") > 2)
    process.send_signal(signal.SIGINT)
    pressed = time.monotonic()
    _, said = process.communicate(timeout=60)
    # A second, and as much for a busy machine.
    assert time.monotonic() - pressed < 2
    assert process.returncode != 0 and "--resume" in said
    text = store.read_text()
    assert text.endswith("\n") and 2 < text.count("\n") < 400


def test_workers_end_with_a_parent_that_was_killed(ball_file, tmp_path):
    process = _started(tmp_path, ball_file, 300_000)
    _wait(lambda: len(_children(process)) > 1)
    workers = _children(process)
    process.kill()
    process.communicate()
    _wait(lambda: not any(os.path.exists(f"/proc/{worker}") for worker in workers), 10)


def test_two_sweeps_do_not_write_one_store(ball, tmp_path):
    store = tmp_path / "s.csv"
    with ThreadPoolExecutor(2) as executor:
        whole = ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store).csv
        store.write_text(whole[:500])
        with open(store, "a") as other:
            fcntl.flock(other, fcntl.LOCK_EX)
            with pytest.raises(ht.Mistake, match="another sweep writes"):
                ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store)
        assert ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store).csv == whole
        store.write_text("notes")
        with pytest.raises(ht.Mistake, match="another sweep"):
            ht.sweep(ball, OVER, record=RECORD, executor=executor, store=store)
        assert store.read_text() == "notes"


def test_equal_distances_are_those_of_the_command_line(command, ball, ball_file, tmp_path):
    store = tmp_path / "s.csv"
    words = ["--over", "h=0.2:1.9:18", "--record", "max(z),time(impact floor 1)", "--out", store]
    assert command("sweep", ball_file, *words)[0] == 0
    # No executor is asked: all rows are those of the store.
    record = ["max(z)", "time(impact floor 1)"]
    table = ht.sweep(ball, {"h": np.linspace(0.2, 1.9, 18)}, record=record, executor=object(), store=store)
    np.testing.assert_allclose(table["max(z)"], table["h"], atol=1e-12)
    fall = np.sqrt(2 * table["h"] / 9.81)
    np.testing.assert_allclose(table["time(impact floor 1)"], np.where(fall < 0.6, fall, np.nan), atol=1e-6)
