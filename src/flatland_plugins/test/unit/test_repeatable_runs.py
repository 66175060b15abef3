"""Equal seeds and commands give equal runs, whatever the subscribers and other models."""

from typing import Any, Dict, List, Tuple

from flatland_server.geometry import Pose

DRIVE = (
    "type: DiffDrive, name: drive, body: base, "
    "odom_pose_noise: [0.1, 0.1, 0.1], odom_twist_noise: [0.1, 0.1, 0.1]"
)
LASER = (
    "type: Laser, name: laser, body: base, range: 20, noise_std_dev: 0.1, update_rate: 40, "
    "angle: {min: -1, max: 1, increment: 0.1}, always_publish: true"
)
FAR_AWAY = "pose: [500, 500, 0]"


def load(files, *, others: Dict[str, str] = {}, **options: Any):  # noqa: B006 (only read)
    """A robot with noisy sensors before a wall."""
    wall = f"name: walls, map: {files.walls('wall', '5 -20 5 20')}"
    return files.robot(DRIVE, LASER, layers=(wall,), others=dict(others), **options)


def numbers(simulation, seconds: float = 1.0) -> List[Tuple[Any, ...]]:
    """Drives for a time [s]; returns the robot's odometry and scans at each step."""
    simulation.drive(0.5, 0.3)
    said = []
    for _ in range(round(seconds / 0.005)):
        simulation.run()
        odometry, scan = simulation.last("/odometry/filtered"), simulation.last("/scan")
        position, twist = odometry.pose.pose.position, odometry.twist.twist
        said.append((position.x, position.y, twist.linear.x, twist.angular.z, tuple(scan.ranges)))
    return said


def test_noise_depends_on_the_seed_and_the_robot_and_on_no_other_model(files):
    other = f"model: robot.model.yaml, namespace: other, {FAR_AWAY}"
    alone, with_another_seed = (numbers(load(files, seed=seed), 2.0) for seed in (5, 6))
    simulation = load(files, seed=5)
    path = files.folder / "robot.model.yaml"

    said = numbers(simulation, 0.5)
    simulation.world.spawn_model(path, "guest", "guest", Pose(500.0, 500.0, 0.0))
    said += numbers(simulation, 0.5)
    simulation.world.delete_model("guest")
    said += numbers(simulation, 1.0)

    assert said == alone
    assert not any(a[0] == b[0] or a[4] == b[4] for a, b in zip(alone, with_another_seed))
    both = load(files, others={"other": other}).run(0.1)
    mine, theirs = (both.last(f"{ns}/odometry/filtered").twist.twist for ns in ("", "/other"))
    assert mine.linear.x != theirs.linear.x
