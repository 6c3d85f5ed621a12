"""A second reader of map files, for comparison: numpy and Pillow, no code in common with the crate.

For each file named it prints one line:
    width height resolution x y yaw sha256
where the hash is of the grid as signed bytes, row-major, lowest row first.
"""

import hashlib
import os
import sys

import numpy
from PIL import Image


def read_settings(path):
    """Keys and values of a YAML file of one key a line; a comment begins with ' #' or a line with '#'."""
    settings = {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            line = (" " + line.rstrip("\r\n")).split(" #")[0].strip()
            if line and line != "---":
                key, _, value = line.partition(":")
                settings[key.strip()] = value.strip().strip("'\"")
    return settings


def read_grey(path):
    """Grey values from 0 to 255, top row first, and where the image is opaque."""
    image = Image.open(path)
    if image.mode.startswith("I"):
        wide = numpy.array(image).astype(numpy.int64)
        return (wide + 128) // 257, numpy.ones(wide.shape, bool)
    if image.mode in ("LA", "PA", "RGBA") or "transparency" in image.info:
        rgba = image.convert("RGBA")
        return numpy.array(rgba.convert("RGB").convert("L")), numpy.array(rgba)[..., 3] == 255
    grey = numpy.array(image.convert("L"))
    return grey, numpy.ones(grey.shape, bool)


def read_map_server(path):
    settings = read_settings(path)
    grey, opaque = read_grey(os.path.join(os.path.dirname(path), settings["image"]))
    grey = grey.astype(numpy.int64)
    mode = settings.get("mode", "trinary")
    if mode == "raw":
        cells = numpy.where(grey <= 100, grey, -1)
    else:
        occupied, free = float(settings["occupied_thresh"]), float(settings["free_thresh"])
        p = grey / 255.0
        if settings["negate"] in ("0", "false"):
            p = 1.0 - p
        if mode == "scale":
            between = numpy.floor((p - free) / (occupied - free) * 100.0 + 0.5)
        else:
            between = numpy.full(p.shape, -1.0)
        cells = numpy.where(p >= occupied, 100, numpy.where(p <= free, 0, between))
        cells = numpy.where(opaque, cells, -1)
    origin = [float(number) for number in settings["origin"].strip("[]").split(",")]
    return cells, float(settings["resolution"]), origin


def read_movingai(path):
    with open(path, encoding="ascii") as file:
        lines = file.read().splitlines()
    height, width = int(lines[1].split()[1]), int(lines[2].split()[1])
    rows = [[0 if character in ".GS" else 100 for character in row] for row in lines[4 : 4 + height]]
    cells = numpy.array(rows)
    assert cells.shape == (height, width)
    return cells, 1.0, [0.0, 0.0, 0.0]


def main():
    for path in sys.argv[1:]:
        reader = read_movingai if path.endswith(".map") else read_map_server
        cells, resolution, origin = reader(path)
        grid = numpy.ascontiguousarray(numpy.flipud(cells).astype(numpy.int8))
        height, width = grid.shape
        digest = hashlib.sha256(grid.tobytes()).hexdigest()
        print(width, height, repr(resolution), *map(repr, origin), digest)


main()
