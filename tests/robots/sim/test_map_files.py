from math import pi
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from robots.sim.map_files import load_map
from robots.sim.world import WorldError

GOOD = """image: m.png
resolution: 0.05
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
REAL_MAPS = Path(__file__).parents[4] / "shared" / "data" / "maps"


def write(folder: Path, text: str = GOOD, pixels: np.ndarray | None = None, name: str = "m.png") -> Path:
    if pixels is None:
        pixels = np.full((8, 10), 254, dtype=np.uint8)
        pixels[0, :] = 0  # the top row is wall
        pixels[:, 9] = 205  # the right column is unknown
    Image.fromarray(pixels).save(folder / name)
    path = folder / "m.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", ["m.png", "m.pgm"])
def test_free_is_what_the_map_says_and_unknown_is_solid(tmp_path, name):
    world = load_map(write(tmp_path, GOOD.replace("m.png", name), name=name))
    inside = world.free[1:-1, 1:-1]
    assert inside.shape == (8, 10)
    assert inside[:7, :9].all()  # row 0 is the lowest
    assert not inside[7].any()
    assert not inside[:, 9].any()
    assert not world.free[0].any()
    assert world.origin_m == pytest.approx((-1.05, 1.95))


def test_negate_turns_black_and_white(tmp_path):
    pixels = np.full((8, 10), 255, dtype=np.uint8)
    pixels[2, 3] = 0
    world = load_map(write(tmp_path, GOOD.replace("negate: 0", "negate: 1"), pixels))
    assert world.free.sum() == 1
    assert world.free[1 + 7 - 2, 1 + 3]


def test_modes(tmp_path):
    values = np.array([[0, 10, 19, 20, 100, 101, 205, 254]] * 2, dtype=np.uint8)
    raw = load_map(write(tmp_path, GOOD + "mode: raw\n", values))
    assert raw.free[1, 1:-1].tolist() == [True, True, True, False, False, False, False, False]
    scale = load_map(write(tmp_path, GOOD + "mode: scale\n", values))
    assert scale.free[1, 1:-1].tolist() == [False] * 7 + [True]


def test_transparent_is_unknown(tmp_path):
    pixels = np.full((4, 4, 4), 255, dtype=np.uint8)
    pixels[1, 2, 3] = 0
    world = load_map(write(tmp_path, pixels=pixels))
    assert world.free.sum() == 15
    assert not world.free[1 + 2, 1 + 2]


def test_a_turned_map_is_turned_about_its_origin(tmp_path):
    pixels = np.full((20, 40), 254, dtype=np.uint8)
    pixels[19 - 5, 30] = 0  # lower left corner at (1.5, 0.25) of the image, metres
    quarter = load_map(write(tmp_path, GOOD.replace("2.0, 0.0]", f"2.0, {pi / 2}]"), pixels))
    assert quarter.free_area_m2 == pytest.approx((20 * 40 - 1) * 0.05**2, rel=0.01)
    x, y = -1.0 - 0.275, 2.0 + 1.525  # (1.525, 0.275) turned by 90 degrees about the origin
    assert not quarter.free[quarter.cell(x, y)]
    assert quarter.free[quarter.cell(x - 0.1, y)]
    slanted = load_map(write(tmp_path, GOOD.replace("2.0, 0.0]", "2.0, 0.5]"), pixels))
    assert slanted.free_area_m2 == pytest.approx((20 * 40 - 1) * 0.05**2, rel=0.03)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("image: m.png\n", "", "image is missing"),
        ("resolution: 0.05\n", "", "resolution is missing"),
        ("resolution: 0.05", "resolution: -1", "resolution -1"),
        ("resolution: 0.05", "resolution: .nan", "resolution has to be a finite number"),
        ("resolution: 0.05", "resolution: wide", "resolution has to be a finite number"),
        ("[-1.0, 2.0, 0.0]", "[1.0]", "origin has to be a list"),
        ("[-1.0, 2.0, 0.0]", "[1.0, north, 0]", "origin has to be a finite number"),
        ("negate: 0", "negate: maybe", "negate has to be 0 or 1"),
        ("free_thresh: 0.196", "free_thresh: 0.9", "free_thresh has to be smaller"),
        ("image: m.png", "image: other.png", "check image"),
        ("image: m.png", "image: m.yaml", "not an image"),
        ("image: m.png", "image: [1]", "image has to be the name"),
        ("negate: 0", "negate: 0\nmode: colourful", "mode 'colourful' is unknown"),
    ],
)
def test_a_bad_field_is_named(tmp_path, old, new, says):
    assert old in GOOD
    with pytest.raises(WorldError, match=says):
        load_map(write(tmp_path, GOOD.replace(old, new)))


def test_files_that_are_no_maps(tmp_path):
    with pytest.raises(WorldError, match="No such file"):
        load_map(tmp_path / "none.yaml")
    with pytest.raises(WorldError, match="expected the fields"):
        load_map(write(tmp_path, "- 1\n- 2\n"))
    with pytest.raises(WorldError, match="not a YAML file"):
        load_map(write(tmp_path, "image: [unclosed\n"))
    path = write(tmp_path, pixels=np.random.default_rng(0).integers(0, 255, (60, 60), dtype=np.uint8))
    with pytest.raises(WorldError, match="not a YAML file"):
        load_map(tmp_path / "m.png")
    (tmp_path / "m.png").write_bytes((tmp_path / "m.png").read_bytes()[:2000])
    with pytest.raises(WorldError, match="damaged"):
        load_map(path)


def test_nothing_free_is_an_error(tmp_path):
    with pytest.raises(WorldError, match="no free space"):
        load_map(write(tmp_path, pixels=np.zeros((5, 5), dtype=np.uint8)))


def test_absurd_size_is_refused_before_it_is_read(tmp_path):
    path = write(tmp_path, pixels=np.zeros((8000, 8000), dtype=np.uint8))
    with pytest.raises(WorldError, match="8000 x 8000 pixels are too many"):
        load_map(path)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "area_m2"), [("office-590", 590), ("hospital-500", 444), ("office-280", 280)]
)
def test_real_plans(name, area_m2):
    path = REAL_MAPS / f"{name}.yaml"
    if not path.is_file():
        pytest.skip("the real floor plans are not part of the project")
    assert load_map(path).free_area_m2 == pytest.approx(area_m2, rel=0.01)
