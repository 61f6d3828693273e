"""The benchmark of the EKF measures a filter that works: it maps all tags and knows where it is."""

from server.benchmarks import ekf


def test_the_filter_that_is_timed_maps_every_tag_and_keeps_its_place():
    result = ekf.measure((100,), 300)
    assert result["mapped_100"] == 100
    assert result["off_m_100"] < 1.0
    assert result["update_us_p50_100"] > 0.0
    assert result["numpy_dense_us_100"] > 0.0
