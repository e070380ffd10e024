"""The camera: a thread tracks the sensor's frames, and LeRobot reads the last of them."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from lerobot.cameras.camera import Camera
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

import fingervision

if TYPE_CHECKING:
    import numpy.typing as npt

    from lerobot_camera_fingervision.configuration import FingervisionCameraConfig

_FIRST_FRAME_S = 10.0
_NEXT_FRAME_S = 10.0


class FingervisionCamera(Camera):
    """A tactile sensor. Pictures are ``(H, W, 3)`` uint8 in red, green, blue."""

    def __init__(self, config: FingervisionCameraConfig) -> None:
        """Opens nothing yet."""
        super().__init__(config)
        self.config = config
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._is_stopping = False
        self._error: BaseException | None = None
        self._reading: fingervision.Reading | None = None
        self._count = self._consumed = 0
        self._arrival_s = 0.0

    def __str__(self) -> str:
        return f"FingervisionCamera({self.config.source})"

    @property
    def is_connected(self) -> bool:
        """Whether frames are read."""
        return self._thread is not None

    @property
    def reading(self) -> fingervision.Reading:
        """Everything that was computed from the last frame."""
        with self._changed:
            self._expect_connected()
            return self._last()

    @staticmethod
    def find_cameras() -> list[dict[str, Any]]:
        """The cameras that are plugged in; ``id`` is the ``source`` of a configuration."""
        return [
            {"name": camera.name, "type": "fingervision", "id": f"camera:{camera.id}", "path": camera.path}
            for camera in fingervision.cameras()
        ]

    def connect(self, warmup: bool = True) -> None:
        """Opens the sensor and waits for the first frame, which is the reference: it shows the gel untouched.

        With ``warmup`` a second frame is awaited. Raises ``DeviceAlreadyConnectedError``, ``ConnectionError`` or
        ``TimeoutError``.
        """
        if self.is_connected:
            raise DeviceAlreadyConnectedError(f"{self} is connected already")
        try:
            readings = fingervision.open(self.config.source, self.config.profile)
        except fingervision.Error as error:
            raise ConnectionError(f"{self} cannot be opened: {error}") from error
        self._is_stopping, self._error, self._reading = False, None, None
        self._count = self._consumed = 0
        self._thread = threading.Thread(target=self._track, args=(readings,), name=str(self), daemon=True)
        self._thread.start()
        try:
            self._wait(0, _FIRST_FRAME_S)
            self._check_size()
            if warmup:
                self._wait(1, _NEXT_FRAME_S)
        except BaseException:
            self.disconnect()
            raise

    def read(self) -> npt.NDArray[Any]:
        """Waits for the next frame and returns its picture."""
        with self._changed:
            seen = self._count
        return self._wait(seen, _NEXT_FRAME_S)

    def async_read(self, timeout_ms: float = 200) -> npt.NDArray[Any]:
        """The picture of the last frame; waits for one that was not returned before.

        Raises ``TimeoutError`` if none arrives in time.
        """
        with self._changed:
            seen = self._consumed
        return self._wait(seen, timeout_ms / 1000)

    def read_latest(self, max_age_ms: int = 500) -> npt.NDArray[Any]:
        """The picture of the last frame, at once.

        Raises ``TimeoutError`` if it is older than ``max_age_ms``.
        """
        with self._changed:
            self._expect_connected()
            reading, age_ms = self._last(), (time.monotonic() - self._arrival_s) * 1000
        if age_ms > max_age_ms:
            raise TimeoutError(f"the last frame of {self} is {age_ms:.0f} ms old, {max_age_ms} are allowed")
        return self._picture(reading)

    def disconnect(self) -> None:
        """Closes the sensor."""
        thread = self._thread
        if thread is None:
            raise DeviceNotConnectedError(f"{self} is not connected")
        with self._changed:
            self._is_stopping, self._thread = True, None
            self._changed.notify_all()
        thread.join(timeout=_NEXT_FRAME_S)

    def _track(self, readings: fingervision.Readings) -> None:
        """Keeps the last reading until the source ends or the camera is disconnected."""
        try:
            with readings:
                for reading in readings:
                    with self._changed:
                        if self._is_stopping:
                            return
                        self._reading, self._arrival_s = reading, time.monotonic()
                        self._count += 1
                        self._changed.notify_all()
            ended: BaseException = ConnectionError(f"{self} has no more frames")
        except BaseException as error:  # noqa: BLE001  it is raised where frames are read
            ended = error
        with self._changed:
            self._error = ended
            self._changed.notify_all()

    def _wait(self, seen: int, timeout_s: float) -> npt.NDArray[Any]:
        """The picture of the last frame when there are more than were seen."""
        with self._changed:
            self._expect_connected()
            self._changed.wait_for(lambda: self._count > seen or self._error or self._is_stopping, timeout_s)
            self._expect_connected()
            if self._count <= seen:
                if self._error is not None:
                    raise ConnectionError(str(self._error)) from self._error
                raise TimeoutError(f"{self} has sent no frame for {timeout_s * 1000:.0f} ms")
            self._consumed = self._count
            reading = self._last()
        return self._picture(reading)

    def _expect_connected(self) -> None:
        if not self.is_connected:
            raise DeviceNotConnectedError(f"{self} is not connected")

    def _last(self) -> fingervision.Reading:
        if self._reading is None:
            raise RuntimeError(f"{self} has sent no frame yet")
        return self._reading

    def _check_size(self) -> None:
        rows, columns = self._picture(self.reading).shape[:2]
        asked = (self.width or columns, self.height or rows)
        if asked != (columns, rows):
            raise ValueError(f"{self} has {columns}x{rows} px, not {asked[0]}x{asked[1]}: leave width and height out")
        self.width, self.height = columns, rows

    def _picture(self, reading: fingervision.Reading) -> npt.NDArray[np.uint8]:
        if self.config.show == "depth":
            levels = np.clip(reading.depth * (255 / self.config.depth_range_mm), 0, 255)
            shown = np.round(levels).astype(np.uint8)
        else:
            image = reading.image
            shown = (image >> 8).astype(np.uint8) if image.dtype == np.uint16 else image
        return shown if shown.ndim == 3 else np.repeat(shown[..., np.newaxis], 3, axis=2)
