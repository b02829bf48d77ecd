"""Where a ray meets a plane, sphere, cylinder or cone: they are all a (x^2 + y^2) + c z^2 + e z + g = 0."""

from __future__ import annotations

import math

from oracle.scene import Shape
from oracle.vectors import along, compiled, dot


def coefficients(shape: Shape) -> tuple[float, float, float, float]:
    """a, c, e and g."""
    match shape.kind, shape.numbers:
        case "plane", ():
            return 0.0, 0.0, 1.0, 0.0
        case "sphere", (radius,):
            return 1.0, 1.0, 0.0, -radius * radius
        case "cylinder", (radius,):
            return 1.0, 0.0, 0.0, -radius * radius
        case "cone", (radius, change):
            return 1.0, -change * change, -2.0 * radius * change, -radius * radius
    raise ValueError(f"{shape.kind} with {len(shape.numbers)} numbers is no quadric of revolution")


@compiled
def quadric_roots(shape, origin, direction, leaving):
    """The distances, in order, at which a ray in the shape's own axes meets it; infinite where it does not.

    Of a ray that leaves the shape, the root at its origin is known and left out.
    """
    a, c, e, g = shape[0], shape[1], shape[2], shape[3]
    # About the point of the ray nearest to the shape's origin little is lost by rounding.
    shift = 0.0 if leaving else -dot(origin, direction)
    x, y, z = along(origin, shift, direction)
    square = a * (direction[0] * direction[0] + direction[1] * direction[1]) + c * direction[2] * direction[2]
    half = a * (x * direction[0] + y * direction[1]) + c * z * direction[2] + 0.5 * e * direction[2]
    if leaving:
        return math.inf, (-2.0 * half / square if square != 0.0 else math.inf)
    rest = a * (x * x + y * y) + c * z * z + e * z + g
    under = half * half - square * rest
    if under < 0.0:
        return math.inf, math.inf
    sum_of = -(half + math.copysign(math.sqrt(under), half))
    one = shift + sum_of / square if square != 0.0 else math.inf
    other = shift + rest / sum_of if sum_of != 0.0 else shift
    return min(one, other), max(one, other)


@compiled
def quadric_normal(shape, point):
    """Along the gradient, of any length."""
    return shape[0] * point[0], shape[0] * point[1], shape[1] * point[2] + 0.5 * shape[2]
