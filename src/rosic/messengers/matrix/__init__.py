"""Matrix, encrypted end to end: outbound connections only (docs/messengers/matrix.md)."""

from __future__ import annotations

from rosic.messengers.matrix.messenger import MatrixMessenger, matrix_messenger

__all__ = ["MatrixMessenger", "matrix_messenger"]
