from anamorph.trilinear.points import Projections as Projections
from anamorph.trilinear.points import project_points as project_points
from anamorph.trilinear.shapes import Shape as Shape
from anamorph.trilinear.shapes import project_triangle as project_triangle
