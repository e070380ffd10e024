"""The package and the command give the same bytes."""

from __future__ import annotations

import csv
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
import pytest

import fingervision
from conftest import ALL_FIELDS, Press

if TYPE_CHECKING:
    from typing import Any

    import numpy.typing as npt


def stacked(readings: list[fingervision.Reading], name: str) -> npt.NDArray[Any]:
    """A field of all readings, as a run has it."""
    array = np.stack([getattr(reading, name) for reading in readings])
    return array.astype(np.uint8) if array.dtype == np.bool_ else array


def expect_same(readings: list[fingervision.Reading], other: list[fingervision.Reading]) -> None:
    """Compares every field that the readings have."""
    assert len(readings) == len(other)
    for name in other[0].fields:
        assert stacked(readings, name).tobytes() == stacked(other, name).tobytes(), name
    assert stacked(readings, "valid").tobytes() == stacked(other, "valid").tobytes()


@pytest.fixture(scope="module")
def complete(press: Press) -> list[fingervision.Reading]:
    """The readings of the press with every field."""
    with fingervision.open(press.frames, press.profile, fields=ALL_FIELDS) as readings:  # type: ignore[arg-type]
        return list(readings)


@pytest.mark.parametrize("name", [*ALL_FIELDS, "valid", "depth_valid"])
def test_fields_are_those_of_the_command(press: Press, complete: list[fingervision.Reading], name: str) -> None:
    expected = np.load(press.run / f"{name}.npy")
    found = stacked(complete, name)
    assert (found.shape, found.dtype) == (expected.shape, expected.dtype)
    assert found.tobytes() == expected.tobytes()


def test_numbers_are_those_of_the_table(press: Press, tracked: list[fingervision.Reading]) -> None:
    with (press.run / "readings.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(tracked) == 7
    for row, reading in zip(rows, tracked, strict=True):
        assert int(row["sequence"]) == reading.sequence
        assert float(row["capture_time_s"]) == pytest.approx(reading.capture_time_s, abs=1e-9)
        force = [row[f"force_{axis}_n"] for axis in "xyz"]
        assert np.array(force, dtype=np.float32).tobytes() == reading.force.tobytes()
        assert np.float32(row["torque_z_nmm"]) == np.float32(reading.torque)
        assert np.float32(row["max_depth_mm"]) == np.float32(reading.max_depth_mm)
        assert np.float32(row["contact_area_mm2"]) == np.float32(reading.contact_area_mm2)
        assert row["flags"] == "+".join(reading.flags)
    assert tracked[-1].force[2] > 1.0


def test_a_tracker_gives_what_a_source_gives(press: Press, tracked: list[fingervision.Reading]) -> None:
    for channels, order in (("rgb", slice(None)), ("bgr", slice(None, None, -1))):
        tracker = fingervision.Tracker(press.profile, channels=channels)  # type: ignore[arg-type]
        expect_same([tracker.track(reading.image[:, :, order]) for reading in tracked], tracked)


def test_memory_is_used_again_without_a_trace(press: Press, tracked: list[fingervision.Reading]) -> None:
    tracker = fingervision.Tracker(press.profile, channels="rgb")
    for reading in tracked:
        kept = tracker.track(reading.image)
        assert kept.depth.tobytes() == reading.depth.tobytes()
        assert kept.depth is kept.depth


def test_strides_and_read_only_images_make_no_difference(
    press: Press, tracked: list[fingervision.Reading], images: list[npt.NDArray[np.uint8]]
) -> None:
    wide = [np.repeat(np.repeat(image, 2, axis=0), 2, axis=1)[::2, ::2] for image in images]
    fortran = [np.asfortranarray(image) for image in images]
    for image in images:
        image.flags.writeable = False
    for other in (wide, fortran, images):
        tracker = fingervision.Tracker(press.profile, channels="rgb")
        expect_same([tracker.track(image) for image in other], tracked)


class Tensor:
    """An image of another library: it has DLPack's methods and no others."""

    def __init__(self, array: npt.NDArray[Any]) -> None:
        """Wraps an array."""
        self.array = array

    def __dlpack__(self, **options: Any) -> Any:
        """The capsule of the array."""
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        """The memory of the CPU."""
        return (1, 0)


def test_images_of_other_libraries_are_tracked(
    press: Press, tracked: list[fingervision.Reading], images: list[npt.NDArray[np.uint8]]
) -> None:
    pillow = pytest.importorskip("PIL.Image")
    for kind in (Tensor, pillow.fromarray):
        tracker = fingervision.Tracker(press.profile, channels="rgb")
        expect_same([tracker.track(kind(image)) for image in images], tracked)


def test_results_are_handed_on_without_a_copy(tracked: list[fingervision.Reading]) -> None:
    reading = tracked[-1]
    arrays: list[Any] = [reading.flow, reading.depth, reading.contact, reading.image]
    for array in arrays:
        other = np.from_dlpack(array)
        assert np.shares_memory(array, other)
        assert array.flags.c_contiguous
        assert array.flags.writeable


def test_an_image_may_change_after_it_was_tracked(
    press: Press, tracked: list[fingervision.Reading], images: list[npt.NDArray[np.uint8]]
) -> None:
    tracker, buffer = fingervision.Tracker(press.profile, channels="rgb"), np.empty_like(images[0])
    found: list[fingervision.Reading] = []
    for image in images:
        buffer[:] = image
        found.append(tracker.track(buffer))
        buffer[:] = 0
    expect_same(found, tracked)
    assert found[3].image.tobytes() == images[3].tobytes()


def test_sixteen_bits_and_grey_are_tracked(press: Press, images: list[npt.NDArray[np.uint8]]) -> None:
    grey = [image.mean(axis=2).round().astype(np.uint8) for image in images]
    depths: list[npt.NDArray[np.float32]] = []
    for kind in (grey, [image.astype(np.uint16) * 257 for image in grey]):
        tracker = fingervision.Tracker(press.profile)
        depths.append([tracker.track(image) for image in kind][-1].depth)
    np.testing.assert_allclose(depths[0], depths[1], atol=2e-3)
    assert depths[0].max() > 0.5


def test_four_trackers_in_four_threads(
    press: Press, tracked: list[fingervision.Reading], images: list[npt.NDArray[np.uint8]]
) -> None:

    def track(_: int) -> list[fingervision.Reading]:
        tracker = fingervision.Tracker(press.profile, channels="rgb")
        return [tracker.track(image) for image in images]

    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(track, range(4)):
            expect_same(found, tracked)


def test_one_tracker_may_be_called_by_many_threads(press: Press, images: list[npt.NDArray[np.uint8]]) -> None:
    tracker = fingervision.Tracker(press.profile, channels="rgb")
    tracker.track(images[0])
    with ThreadPoolExecutor(4) as pool:
        readings = list(pool.map(tracker.track, images[1:2] * 8))
    assert sorted(reading.sequence for reading in readings) == list(range(1, 9))


def test_a_reset_begins_anew(press: Press, images: list[npt.NDArray[np.uint8]]) -> None:
    tracker = fingervision.Tracker(press.profile, channels="rgb")
    pressed = [tracker.track(image) for image in images][-1]
    tracker.reset()
    again = tracker.track(images[-1])
    assert pressed.max_depth_mm > 0.5
    assert again.max_depth_mm < 0.02
    assert "new-reference" in again.flags
    fresh = fingervision.Tracker(press.profile, channels="rgb")
    assert again.flow.tobytes() == fresh.track(images[-1]).flow.tobytes()


def test_the_flow_alone_is_that_of_a_first_frame(press: Press, images: list[npt.NDArray[np.uint8]]) -> None:
    estimator = fingervision.FlowEstimator(images[0], channels="rgb")
    far, near = estimator.estimate(images[-1]), estimator.estimate(images[1])
    again = estimator.estimate(images[-1])
    assert far.flow.tobytes() == again.flow.tobytes()
    assert np.abs(far.flow).max() > 2 * np.abs(near.flow).max() > 0.0
    truth = np.load(press.folder / "truth" / "flow.npy")[-1]
    error = np.linalg.norm(far.flow - truth, axis=2)[far.valid]
    assert np.nanmean(error) < 0.05
    assert far.matched > 0.9
