"""Bash completion, which setup.bash brings: what the Tab key offers."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HOOK = Path(__file__).resolve().parents[1] / "env-hooks" / "50.flatland_completion.bash"

pytestmark = pytest.mark.slow

_TAB = """
shopt -s extglob
compopt() { :; }  # works within a completion of readline only
source "$HOOK"
tab() {  # function, words; bash splits at ":="
  COMP_WORDS=("${@:2}") COMP_CWORD=$(($# - 2)) COMPREPLY=()
  "$1" "$2" "${@: -1}" "${@: -2:1}"
  echo "${COMPREPLY[*]}"
}
"""


@pytest.fixture(scope="module")
def offers():
    """Completes the last word of command lines, each the name of a completion and words."""

    def complete(lines, cwd):
        calls = "\n".join(f"tab _flatland_complete_{line}" for line in lines)
        result = subprocess.run(
            ["bash", "-c", _TAB + calls],
            env={**os.environ, "HOOK": str(HOOK), "FLATLAND_TEST_COMPLETION": "1"},
            cwd=cwd,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        return dict(zip(lines, (set(words.split()) for words in result.stdout.splitlines())))

    return complete


def test_tab_offers_arguments_values_commands_options_and_worlds(offers, tmp_path):
    for name in ("mine.yaml", "other.txt"):
        (tmp_path / name).touch()
    expected = {
        "run scripts/run s": "step_size:= show_viz:= seed:= simplify_map:= state_folder:= "
        "static_tf:=",
        "run scripts/run show_viz := ''": "true false",
        "run scripts/run world_path := ''": "mine.yaml",
        "run scripts/run m": "map:= models:= map_to_odom:= mine.yaml",
        "roslaunch roslaunch flatland_server server.launch use": "use_rviz:=",
        "flatland flatland check --r": "--render",
        "rosrun rosrun flatland2d flatland r": "recover render run",
        "rosrun rosrun flatland2d flatland run ''": "circle_crossing corridor_frontal crossing "
        "doorway intersection office overtaking racetrack test_room mine.yaml",
        "rosrun rosrun flatland2d flatland run --s": "--seed --step-size --seconds",
    }

    found = offers(expected, cwd=tmp_path)

    assert found == {line: set(words.split()) for line, words in expected.items()}


def flatland(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "flatland2d", *arguments], stdout=subprocess.PIPE, text=True
    )


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_a_script_for_shells_without_ros_is_printed(shell, tmp_path):
    result = flatland("--print-completion", shell)

    assert result.returncode == 0
    for word in ("check", "sweep", "--step-size"):
        assert word in result.stdout
    if shutil.which(shell):
        file = tmp_path / "_flatland"
        file.write_text(result.stdout)
        subprocess.run([shell, "-n", str(file)], check=True)
