"""All cases by name, in the order in which they run."""

from typing import Dict

from flatland_benchmark.batch_cases import BATCH_CASES
from flatland_benchmark.branch_cases import BRANCH_CASES
from flatland_benchmark.case import Case
from flatland_benchmark.contact_cases import CONTACT_CASES
from flatland_benchmark.drive_cases import DRIVE_CASES
from flatland_benchmark.history_case import HISTORY_CASE
from flatland_benchmark.library_cases import LIBRARY_CASES
from flatland_benchmark.map_cases import MAP_CASES
from flatland_benchmark.plugin_cases import PLUGIN_CASES
from flatland_benchmark.ray_cases import RAY_CASES
from flatland_benchmark.robot_cases import ROBOT_CASES
from flatland_benchmark.server_cases import SERVER_CASES
from flatland_benchmark.start_case import START_CASE
from flatland_benchmark.window_cases import WINDOW_CASES

CASES: Dict[str, Case] = {
    case.name: case
    for case in (
        *RAY_CASES,
        *ROBOT_CASES,
        *DRIVE_CASES,
        *LIBRARY_CASES,
        *BATCH_CASES,
        *BRANCH_CASES,
        HISTORY_CASE,
        *SERVER_CASES,
        START_CASE,
        *WINDOW_CASES,
        *CONTACT_CASES,
        *PLUGIN_CASES,
        *MAP_CASES,
    )
}
