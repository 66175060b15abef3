"""Values out of bounds, for each plugin; test_contract.py has the refusals of all plugins."""

import pytest
import yaml

ENTRIES = {
    "BoolSensor": "type: BoolSensor, name: it",
    "Bumper": "type: Bumper, name: it",
    "DiffDrive": "type: DiffDrive, name: it, body: base",
    "Gps": "type: Gps, name: it, body: base",
    "Imu": "type: Imu, name: it, body: base",
    "Laser": "type: Laser, name: it, body: base, range: 9, angle: {min: -1, max: 1, increment: 1}",
    "ModelTfPublisher": "type: ModelTfPublisher, name: it",
    "Tween": "type: Tween, name: it, body: base, delta: [1, 0, 0]",
}
POSITIVE = "expected a number above 0, found"
VARIANCES = "expected a list of 3 numbers of 0 or more, found"
NOT_NEGATIVE = "expected a number of 0 or more, found -1"
BEAMS = "expected an increment that leads from min to max in 1 to 1000000 beams, found"
NO_BODY = 'the model has no body "bas" (did you mean "base"?); it has: base'

REFUSED = [
    ("BoolSensor", "body: bas", f"body: {NO_BODY}"),
    ("Bumper", "exclude: [bas]", f"exclude: {NO_BODY}"),
    ("DiffDrive", "linear_dynamics: {velocity_limit: -1}", "linear_dynamics.velocity_limit: "),
    ("DiffDrive", "angular_dynamics: {acceleration_limit: -1}", NOT_NEGATIVE),
    ("DiffDrive", "angular_dynamics: {deceleration_limit: -1}", NOT_NEGATIVE),
    ("DiffDrive", "linear_dynamics: {acceleration_limit: inf}", "expected a finite number"),
    ("DiffDrive", "odom_pose_noise: [0, 0, -1]", f"odom_pose_noise: {VARIANCES} [0, 0, -1]"),
    ("DiffDrive", "odom_twist_noise: [-1, 0, 0]", f"odom_twist_noise: {VARIANCES} [-1, 0, 0]"),
    ("DiffDrive", "odom_drift: [0, -0.1, 0]", f"odom_drift: {VARIANCES} [0, -0.1, 0]"),
    ("DiffDrive", "odom_drift: [0, 0, .inf]", f"odom_drift: {VARIANCES} [0, 0, .inf]"),
    ("DiffDrive", "odom_drift: 0.1", "odom_drift: expected a map, found 0.1"),
    ("DiffDrive", "odom_drift: {rotation_per_metre: -1}", f"rotation_per_metre: {NOT_NEGATIVE}"),
    ("DiffDrive", "odom_drift: {per_second: [1, 1]}", f"per_second: {VARIANCES} [1, 1]"),
    ("DiffDrive", "odom_drift: {alpha1: 1}", 'odom_drift: unknown key "alpha1"'),
    ("Gps", "ref_lat: 90.0001", "ref_lat: expected a number of -90 to 90, found 90.0001"),
    ("Gps", "ref_lat: -91", "ref_lat: expected a number of -90 to 90, found -91"),
    ("Gps", "ref_lon: 181", "ref_lon: expected a number of -180 to 180, found 181"),
    ("Gps", "ref_lon: inf", 'ref_lon: expected a finite number, found "inf"'),
    ("Imu", "pub_rate: 50, update_rate: 50", 'update_rate: "pub_rate" and "update_rate" are one'),
    ("Imu", "update_rate: -1", f"update_rate: {POSITIVE} -1"),
    ("Imu", "orientation_noise: [0, 0, -1]", f"orientation_noise: {VARIANCES} [0, 0, -1]"),
    ("Imu", "angular_velocity_noise: [0, 0, -1]", VARIANCES),
    ("Imu", "linear_acceleration_noise: [0, 0, -1]", VARIANCES),
    ("Imu", "gravity: -1", f"gravity: {NOT_NEGATIVE}"),
    ("Laser", "range: inf", 'range: expected a finite number, found "inf"'),
    ("Laser", "range: 0", f"range: {POSITIVE} 0"),
    ("Laser", "angle: {min: -3, max: 3, increment: -0.05}", f"angle: {BEAMS} -0.05 from -3 to 3"),
    ("Laser", "angle: {min: -3, max: 3, increment: 1e-7}", f"angle: {BEAMS} 1e-07 from -3 to 3"),
    ("Laser", "noise_std_dev: -1", f"noise_std_dev: {NOT_NEGATIVE}"),
    ("Laser", "layers: [walls]", 'layers: no layer is named "walls"; there are: none'),
    ("ModelTfPublisher", "exclude: [base, bas]", f"exclude: {NO_BODY}"),
    ("Tween", "delta: [1, 0, inf]", 'delta: expected [x, y, yaw], found [1, 0, "inf"]'),
    ("Tween", "duration: 0", f"duration: {POSITIVE} 0"),
    ("Tween", "duration: inf", 'duration: expected a finite number, found "inf"'),
    ("Tween", "mode: trigered", 'mode: expected yoyo, once, loop or trigger (did you mean "tri'),
    ("Tween", "easing: cubicInOutt", 'or bounceInOut (did you mean "cubicInOut"?), found'),
]


@pytest.mark.parametrize(("plugin", "keys", "message"), REFUSED)
def test_a_value_out_of_bounds_is_refused_at_its_line(files, plugin, keys, message):
    entry = {**yaml.safe_load(f"{{{ENTRIES[plugin]}}}"), **yaml.safe_load(f"{{{keys}}}")}

    refusal = files.robot_refusal(entry)

    assert refusal.startswith("robot.model.yaml:5: plugins[0].")
    assert message in refusal
    assert "\n" not in refusal


def test_a_key_of_a_fork_is_refused_with_the_key_that_is_meant(files):
    entry = {**yaml.safe_load(f"{{{ENTRIES['Laser']}}}"), "flipped": True}

    refusal = files.robot_refusal(entry)
    assert refusal.endswith('plugins[0] "it": unknown key "flipped" (here it is "upside_down")')
