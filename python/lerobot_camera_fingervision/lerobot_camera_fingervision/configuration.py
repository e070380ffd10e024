"""The settings of a sensor that is used as a camera of LeRobot."""

from __future__ import annotations

from dataclasses import dataclass

from lerobot.cameras.configs import CameraConfig

_SHOWN = ("image", "depth")


@CameraConfig.register_subclass("fingervision")
@dataclass(kw_only=True)
class FingervisionCameraConfig(CameraConfig):
    """A sensor. ``width`` and ``height`` are those of the pictures; without them they are taken from the first frame."""

    source: str = "camera"
    """Where frames come from: ``camera:ID``, or any other source of ``fingervision.open``."""
    profile: str | None = None
    """The file of the sensor's profile; its ``[capture]`` sets the camera's mode."""
    show: str = "image"
    """What the pictures show: ``image`` or ``depth``."""
    depth_range_mm: float = 2.0
    """The depth that is shown as 255; 0 and less is 0."""

    def __post_init__(self) -> None:
        """Refuses what is impossible."""
        if self.show not in _SHOWN:
            raise ValueError(f"show is {self.show!r}: give one of {', '.join(_SHOWN)}")
        if not self.depth_range_mm > 0:
            raise ValueError(f"depth_range_mm is {self.depth_range_mm}: give a length above 0")
