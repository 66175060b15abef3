"""Values of all kinds in fields of all kinds: each is refused, or in its field's range."""

import json

import pytest
from without_ros import run_program, run_without_ros


@pytest.mark.slow
@pytest.mark.parametrize("run", [run_program, run_without_ros], ids=["ros", "ours"])
def test_values_of_all_kinds_are_refused_or_in_range(run):
    output = run("import hostile_values; hostile_values.main()")

    plain, wire = map(json.loads, output.splitlines())
    assert plain["refused"] > plain["taken"] > 1000
    assert min(wire.values()) > 500
