"""Affine transforms, with the interface of Mitsuba's ScalarTransform4f."""

from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._errors import UsageError

Vector = npt.ArrayLike


class _Operation:
    """A method that can also be called on the class: Transform4f.translate(v) and Transform4f().translate(v)."""

    def __init__(self, matrix_of: Any):
        self._matrix_of = matrix_of
        self.__doc__ = matrix_of.__doc__

    def __get__(self, transform: Optional[Transform4f], owner: type) -> Any:
        before = transform if transform is not None else Transform4f()

        def apply(*arguments: Any, **named: Any) -> Transform4f:
            return Transform4f(before.matrix @ self._matrix_of(*arguments, **named))

        apply.__doc__ = self.__doc__
        return apply


class Transform4f:
    """A 4 x 4 matrix. Operations apply to what stands to their right, so the last one written is carried out first:
    ``Transform4f().translate([0, 1, 0]).rotate([0, 0, 1], 90)`` rotates, then moves."""

    def __init__(self, matrix: Optional[npt.ArrayLike] = None):
        self.matrix: npt.NDArray[np.float64] = np.eye(4) if matrix is None else np.array(matrix, np.float64)
        if self.matrix.shape != (4, 4):
            raise UsageError(f"A transform needs a 4 x 4 matrix; this array has shape {self.matrix.shape}.")

    @_Operation
    def translate(offset: Vector) -> npt.NDArray[np.float64]:
        """Translates by a vector."""
        matrix = np.eye(4)
        matrix[:3, 3] = _vector(offset, "translate")
        return matrix

    @_Operation
    def scale(factor: Union[float, Vector]) -> npt.NDArray[np.float64]:
        """Scales along the axes, by one number or three."""
        return np.diag([*np.broadcast_to(np.asarray(factor, np.float64), 3), 1.0])

    @_Operation
    def rotate(axis: Vector, angle: float) -> npt.NDArray[np.float64]:
        """Rotates about an axis through the origin, counterclockwise, by an angle in degrees (Rodrigues' formula)."""
        direction = _vector(axis, "rotate")
        length = np.linalg.norm(direction)
        if not length > 0:
            raise UsageError("rotate() was given the zero vector as its axis; give a direction.")
        x, y, z = direction / length
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        matrix = np.eye(4)
        radians = np.radians(angle)
        matrix[:3, :3] += np.sin(radians) * cross + (1 - np.cos(radians)) * (cross @ cross)
        return matrix

    @_Operation
    def look_at(origin: Vector, target: Vector, up: Vector) -> npt.NDArray[np.float64]:
        """Places a camera at ``origin`` that looks along +z at ``target``; +x points to the left of the picture, +y
        up."""
        eye = _vector(origin, "look_at")
        forward = _vector(target, "look_at") - eye
        left = np.cross(_vector(up, "look_at"), forward)
        if not (np.linalg.norm(forward) > 0 and np.linalg.norm(left) > 0):
            raise UsageError("look_at() needs a target other than its origin, and an up vector not along the line of sight.")
        forward = forward / np.linalg.norm(forward)
        left = left / np.linalg.norm(left)
        matrix = np.eye(4)
        matrix[:3, :] = np.stack([left, np.cross(forward, left), forward, eye], axis=1)
        return matrix

    def inverse(self) -> Transform4f:
        return Transform4f(np.linalg.inv(self.matrix))

    def __matmul__(self, other: Any) -> Any:
        """Composes with another transform, which is applied first; or transforms a point or an array of points of shape
        (…, 3)."""
        if isinstance(other, Transform4f):
            return Transform4f(self.matrix @ other.matrix)
        points = np.asarray(other, np.float64)
        return points @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> npt.NDArray[Any]:
        return np.array(self.matrix, dtype=dtype)

    def __repr__(self) -> str:
        return f"Transform4f({self.matrix.tolist()})"


ScalarTransform4f = Transform4f


def _vector(values: Vector, what: str) -> npt.NDArray[np.float64]:
    vector = np.asarray(values, np.float64)
    if vector.shape != (3,):
        raise UsageError(f"{what}() needs vectors of three numbers, not {values!r}.")
    return vector
