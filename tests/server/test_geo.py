"""UTM, MGRS and the georeference: against published values, an integral, and themselves."""

from math import cos, hypot, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from server.geo.earth import A_M, F, ecef_m, enu_from_ecef, geodetic
from server.geo.georeference import ControlPoint, GeometryError, Georeference, solve
from server.geo.mgrs import from_mgrs, to_mgrs
from server.geo.utm import from_utm, to_utm, zone_of

LAT, LON = st.floats(-79.9, 83.9), st.floats(-179.99, 179.99)


def test_published_places():
    """The CN Tower (Wikipedia, UTM) and the examples in the manual of GeographicLib's GeoConvert."""
    tower = to_utm(43 + 38 / 60 + 33.24 / 3600, -(79 + 23 / 60 + 13.7 / 3600))
    assert (tower.zone, tower.north) == (17, True)
    assert hypot(tower.easting_m - 630084, tower.northing_m - 4833438) < 1.0
    example = to_utm(33.3, 44.4)
    assert example.zone == 38
    assert hypot(example.easting_m - 444140.54, example.northing_m - 3684706.36) < 0.01
    assert to_mgrs(33.3, 44.4) == "38S MB 44140 84706"
    assert from_mgrs("38SMB4488") == pytest.approx((33.33424, 44.40363), abs=1e-5)
    assert (zone_of(60.0, 5.0), zone_of(78.0, 15.0), zone_of(60.0, -180.0)) == (32, 33, 1)


@pytest.mark.parametrize("lat_deg", [-79.0, -30.0, 0.0, 12.3, 48.1, 83.0])
def test_on_the_central_meridian_the_northing_is_the_arc_of_the_meridian(lat_deg):
    e2 = F * (2.0 - F)
    arc, _ = quad(lambda lat: A_M * (1 - e2) / sqrt(1 - e2 * sin(lat) ** 2) ** 3, 0.0, radians(lat_deg))
    utm = to_utm(lat_deg, 9.0, 32)
    assert utm.easting_m == pytest.approx(500_000.0, abs=1e-6)
    assert utm.northing_m - (0.0 if lat_deg >= 0 else 1e7) == pytest.approx(0.9996 * arc, abs=1e-5)


@given(LAT, LON)
def test_utm_and_mgrs_lead_back(lat, lon):
    assert from_utm(to_utm(lat, lon)) == pytest.approx((lat, lon), abs=1e-10)
    back = from_mgrs(to_mgrs(lat, lon))
    off = np.linalg.norm(ecef_m(*back) - ecef_m(lat, lon))
    assert off < 0.8  # the middle of its square metre


@given(LAT, LON, st.floats(-500.0, 8000.0))
def test_the_earth_leads_back(lat, lon, height):
    assert geodetic(ecef_m(lat, lon, height)) == pytest.approx((lat, lon, height), abs=1e-7)
    turn = enu_from_ecef(lat, lon)
    assert np.allclose(turn @ turn.T, np.eye(3))


@pytest.mark.parametrize(
    "text", ["", "32U", "32UPU1", "61UPU", "32UAA00", "32IPU00", "32U PU 123456 123456", "x" * 99]
)
def test_what_is_no_grid_reference_is_refused(text):
    with pytest.raises(ValueError, match="grid reference"):
        from_mgrs(text)


def test_beyond_utm_is_said():
    with pytest.raises(ValueError, match="beyond UTM"):
        to_mgrs(85.0, 10.0)


@given(LAT, LON, st.floats(-pi, pi), st.floats(-800.0, 800.0), st.floats(-800.0, 800.0))
def test_control_points_give_the_georeference_back(lat, lon, yaw, x, y):
    true = Georeference(lat, lon, yaw)
    assert true.to_map(*true.to_earth(x, y)) == pytest.approx((x, y), abs=1e-4 + 1e-7 * (x * x + y * y))
    places = [(x, y), (x + 40.0, y - 7.0), (x, y + 25.0)]
    for chosen in (places[:2], places):
        found = solve([ControlPoint(*place, *true.to_earth(*place)) for place in chosen])
        assert found.sd_m < 0.01
        for place in [(0.0, 0.0), *places]:
            there = np.array(ecef_m(*found.to_earth(*place))) - ecef_m(*true.to_earth(*place))
            assert np.linalg.norm(there) < 0.05


def test_north_is_where_yaw_says():
    """At a yaw of 90 degrees the map's x axis points north, as the console draws it without georeference."""
    lat, lon = Georeference(48.0, 11.0, pi / 2).to_earth(100.0, 0.0)
    assert lat - 48.0 == pytest.approx(100.0 / 111_200, rel=1e-2)
    assert lon == pytest.approx(11.0, abs=1e-9)


def test_bad_geometry_is_refused_with_what_to_do():
    here = Georeference(48.0, 11.0, 0.3)

    def point(x, y, dx=0.0):
        return ControlPoint(x, y, *here.to_earth(x + dx, y))

    for points, words in (
        ([point(0, 0)], "give two"),
        ([point(0, 0), point(0.5, 0.5)], "apart"),
        ([point(0, 0), point(0, 0)], "apart"),
        ([point(0, 0), point(20, 0, 15.0)], "on the map and"),
        ([point(0, 0), point(20, 0), point(0, 20, 30.0)], "do not fit"),
        ([point(0, 0), ControlPoint(20, 0, -12.0, 100.0)], "km apart"),
    ):
        with pytest.raises(GeometryError, match=words):
            solve(points)
    residual = solve([point(0, 0), point(20, 0, 1.0)]).sd_m
    assert 0.3 < residual < 0.8
    assert cos(solve([point(0, 0), point(20, 0, 1.0)]).yaw_rad) == pytest.approx(cos(0.3), abs=1e-6)
