"""Wrong map files of layers: images and line segments."""

from typing import Dict

from wrong_files.case import DATA, LINES, MAP, Case

FORMATS = "BMP, GIF, JPEG, PNG, PPM, PCX, TGA, TIFF, WEBP"

# fmt: off
WRONG_MAPS: Dict[str, Case] = {
    # Maps of images
    "no image": (MAP, "image: map.png\n", "", 'map.yaml:1: the required key "image" is missing'),
    "an image of the world's name": (MAP, "map.png", "world.png",
     "map.yaml:1: image: expected a file, but world.png is not there"),
    "an image of another extension": (MAP, "map.png", "MAP.pgm",
     'map.yaml:1: image: expected a file, but MAP.pgm is not there (did you mean "map.png"?)'),
    "an image that is not there": (MAP, "map.png", "office.png",
     "map.yaml:1: image: expected a file, but office.png is not there"),
    "an empty name of an image": (MAP, "map.png", "''",
     "map.yaml:1: image: expected a file, found an empty string"),
    "an image that is no image": (MAP, "map.png", "lines.dat",
     f"lines.dat: is not an image of a known format: {FORMATS}"),
    "an empty image file": (MAP, "map.png", "empty.png",
     f"empty.png: is not an image of a known format: {FORMATS}"),
    "a truncated image": (MAP, "map.png", "cut.png",
     "cut.png: cannot be read as an image: image file is truncated"),
    "a corrupt image": (MAP, "map.png", "corrupt.png",
     "corrupt.png: cannot be read as an image: broken data stream when reading image file"),
    "no resolution": (MAP, "resolution: 0.05\n", "",
     'map.yaml:1: the required key "resolution" is missing'),
    "a resolution of zero": (MAP, "resolution: 0.05", "resolution: 0",
     "map.yaml:2: resolution: expected a number above 0, found 0"),
    "no origin": (MAP, "origin: [-1, -2, 0.5]\n", "",
     'map.yaml:1: the required key "origin" is missing'),
    "an origin without yaw": (MAP, "origin: [-1, -2, 0.5]", "origin: [-1, -2]",
     "map.yaml:3: origin: expected [x, y, yaw], found [-1, -2]"),
    "no threshold": (MAP, "occupied_thresh: 0.65\n", "",
     'map.yaml:1: the required key "occupied_thresh" is missing'),
    "a threshold that is no number": (MAP, "occupied_thresh: 0.65", "occupied_thresh: dark",
     'map.yaml:5: occupied_thresh: expected a number, found "dark"'),
    "an unknown key of a map": (MAP, "resolution: 0.05", "resolution: 0.05\nresolutoin: 0.05",
     'map.yaml:3: unknown key "resolutoin"'),
    # Maps of line segments
    "no data": (LINES, "data: lines.dat\n", "",
     'lines.yaml:1: the required key "data" is missing'),
    "a type in other words": (LINES, "line_segments", "Line_Segments",
     'lines.yaml:1: type: expected "line_segments" or an image, found "Line_Segments"'),
    "no scale": (LINES, "scale: 0.1\n", "", 'lines.yaml:1: the required key "scale" is missing'),
    "a scale of zero": (LINES, "scale: 0.1", "scale: 0",
     "lines.yaml:3: scale: expected a number above 0, found 0"),
    "an image's key": (LINES, "scale: 0.1", "scale: 0.1\nresolution: 0.1",
     'lines.yaml:4: unknown key "resolution"'),
    "three numbers in a line": (DATA, "2 3 -1 2", "2 3 -1",
     'lines.dat:2: expected four numbers, x1 y1 x2 y2, found "2 3 -1"'),
    "a word in a line": (DATA, "2 3 -1 2", "2 3 x 2",
     'lines.dat:2: expected four numbers, x1 y1 x2 y2, found "2 3 x 2"'),
    "three numbers before a comment": (DATA, "2 3 -1 2", "# a wall\n2 3 -1 # 2",
     'lines.dat:3: expected four numbers, x1 y1 x2 y2, found "2 3 -1"'),
    "NaN in a line": (DATA, "2 3 -1 2", "2 3 nan 2",
     'lines.dat:2: expected four numbers, x1 y1 x2 y2, found "2 3 nan 2"'),
    "data that is not text": (DATA, None, b"0 0 1 1\n\xff\xfe",
     "lines.dat: cannot be read: it is not UTF-8 text"),
}
# fmt: on
