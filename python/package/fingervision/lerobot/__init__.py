"""Runs and recordings as LeRobot data sets, format v3.0: ``export_lerobot``, or ``python -m fingervision.lerobot --help``.

Needs pyarrow and Pillow: ``pip install pyarrow Pillow``.
"""

from fingervision.lerobot._export import export_lerobot

__all__ = ["export_lerobot"]
