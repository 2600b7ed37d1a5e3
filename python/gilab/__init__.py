"""Run gilab's programs, and read what they write.

    import gilab
    run = gilab.run("ppm", "scenes/bulb.xml", size="256x256", spp=16)
    gilab.show(run.layers["RGB"])
    run.stats["technique"]["radius_mean"]

The programs are looked for in the folder of the environment variable GILAB_BIN, then in PATH.
"""

import csv
import json
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR

__all__ = ["GilabError", "Run", "merge", "program", "read_layers", "read_table", "run", "show", "tone_map"]

PROGRAMS = ("pathtrace", "irrcache", "radcache", "photonmap", "ppm", "instant-radiosity", "lightcuts")


class GilabError(Exception):
    """A program has refused its input; the text is its message."""


@dataclass
class Run:
    """What a run has left."""

    layers: dict  #: arrays by layer, see read_layers
    stats: dict  #: the statistics, see docs/formats.md
    tables: dict  #: arrays by flag, for the flags with table=True


def program(name):
    """The path of a program."""
    if name not in PROGRAMS:
        raise ValueError(f"{name} is no program of gilab: {', '.join(PROGRAMS)}")
    folder = os.environ.get("GILAB_BIN")
    found = shutil.which(name, path=folder) if folder else shutil.which(name)
    if not found:
        raise FileNotFoundError(f"cannot find {name}: set GILAB_BIN to its folder, for example target/release")
    return found


def run(name, scene, *, tables=(), **flags):
    """Run a program, and return its picture, statistics and tables.

    scene   path of the scene
    tables  flags that write a table as CSV, for example ("records_out",)
    flags   other flags: spp=16 is --spp 16, rule="cluster" is --rule cluster, no_gradients=True is --no-gradients, and a list gives the
            flag several times. Without out=PATH the picture is kept in memory only.
    """
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        out = Path(flags.pop("out", folder / "out.exr"))
        files = {flag: folder / f"{flag}.csv" for flag in tables}
        stats = folder / "stats.json"
        command = [program(name), str(scene), "-o", str(out), "--stats", str(stats), "--quiet", "--preview", "0"]
        command += _arguments({**flags, **files})
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise GilabError(ended.stderr.strip() or f"{name} ended with {ended.returncode}")
        read = {flag: read_table(path) for flag, path in files.items()}
        return Run(read_layers(out), json.loads(stats.read_text()), read)


def merge(name, scene, checkpoints, **flags):
    """Add up the passes of checkpoints, as --merge does."""
    return run(name, scene, merge=list(checkpoints), **flags)


def _arguments(flags):
    arguments = []
    for flag, value in flags.items():
        flag = "--" + flag.replace("_", "-")
        if value is True:
            arguments.append(flag)
        elif value is not None and value is not False:
            values = value if isinstance(value, (list, tuple)) else [value]
            for each in values:
                arguments += [flag, str(each)]
    return arguments


def read_layers(path):
    """The layers of an EXR as arrays of height x width (x 3), by name: "RGB", "Variance", "Direct", "Albedo", "N", "Z" and so on."""
    layers = {}
    for name, channel in OpenEXR.File(str(path)).channels().items():
        pixels = np.asarray(channel.pixels, dtype=np.float32)
        if pixels.ndim == 3 or "." not in name:
            layers[name] = pixels
        else:
            layer, component = name.rsplit(".", 1)
            layers.setdefault(layer, {})[component] = pixels
    for name, parts in layers.items():
        if isinstance(parts, dict):
            order = [c for c in ("R", "G", "B", "X", "Y", "Z") if c in parts]
            full = len(order) == len(parts) == 3
            layers[name] = np.stack([parts[c] for c in order], axis=-1) if full else parts
    return layers


def read_table(path):
    """A CSV file as a structured array: table["radius"] is a column. Columns that are not numbers are texts."""
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    columns = []
    for k in range(len(header)):
        values = [row[k] for row in rows]
        try:
            columns.append(np.array(values, dtype=np.float64))
        except ValueError:
            columns.append(np.array(values))
    table = np.empty(len(rows), dtype=[(name, c.dtype) for name, c in zip(header, columns)])
    for name, column in zip(header, columns):
        table[name] = column
    return table


def tone_map(rgb, exposure=0.0):
    """Linear radiance as sRGB in [0, 1], after multiplication by 2^exposure."""
    c = np.clip(np.asarray(rgb) * 2.0**exposure, 0.0, 1.0)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)


def show(rgb, exposure=0.0, axes=None):
    """Draw a picture of linear radiance with matplotlib. Returns the axes."""
    import matplotlib.pyplot as plt

    axes = axes or plt.gca()
    axes.imshow(tone_map(rgb, exposure))
    axes.set_axis_off()
    return axes
