"""The files and commands of docs/sweeps.md work; its tables and the reference's are complete."""

import re
import shlex
from pathlib import Path

import pytest

from flatland2d.cli import main
from flatland2d.sweep.metrics import METRICS
from flatland2d.sweep.run import SweepRun

ROOT = Path(__file__).resolve().parents[5]
PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
REFERENCE = (ROOT / "docs" / "reference" / "sweeps.md").read_text(encoding="utf-8")
FILES = re.findall(r"```\w+\n# file: (\S+)\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = [
    line
    for block in re.findall(r"```bash\n(.*?)```", PAGE, re.DOTALL)
    for line in block.splitlines()
    if line.startswith("flatland ")
]


@pytest.mark.slow
def test_the_files_and_commands_work(tmp_path, monkeypatch, capsys):
    for name, text in FILES:
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("flatland2d.picture_page.open_in_browser", lambda url: None)
    monkeypatch.setattr("flatland2d.PicturePage.wait_until_open", lambda page: None)
    monkeypatch.setattr("flatland2d.picture_page.time.sleep", lambda seconds: None)

    for line in COMMANDS:
        if "--ray" in line:  # a real Ray is started once, by the tests of pip
            continue
        command, *arguments = shlex.split(line)
        assert command == "flatland"
        assert main(arguments) == 0, capsys.readouterr().err

    report = (tmp_path / "scenarios_results" / "report.html").read_text()
    assert "60 scenarios" in report
    rows = (tmp_path / "scenarios_results" / "summary.csv").read_text().splitlines()
    assert [row.split(",")[1:5] for row in rows[1:]] == [
        [name, radius, "10", "0"]
        for name in ("direct", "careful", "trained")
        for radius in ("0.2", "0.35")
    ]


def test_the_reference_has_all_arguments(capsys):
    with pytest.raises(SystemExit):
        main(["sweep", "--help"])
    options = set(re.findall(r"--[a-z][a-z-]+", capsys.readouterr().out)) - {"--help"}

    assert options == set(re.findall(r"^\| `(--[a-z-]+)", REFERENCE, re.MULTILINE))


def test_the_pages_have_all_keys_columns_and_attributes():
    reader = (ROOT / "src/flatland2d/src/flatland2d/sweep/scenario_file.py").read_text()
    keys = set(re.findall(r'get_\w+\(\s*"(\w+)"|_place\(reader, "(\w+)"', reader))
    names = {a or b for a, b in keys} | set(METRICS) | {"worlds", "controllers", "parameters"}
    attributes = [name for name in dir(SweepRun) if not name.startswith("_")]
    of_the_command = {"end", "metrics"}

    assert [name for name in sorted(names) if name not in REFERENCE] == []
    assert [n for n in attributes if f"`run.{n}" not in PAGE and n not in of_the_command] == []
