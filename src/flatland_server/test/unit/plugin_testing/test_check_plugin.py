"""check_plugin: a plugin that keeps the contract passes, and each way to break it is named."""

import pytest
from plugin_testing.beacon import ENTRY, Beacon
from plugin_testing.broken_beacons import BROKEN, BrokenTwice

from flatland_server import PluginDeclaration, PluginLoader
from flatland_server.testing import PluginContractError, check_plugin
from flatland_server.testing.checked_plugin import CheckedPlugin
from flatland_server.testing.contract import CHECKS

pytestmark = pytest.mark.slow


def check(plugin, entry=ENTRY, **options):
    loader = PluginLoader([PluginDeclaration.of(plugin)])
    check_plugin({**entry, "type": plugin.__name__}, loader=loader, **options)


def test_a_plugin_that_keeps_the_contract_passes():
    check(Beacon)


@pytest.mark.parametrize(
    ("broken_in", "plugin", "expected"),
    [
        pytest.param(check, plugin, expected, id=plugin.__name__)
        for check, broken in BROKEN.items()
        for plugin, expected in broken.items()
    ],
)
def test_a_broken_plugin_is_told_what_was_expected_and_found(broken_in, plugin, expected):
    loader = PluginLoader([PluginDeclaration.of(plugin)])

    problems = broken_in(CheckedPlugin({**ENTRY, "type": plugin.__name__}, {}, {}, {}, loader, ()))

    assert expected in "\n".join(problems)


def test_the_problems_of_all_checks_are_told():
    assert set(BROKEN) == set(CHECKS)
    with pytest.raises(PluginContractError) as caught:
        check(BrokenTwice)

    first, *others = str(caught.value).splitlines()
    assert first == "BrokenTwice does not keep the contract:"
    assert [problem[: len("- expected no warning")] for problem in others] == [
        "- the plugin reads th",  # the first check
        "- expected no warning",  # the last one
        "- expected no warning",
    ]


def test_an_entry_without_all_keys_is_incomplete():
    entry = {key: value for key, value in ENTRY.items() if key not in ("frame", "limits")}

    with pytest.raises(PluginContractError) as caught:
        check(Beacon, entry)

    for key in ("frame", "limits", "limits.low"):
        assert f'reads the key "{key}", which the entry does not show' in str(caught.value)
    check(Beacon, entry, other_keys=["frame", "limits", "low", "high"])


def test_an_entry_that_is_refused_is_reported_as_such():
    with pytest.raises(PluginContractError, match=r"Beacon is refused as it is given:\n.*low"):
        check(Beacon, {**ENTRY, "limits": {"low": "nothing"}})


def test_an_entry_may_be_a_string():
    check_plugin(
        "type: Beacon, name: beacon, body: base, topic: a, switch_topic: b, frame: c, "
        "update_rate: 40, limits: {low: 1, high: 2}, colors: [{red: 1}]",
        loader=PluginLoader([PluginDeclaration.of(Beacon)]),
    )
