"""Spoilt states: each is refused with a StateError, or its world runs on."""

import base64
import json
import random
from pathlib import Path
from typing import Any

from soak.corpus import Corpus
from soak.findings import Findings
from soak.mutations import Mutator
from soak.random_messages import every_model, unusual_poses

from flatland_server.exceptions import StateError
from flatland_server.geometry import Pose
from flatland_server.models.footprint import Circle

SECONDS = 0.15


def load_random_states(folder: Path, seed: int, count: int, findings: Findings) -> None:
    """Loads spoilt states into a world of all models, and steps, saves and resets it."""
    corpus = Corpus.copy_to(folder)
    simulation = every_model(corpus)
    simulation.world.spawn_model(corpus.models[0], "late", "late", Pose(0.0, -30.0, 0.0))
    for model in list(simulation.world.models.values())[:2]:
        body = model.base
        if body.config.footprints:
            model.set_footprint(body.name, 0, Circle((0.1, 0.0), 0.3))
    simulation.run(0.2)
    state = simulation.save_state()
    for number in range(count):
        rng = random.Random(f"state {seed} {number}")
        where = f"seed {seed}, state {number}"
        try:
            simulation.load_state(spoilt(state, rng))
        except StateError:
            findings.counts["spoilt states refused"] += 1
            continue
        except Exception as error:
            findings.expect(False, f"{where}: {type(error).__name__}: {error}")
            continue
        findings.counts["spoilt states loaded"] += 1
        try:
            simulation.run(SECONDS)
            bad = unusual_poses(simulation.world)
            findings.expect(not bad, f"{where}: {bad}")
            simulation.load_state(simulation.save_state())
            simulation.reset()
        except Exception as error:
            findings.expect(False, f"{where}, later: {type(error).__name__}: {error}")
        simulation.load_state(state)
    simulation.world.close()


def spoilt(state: bytes, rng: random.Random) -> bytes:
    """A state with one to three changes."""
    if rng.random() < 0.05:
        return state[: rng.randrange(len(state))]
    content = json.loads(state)
    mutator = Mutator(rng)
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        if rng.random() < 0.2:
            content["physics"] = _flipped(content.get("physics"), rng)
        else:
            mutator.spoil_data(content)
    return json.dumps(content, default=repr, skipkeys=True).encode()


def _flipped(physics: Any, rng: random.Random) -> Any:
    """Bytes of the core's state, some of them changed."""
    try:
        data = bytearray(base64.b64decode(physics["$bytes"]))
    except (KeyError, TypeError, ValueError):  # spoilt before
        return physics
    for _ in range(rng.randint(1, 5)):
        data[rng.randrange(len(data))] = rng.randrange(256)
    return {"$bytes": base64.b64encode(bytes(data)).decode()}
