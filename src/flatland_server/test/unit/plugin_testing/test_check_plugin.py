"""check_plugin: a plugin that keeps the contract passes, and each way to break it is named."""

import pytest
from plugin_testing.beacons import BROKEN, ENTRY, Beacon

from flatland_server import PluginDeclaration, PluginLoader
from flatland_server.testing import PluginContractError, check_plugin

pytestmark = pytest.mark.slow


def check(plugin, entry=ENTRY, **options):
    loader = PluginLoader([PluginDeclaration.of(plugin)])
    check_plugin({**entry, "type": plugin.__name__}, loader=loader, **options)


def test_a_plugin_that_keeps_the_contract_passes():
    check(Beacon)


@pytest.mark.slow
@pytest.mark.parametrize("plugin", BROKEN, ids=lambda plugin: plugin.__name__)
def test_a_broken_plugin_is_told_what_was_expected_and_found(plugin):
    with pytest.raises(PluginContractError) as caught:
        check(plugin)

    assert str(caught.value).startswith(f"{plugin.__name__} does not keep the contract:\n- ")
    assert BROKEN[plugin] in str(caught.value)


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
