"""Checks the package and executes the notebook. Set GILAB_BIN, and start in the folder of the repository."""

import json
import os
import tempfile
from pathlib import Path

import gilab
import numpy as np

SCENE = "scenes/cornell-spheres.xml"


def check_runs(folder):
    run = gilab.run("ppm", SCENE, size="24x16", spp=2, photons=500, show=["radius", "photons"])
    assert run.layers["RGB"].shape == (16, 24, 3), run.layers["RGB"].shape
    parts = sum(run.layers[part] for part in ("Direct", "Indirect", "Caustic"))
    assert np.allclose(parts, run.layers["RGB"], rtol=1e-4, atol=1e-6)
    assert run.layers["Z"].shape == (16, 24)
    assert run.stats["passes"] == 2 and run.stats["program"] == "ppm"
    mean = run.layers["RGB"].mean(axis=(0, 1))
    assert np.allclose(mean, run.stats["mean_radiance"], rtol=1e-4), (mean, run.stats["mean_radiance"])


def check_merge(folder):
    flags = {"size": "24x16", "mode": "bdpt"}
    whole = gilab.run("pathtrace", SCENE, spp=4, **flags)
    kept = [folder / name for name in ("a", "b")]
    for first, path in zip((0, 3), kept):
        gilab.run("pathtrace", SCENE, spp=3 if first == 0 else 1, first_pass=first, checkpoint=path, **flags)
    merged = gilab.merge("pathtrace", SCENE, kept, **flags)
    for name, layer in whole.layers.items():
        assert np.array_equal(layer, merged.layers[name]), name


def check_errors(folder):
    try:
        gilab.run("pathtrace", folder / "nothing.xml")
    except gilab.GilabError as error:
        assert "nothing.xml" in str(error), error
    else:
        raise AssertionError("a scene that does not exist was rendered")


def check_notebook(folder):
    notebook = Path("python/notebooks/lecture.ipynb").resolve()
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    os.environ["GILAB_BIN"] = str(Path(os.environ["GILAB_BIN"]).resolve())
    os.environ.setdefault("GILAB_FIGURES", str(folder))
    os.chdir(notebook.parent)  # Jupyter starts there.
    scope = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), scope)  # noqa: S102, the repository's own notebook


for check in (check_runs, check_merge, check_errors, check_notebook):
    with tempfile.TemporaryDirectory() as folder:
        check(Path(folder))
    print(check.__name__, "passed")
