"""Plots as SVG: well-formed, everything named is in it, points are where they belong."""

import xml.etree.ElementTree as ET

import pytest

from gazetwin import svg
from gazetwin.svg import Line, Mark, Plot

NS = "{http://www.w3.org/2000/svg}"


def drawn(tmp_path, *plots):
    path = tmp_path / "plot.svg"
    svg.write(path, plots)
    return ET.parse(path).getroot()


def test_a_plot_is_well_formed_and_says_what_it_shows(tmp_path):
    plot = Plot("a < b", "time, s", "heading, deg", [Line("turn & stop", [0, 1, 2], [0, 5, 10])])
    plot.marks.append(Mark(1.0, 5.0, "published"))
    plot.band = (9.0, 11.0)
    words = [element.text for element in drawn(tmp_path, plot).iter(f"{NS}text")]
    for expected in ("a < b", "time, s", "heading, deg", "turn & stop", "published"):
        assert expected in words


def test_a_line_goes_from_corner_to_corner_of_its_ranges(tmp_path):
    plot = Plot("t", "x", "y", [Line("l", [0, 1], [0, 1])], x_range=(0, 1), y_range=(0, 1))
    line = next(drawn(tmp_path, plot).iter(f"{NS}polyline"))
    (x0, y0), (x1, y1) = (map(float, p.split(",")) for p in line.get("points").split())
    assert x0 < 0.2 * svg.WIDTH < 0.9 * svg.WIDTH < x1
    assert y1 < 0.2 * svg.HEIGHT < 0.8 * svg.HEIGHT < y0


def test_a_long_line_is_thinned_and_keeps_its_end(tmp_path):
    xs = list(range(30000))
    plot = Plot("t", "x", "y", [Line("l", xs, xs)])
    points = next(drawn(tmp_path, plot).iter(f"{NS}polyline")).get("points").split()
    assert len(points) < 1000
    assert float(points[-1].split(",")[0]) > 0.9 * svg.WIDTH


def test_plots_stand_below_each_other(tmp_path):
    one = Plot("one", "x", "y", [Line("l", [0, 1, 2], [1, 1, 1])])
    root = drawn(tmp_path, one, one)
    assert float(root.get("height")) == 2 * svg.HEIGHT


def test_a_plot_of_nothing_is_refused_by_its_title(tmp_path):
    with pytest.raises(ValueError, match="'empty' has no finite point"):
        drawn(tmp_path, Plot("empty", "x", "y", [Line("l", [0.0], [float("nan")])]))
