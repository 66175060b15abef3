"""The keys of an Imu."""

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from flatland_plugins.sensor_frame import read_tf_topic
from flatland_server import YamlReader

STANDARD_GRAVITY = 9.80665  # [m/s^2] (3rd General Conference on Weights and Measures, 1901)

# [roll, pitch, yaw] in rad, [x, y, z] in rad/s, and [x, y, z] in m/s^2
QUANTITIES = ("orientation", "angular_velocity", "linear_acceleration")


@dataclass(frozen=True)
class ImuConfig:
    """All keys but the body's; noises (variances) and covariances in the order of QUANTITIES."""

    enable_imu_pub: bool
    imu_frame_id: str
    imu_pub: str
    ground_truth_pub: str
    noises: Tuple[Tuple[float, ...], ...]
    covariances: Tuple[Tuple[float, ...], ...]
    gravity: float
    pub_rate: float
    tf_topic: Optional[str]

    @classmethod
    def read(cls, config: YamlReader, static_tf: bool) -> "ImuConfig":
        """Reads the keys; `update_rate` is an alias of `pub_rate`.

        Args:
            config: the plugin's entry in the model file.
            static_tf: default of the key `static_tf`.
        """
        noises, covariances = [], []
        for quantity in QUANTITIES:
            noise = config.get_floats(f"{quantity}_noise", 3, (0.0, 0.0, 0.0), minimum=0.0)
            diagonal = tuple(np.diag(noise).ravel().tolist())
            noises.append(noise)
            covariances.append(config.get_floats(f"{quantity}_covariance", 9, diagonal))
        pub_rate = config.get_rate("pub_rate", math.inf)
        imu = cls(
            enable_imu_pub=config.get_bool("enable_imu_pub", True),
            imu_frame_id=config.get_frame("imu_frame_id", "imu"),
            imu_pub=config.get_topic("imu_pub", "imu/filtered"),
            ground_truth_pub=config.get_topic("ground_truth_pub", "imu/ground_truth"),
            noises=tuple(noises),
            covariances=tuple(covariances),
            gravity=config.get_float("gravity", STANDARD_GRAVITY, minimum=0.0),
            pub_rate=config.get_rate("update_rate", pub_rate),
            tf_topic=read_tf_topic(config, static_tf),
        )
        if config.has("pub_rate") and config.has("update_rate"):
            config.problem('"pub_rate" and "update_rate" are one key: give one', "update_rate")
        config.finish()
        return imu
