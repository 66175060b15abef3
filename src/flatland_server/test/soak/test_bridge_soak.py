"""Bridges with clients that misbehave: a short soak."""

import pytest
from soak.bridge_misdeeds import MISDEEDS
from soak.bridge_soak import BridgeSoak
from soak.findings import Findings

SEED = 1
SHARE = 0.1

pytestmark = pytest.mark.slow


@pytest.fixture
def findings():
    return Findings()


@pytest.fixture(scope="module")
def soak_of(tmp_path_factory):
    """The soak of a kind of bridge, which ends that of the other kind."""
    soaks = {}

    def close():
        for kind in list(soaks):
            soaks.pop(kind).close()

    def get(kind):
        if kind not in soaks:
            close()
            soaks[kind] = BridgeSoak(kind, tmp_path_factory.mktemp("soak") / kind, SHARE)
        return soaks[kind]

    yield get
    close()


@pytest.mark.parametrize("misdeed", MISDEEDS)
def test_misbehaving_clients_of_the_server_disturb_no_others(soak_of, findings, misdeed):
    soak_of("serve").run_round(SEED, [misdeed], findings)

    assert findings.violations == []


def test_a_bridge_that_ends_is_found_and_started_again(soak_of, findings):
    soak = soak_of("serve")
    soak.bridge.kill()
    soak.run_round(SEED, ["wrong_http"], findings)
    assert "it has ended" in findings.violations[-1]

    before = len(findings.violations)
    soak.run_round(SEED, ["wrong_http"], findings)
    assert len(findings.violations) == before


@pytest.mark.parametrize("misdeed", ["random_messages_of_rosbridge", "subscription_storm"])
def test_misbehaving_clients_of_the_ros_node_disturb_no_others(soak_of, findings, misdeed):
    soak_of("bridge").run_round(SEED, [misdeed], findings)

    assert findings.violations == []
