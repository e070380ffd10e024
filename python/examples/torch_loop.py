"""How do I use touch in a learning loop? An environment in the style of Gymnasium whose tensors share NumPy's memory.

A simulated press stands for robot and camera: an action of +1 presses one step deeper, -1 one step less.
"""

from __future__ import annotations

import torch

import fingervision


class TouchEnvironment:
    """Keep the normal force near a target."""

    def __init__(self, scene: str, target_n: float) -> None:
        """Solves the press."""
        self.press = fingervision.simulate(scene, draft=True)
        self.tracker = fingervision.Tracker(self.press.profile, channels="rgb")
        self.target_n, self.at = target_n, 0

    def reset(self) -> torch.Tensor:
        """Lets go of the gel, and makes it the reference."""
        self.at = 0
        self.tracker.reset()
        return self.observation()[0]

    def step(self, action: int) -> tuple[torch.Tensor, float, bool]:
        """Moves; returns depth, reward, and whether the target is reached."""
        self.at = min(max(self.at + action, 0), len(self.press) - 1)
        depth, force_n = self.observation()
        error = abs(force_n - self.target_n)
        return depth, -error, error < 0.1 * self.target_n

    def observation(self) -> tuple[torch.Tensor, float]:
        """The depth map, `(H, W)` float32, mm, without a copy of the array, and the normal force, N."""
        reading = self.tracker.track(self.press[self.at].image)
        return torch.from_dlpack(reading.depth), float(reading.force[2])


def main() -> None:
    """Presses until the target is reached."""
    environment = TouchEnvironment("circle", target_n=4.0)
    depth, is_done = environment.reset(), False
    while not is_done and environment.at < len(environment.press) - 1:
        depth, reward, is_done = environment.step(1)
        print(f"step {environment.at}: {depth.max():.2f} mm, reward {reward:.2f}")


if __name__ == "__main__":
    main()
