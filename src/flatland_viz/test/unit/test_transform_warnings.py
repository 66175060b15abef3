"""Warnings of transforms, which come hundreds of times a second."""

from flatland_viz.transform_warnings import TransformWarnings


def test_a_warning_that_goes_on_is_reported_once_a_second_with_its_number():
    reports = []
    warnings = TransformWarnings(lambda text, times: reports.append((text, times)))
    for hundredth in range(250):
        warnings.note("repeated: odom", 100.0 + hundredth / 100)
    warnings.note("repeated: base", 102.4)
    assert reports == [("repeated: odom", 20), ("repeated: odom", 100), ("repeated: odom", 100)]


def test_a_warning_that_comes_no_more_has_ended():
    warnings = TransformWarnings(lambda text, times: None)
    warnings.note("old", -1e9)
    warnings.note("new", 1e12)
    assert warnings.expired() == ["old"]
    assert warnings.expired() == []
