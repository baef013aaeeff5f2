"""Portals: the panes through which a room sees the outside, as rectangles that samples are aimed at.

A sky sampled over the whole sphere is seen from inside through a few percent of its directions. Choosing points on the
panes instead wastes little; joined with the sky's own density it stays unbiased wherever the receiver is.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from .rectangles import draw_place, find_density, find_solid_angle, into_axes

MAXIMUM_PORTALS = 16
"""Most rectangles; their densities are summed at every next-event. Beyond, the smallest are left to plain sampling."""

FLOOR_OPENNESS = 0.05
"""Openness far from all portals."""

OWN_PLANE = 1e-5
"""Distance from a portal's plane up to which a receiver is taken to lie on it, relative to places and sizes: there rounding
decides on which side it is. [-]"""

FLATNESS = 0.02
"""Largest distance from the mean plane, relative to the size, of what counts as a flat pane. [-]"""


@dataclass(frozen=True)
class Portal:
    """Rectangle by its centre and half edges, (3,) each. [m]"""

    centre: np.ndarray
    half_u: np.ndarray
    half_v: np.ndarray


def portal_order(portal: Portal) -> tuple:
    """Key that puts portals in an order of their own: the largest first."""
    area = np.linalg.norm(portal.half_u) * np.linalg.norm(portal.half_v)
    return (-area, *portal.centre)


def find_portals(panes) -> list[Portal]:
    """Rectangles around the connected flat parts of panes, largest first.

    Parameters
    ----------
    panes : iterable of (vertices (v, 3), triangles (t, 3))    [m]
    """
    found = []
    for vertices, triangles in panes:
        if len(triangles) > 20_000:
            continue
        for part in _connected(vertices, triangles):
            portal = _rectangle(vertices[np.unique(part)])
            if portal is not None:
                found.append(portal)
    found.sort(key=portal_order)
    return found[:MAXIMUM_PORTALS]


class PortalSet:
    """Portals on the device: draws directions towards them and tells their density.

    Parameters
    ----------
    portals : list of Portal    In the compiled scene's frame, at least one.
    """

    def __init__(self, portals: list[Portal]):
        self.portals = portals
        self._rectangles = []
        for portal in portals:
            centre, u, v = (
                mi.Vector3f(*map(float, x)) for x in (portal.centre, portal.half_u, portal.half_v)
            )
            half_x, half_y = dr.norm(u), dr.norm(v)
            x, y = u / half_x, v / half_y
            made = (centre, x, y, dr.normalize(dr.cross(x, y)), half_x, half_y)
            dr.make_opaque(*made)
            self._rectangles.append(made)

    def _solid_angles(self, point) -> list:
        """Rough solid angle of each portal from a point, up to about 1. [sr]"""
        weights = []
        for centre, _, _, normal, half_x, half_y in self._rectangles:
            area = 4.0 * half_x * half_y
            away = centre - mi.Vector3f(point)
            squared = dr.squared_norm(away)
            cosine = dr.abs(dr.dot(away, normal)) * dr.rsqrt(dr.maximum(squared, 1e-12))
            weights.append(area * (cosine + 0.05) / (squared + area))
        return weights

    def _are_ahead(self, point) -> list:
        """Whether a point lies off the plane of each portal: from a sheet that is one, no sample can be aimed at it."""
        reach = dr.max(dr.abs(mi.Vector3f(point)))
        return [
            dr.abs(dr.dot(mi.Vector3f(point) - centre, normal))
            > OWN_PLANE * (dr.maximum(half_x, half_y) + reach)
            for centre, _, _, normal, half_x, half_y in self._rectangles
        ]

    def has_ahead(self, point):
        """Whether samples can be aimed at some portal from a point."""
        first, *others = self._are_ahead(point)
        for other in others:
            first |= other
        return first

    def _choices(self, point) -> list:
        """Probability of each portal from a point: by its rough solid angle."""
        pairs = zip(self._solid_angles(point), self._are_ahead(point), strict=True)
        weights = [dr.select(is_ahead, weight, 0.0) for weight, is_ahead in pairs]
        total = dr.maximum(sum(weights[1:], weights[0]), 1e-20)
        return [weight / total for weight in weights]

    def openness(self, point):
        """How much of the outside a point may see: rough solid angle of all portals, and a floor for points outside."""
        weights = self._solid_angles(point)
        return FLOOR_OPENNESS + sum(weights[1:], weights[0])

    def openness_of(self, points: np.ndarray) -> np.ndarray:
        """As `openness`, for points (k, 3) on the host. (k,)"""
        total = np.full(len(points), FLOOR_OPENNESS)
        for portal in self.portals:
            u, v = portal.half_u, portal.half_v
            normal = np.cross(u, v)
            area = 4.0 * np.linalg.norm(normal)
            normal = normal / np.linalg.norm(normal)
            away = portal.centre - points
            squared = (away**2).sum(axis=1)
            cosine = np.abs(away @ normal) / np.sqrt(np.maximum(squared, 1e-12))
            total += area * (cosine + 0.05) / (squared + area)
        return total

    def density(self, point, direction):
        """Solid-angle density with which `direction` would have drawn a direction. [1/sr]"""
        pdf = mi.Float(0.0)
        for rectangle, choice in zip(self._rectangles, self._choices(point), strict=True):
            centre, x, y, normal, half_x, half_y = rectangle
            q = into_axes(point, centre, x, y)
            cosine = dr.dot(direction, normal)
            distance = -q.z / dr.select(cosine == 0.0, 1e-12, cosine)
            inside = (
                (distance > 0.0)
                & (dr.abs(q.x + distance * dr.dot(direction, x)) <= half_x)
                & (dr.abs(q.y + distance * dr.dot(direction, y)) <= half_y)
            )
            angle = find_solid_angle(q, half_x, half_y)
            value = find_density(half_x, half_y, distance, cosine, angle)
            pdf += dr.select(inside, choice * value, 0.0)
        return pdf

    def direction(self, point, u, v):
        """Direction from a point to a place on one of the portals, for two numbers in [0, 1)."""
        target, start = mi.Vector3f(0.0, 0.0, 1.0), mi.Float(0.0)
        for rectangle, choice in zip(self._rectangles, self._choices(point), strict=True):
            centre, x, y, _, half_x, half_y = rectangle
            share = dr.clip((u - start) / dr.maximum(choice, 1e-20), 0.0, 1.0)
            sample = mi.Point2f(share, v)
            q = into_axes(point, centre, x, y)
            angle = find_solid_angle(q, half_x, half_y)
            place = draw_place(q, half_x, half_y, sample, angle)
            place = centre + x * (half_x * place.x) + y * (half_y * place.y)
            is_chosen = (u >= start) & (choice > 0.0)
            target = dr.select(is_chosen, place - mi.Vector3f(point), target)
            start += choice
        return dr.normalize(target)


def _connected(vertices, triangles) -> list[np.ndarray]:
    """Group triangles that share corner positions."""
    _, same = np.unique(np.round(vertices, 5), axis=0, return_inverse=True)
    corners = same.reshape(-1)[triangles]
    label = np.arange(corners.max() + 1)
    while True:
        lowest = label[corners].min(axis=1)
        before = label.copy()
        np.minimum.at(label, corners.ravel(), np.repeat(lowest, 3))
        label = label[label]
        if np.array_equal(label, before):
            break
    group = label[corners[:, 0]]
    return [triangles[group == g] for g in np.unique(group)]


def _rectangle(points) -> Portal | None:
    """Rectangle in the mean plane of points, sides along the first edge direction that makes it smallest."""
    centre = points.mean(axis=0)
    _, size, axes = np.linalg.svd(points - centre, full_matrices=False)
    if len(points) < 3 or size[1] <= 1e-9 or size[-1] > FLATNESS * size[0]:
        return None
    flat = (points - centre) @ axes[:2].T
    best = None
    for angle in np.linspace(0.0, np.pi / 2.0, 90, endpoint=False):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        turned = flat @ turn.T
        low, high = turned.min(axis=0), turned.max(axis=0)
        area = np.prod(high - low)
        if best is None or area < best[0]:
            best = (area, turn, low, high)
    _, turn, low, high = best
    directions = turn @ axes[:2]
    middle = centre + 0.5 * (low + high) @ directions
    # A little larger, so that rounding cannot put the pane's own edge outside.
    half = 0.5 * (high - low) * 1.001 + 1e-4
    return Portal(middle, half[0] * directions[0], half[1] * directions[1])
