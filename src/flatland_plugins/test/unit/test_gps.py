"""Gps: every fix against PROJ's conversion, or against the ellipsoid's own numbers."""

import math
from typing import Any, Tuple

import numpy as np
import pyproj
import pytest
from sensor_msgs.msg import NavSatFix, NavSatStatus

from flatland_plugins.geodesy import Geodetic, TangentPlane
from flatland_server.geometry import Pose

GPS = "type: Gps, name: gps, body: base"
FIX = "/gps/fix"

GEOD = pyproj.Geod(ellps="WGS84")

LATITUDES = (-80.0, -45.0, -12.3456789, 0.0, 1e-9, 30.0, 51.5, 80.0)
LONGITUDES = (-0.1278, 100.0, 179.999999, 180.0, -180.0)
OFFSETS = [(east, north) for east in (-1e3, -1.5, 0.0, 500.0, 1e3) for north in (-1e3, 0.0, 1e3)]


def proj(latitude: float, longitude: float) -> pyproj.Transformer:
    """PROJ's conversion of east, north and up of a place to longitude, latitude and altitude."""
    return pyproj.Transformer.from_pipeline(
        "+proj=pipeline +ellps=WGS84 "
        f"+step +inv +proj=topocentric +lat_0={latitude!r} +lon_0={longitude!r} +h_0=0 "
        "+step +inv +proj=cart +step +proj=unitconvert +xy_in=rad +xy_out=deg"
    )


def by_proj(reference: Tuple[float, float], east: float, north: float) -> Geodetic:
    longitude, latitude, altitude = proj(*reference).transform(east, north, 0.0)
    return Geodetic(latitude, longitude, altitude)


def metres_between(a: Any, b: Any) -> float:
    """The distance of two places [m], along the ellipsoid or in altitude."""
    _, _, distance = GEOD.inv(a.longitude, a.latitude, b.longitude, b.latitude)
    return max(distance, abs(a.altitude - b.altitude))


@pytest.mark.parametrize("longitude", LONGITUDES)
@pytest.mark.parametrize("latitude", LATITUDES)
def test_positions_agree_with_proj_within_a_millimetre(latitude, longitude):
    plane = TangentPlane(latitude, longitude)

    for offset in OFFSETS:
        place = plane.to_geodetic(*offset)
        assert metres_between(place, by_proj((latitude, longitude), *offset)) < 1e-6
        assert -180.0 <= place.longitude < 180.0


@pytest.mark.parametrize("distance", [0.0, 1e-3, 1.0, 1e3, 1e5, 1e7])
@pytest.mark.parametrize("reference", [(90.0, 0.0), (-90.0, 33.0), (89.9999, -180.0), (45.0, 7.0)])
def test_at_poles_and_far_away_positions_convert_back_exactly(reference, distance):
    plane, transformer = TangentPlane(*reference), proj(*reference)

    for eighth in range(8):
        heading = eighth * math.pi / 4
        offset = (distance * math.sin(heading), distance * math.cos(heading), 0.0)
        latitude, longitude, altitude = plane.to_geodetic(*offset[:2])
        back = transformer.transform(longitude, latitude, altitude, direction="INVERSE")
        assert back == pytest.approx(offset, abs=1e-6)
        assert -90.0 <= latitude <= 90.0
        assert -180.0 <= longitude < 180.0


@pytest.mark.parametrize("reference", [(0.0, 0.0), (49.9, 8.9), (-33.86, 180.0)])
def test_the_fix_is_where_the_antenna_is(files, reference):
    latitude, longitude = reference
    gps = f"{GPS}, ref_lat: {latitude}, ref_lon: {longitude}, origin: [2, -1, 0.3]"
    robot = files.robot(gps, pose="[300, -400, 0.5]").run()

    fix = robot.last(FIX)

    antenna = Pose(300.0, -400.0, 0.5).apply(2.0, -1.0)
    assert metres_between(fix, by_proj(reference, *antenna)) < 1e-3


def test_the_fix_follows_the_robot(files):
    drive = "type: DiffDrive, name: drive, body: base"
    robot = files.robot(f"{GPS}, ref_lat: 60, ref_lon: 25", drive).drive(2.0)

    fixes = robot.record(FIX, 5.0)

    # The fix of time t is made before the step from t on.
    for fix in fixes:
        expected = by_proj((60.0, 25.0), 2.0 * fix.header.stamp.to_sec(), 0.0)
        assert metres_between(fix, expected) < 1e-3
    assert len(fixes) == 50


def test_the_fix_says_that_it_is_perfectly_accurate(files):
    fix = files.robot(GPS).run().last(FIX)

    assert fix.status == NavSatStatus(NavSatStatus.STATUS_FIX, NavSatStatus.SERVICE_GPS)
    assert list(fix.position_covariance) == [0.0] * 9
    assert fix.position_covariance_type == NavSatFix.COVARIANCE_TYPE_KNOWN


def test_its_noise_has_the_published_covariance(files):
    robot = files.robot(f"{GPS}, noise_std_dev: 0.5", pose="[30, -40, 0]")

    fixes = robot.record(FIX, 30.0)

    transformer = proj(0.0, 0.0)
    places = [(fix.longitude, fix.latitude, fix.altitude) for fix in fixes]
    errors = np.array([transformer.transform(*each, direction="INVERSE")[:2] for each in places])
    errors -= [30.0, -40.0]
    assert np.abs(errors.mean(axis=0)).max() < 0.1
    assert np.cov(errors.T) == pytest.approx(0.25 * np.eye(2), abs=0.06)
    assert list(fixes[0].position_covariance) == [0.25, 0, 0, 0, 0.25, 0, 0, 0, 0]


def test_the_antenna_frame_has_the_plugins_name_and_origin(files):
    robot = files.robot(f"{GPS}, origin: [0.5, -0.25, 1]").run()

    [transform] = robot.transport.transforms.values()
    assert (transform.parent, transform.child) == ("base", "gps")
    assert tuple(transform.pose) == (0.5, -0.25, 1.0)
