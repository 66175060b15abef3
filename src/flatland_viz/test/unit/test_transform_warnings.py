"""Warnings of transforms, which come hundreds of times a second."""

from flatland_viz.transform_warnings import TransformWarnings


def test_a_warning_is_reported_at_once_and_then_its_number_once_a_second():
    reports = []
    warnings = TransformWarnings(lambda text, times: reports.append((text, times)))
    for hundredth in range(250):
        warnings.note("repeated: odom", 100.0 + hundredth / 100)
    warnings.note("repeated: base", 102.4)
    assert reports == [
        ("repeated: odom", 1),
        ("repeated: odom", 100),
        ("repeated: odom", 100),
        ("repeated: base", 1),
    ]


def test_a_warning_that_comes_no_more_has_ended():
    warnings = TransformWarnings(lambda text, times: None)
    warnings.note("old", -1e9)
    warnings.note("new", 1e12)
    assert warnings.expired() == ["old"]
    assert warnings.expired() == []
