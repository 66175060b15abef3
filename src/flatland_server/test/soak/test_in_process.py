"""Spoilt files and random messages in worlds of this process, and the findings of a soak."""

import random
from io import BytesIO

import pytest
from soak.corpus import Corpus
from soak.findings import Findings
from soak.mutations import Mutator
from soak.random_files import RandomFiles
from soak.random_messages import random_message, send_random_messages
from soak.random_recordings import record_at_random
from soak.random_states import load_random_states
from soak.soak import Soak
from soak.usage import Usage

SEED = 1
FILES, STEPS, STATES, RECORDINGS = 250, 300, 75, 4


@pytest.fixture
def findings():
    return Findings()


@pytest.mark.slow
def test_a_spoilt_file_is_read_or_refused_at_its_place(tmp_path, findings):
    RandomFiles(tmp_path, SEED, findings).run(FILES, seconds=60.0)

    assert findings.violations == []
    assert findings.counts["spoilt files refused"] > FILES / 4
    assert findings.counts["spoilt files accepted"] > FILES / 20


@pytest.mark.slow
def test_random_messages_keep_plugins_alive_and_poses_finite(tmp_path, findings):
    send_random_messages(tmp_path, SEED, STEPS, findings)

    assert findings.violations == []
    assert findings.counts["messages in process"] > STEPS


@pytest.mark.slow
def test_a_spoilt_state_is_refused_or_runs_on(tmp_path, findings):
    load_random_states(tmp_path, SEED, STATES, findings)

    assert findings.violations == []
    assert findings.counts["spoilt states refused"] > STATES / 4
    assert findings.counts["spoilt states loaded"] > STATES / 20


@pytest.mark.slow
def test_recordings_under_signals_and_on_full_disks_can_be_read(tmp_path, findings):
    record_at_random(tmp_path / "recordings", SEED, RECORDINGS, findings)

    assert findings.violations == []
    assert findings.counts["recorded steps"] > 1000


def test_leftovers_of_a_failed_spawn_are_found(tmp_path, findings, monkeypatch):
    files = RandomFiles(tmp_path, SEED, findings)
    monkeypatch.setattr(files.world, "spawn_model", lambda *_: files.world.delete_model("usher"))

    files.run(20, seconds=60.0)

    assert any("has left behind: ['models'" in violation for violation in findings.violations)


def test_a_plugin_that_fails_by_a_random_message_is_found(tmp_path, findings, monkeypatch):
    def fail(*_):
        raise TypeError("no such message")

    monkeypatch.setattr("flatland_plugins.diff_drive.DiffDrive.on_twist", fail)

    send_random_messages(tmp_path, SEED, 20, findings)

    assert any("TypeError: no such message" in each for each in findings.violations)


def test_equal_seeds_spoil_files_alike(tmp_path):
    contents = []
    for name in ("a", "b"):
        corpus = Corpus.copy_to(tmp_path / name)
        mutator = Mutator(random.Random(SEED))
        for path in corpus.models:
            mutator.spoil(path)
        contents.append([path.read_bytes() for path in corpus.models])

    assert contents[0] == contents[1]
    assert contents[0] != [corpus.originals[path] for path in corpus.models]


@pytest.mark.parametrize(
    "name", ["geometry_msgs/Twist", "visualization_msgs/InteractiveMarkerFeedback", "std_msgs/Bool"]
)
def test_random_messages_can_be_sent(name):
    rng = random.Random(SEED)

    for _ in range(200):
        random_message(name, rng).serialize(BytesIO())


@pytest.mark.parametrize(("end", "is_violation"), [(104.0, False), (106.0, True)])
def test_growth_after_the_warm_up_is_a_violation(tmp_path, end, is_violation):
    soak = Soak(tmp_path, clients=4, seed=0)
    soak.start = Usage(60.0, 12, 9)
    soak.usages = [Usage(memory, 12, 9) for memory in (80.0, 100.0, end)]

    figures = soak.figures(seconds=60.0, warm_rounds=2)

    assert figures["server"]["after warm-up"]["memory"] == 100.0
    assert bool(figures["violations"]) == is_violation
