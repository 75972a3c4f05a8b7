"""The notebooks run from top to bottom, with few points."""

import os
import pathlib

import pytest
from conftest import PROGRAM

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

EXAMPLES = sorted((pathlib.Path(__file__).resolve().parents[1] / "examples").glob("*.ipynb"))


def test_there_are_notebooks():
    assert len(EXAMPLES) >= 6


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_notebook_runs(path, monkeypatch, tmp_path):
    if "dask" in path.stem:
        pytest.importorskip("dask.distributed")
    if "pyomo" in path.stem:
        pytest.importorskip("pyomo", reason="Pyomo is not installed")
        folder = str(pathlib.Path(PROGRAM).parent)
        monkeypatch.setenv("PATH", folder + os.pathsep + os.environ["PATH"])
    monkeypatch.setenv("HANGTIME_SMALL", "1")
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert any(cell.get("outputs") for cell in notebook.cells)
