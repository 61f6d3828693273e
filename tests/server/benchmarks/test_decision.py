"""The benchmark of decisions times the steps in which robots plan."""

from server.benchmarks import decision


def test_it_tells_a_cost_for_every_team():
    found = decision.measure({"tags": (1, 2), "full": (2,)}, 26.0)
    costs = {name: found.pop(name) for name in list(found) if name.endswith("_ms")}
    assert costs.keys() == {"tags_1_robots_ms", "tags_2_robots_ms", "full_2_robots_ms"}
    assert all(cost > 0.0 for cost in costs.values())
    assert found["tags_largest_by_smallest"] >= 1.0
