"""Tactile sensors of fingervision as cameras of LeRobot, of the type ``fingervision``."""

from lerobot_camera_fingervision.camera import FingervisionCamera
from lerobot_camera_fingervision.configuration import FingervisionCameraConfig

__all__ = ["FingervisionCamera", "FingervisionCameraConfig"]
