"""The driver's view of a room, rendered with numpy: walls, floor, ceiling, furniture and people.

Each pixel is an index into a palette of materials times shades; one table turns it into colour.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import Float32Array, FloatArray
from gazesim.rooms import WALL_HEIGHT_M, Room, Solid

WIDTH = 640
HEIGHT = 480
EYE_M = 1.15
EYE_X_M = 0.30  # before the drive axle
_FIELD_DEG = 75.0
_HORIZON = 215  # row: the camera looks slightly down
_SHADES = 64

_COLOURS = {
    "wall": (226, 217, 201),
    "skirting": (246, 243, 236),
    "floor": (176, 128, 84),
    "ceiling": (246, 245, 241),
    "sofa": (82, 110, 128),
    "cupboard": (142, 104, 70),
    "wood": (166, 120, 76),
    "pot": (186, 98, 66),
    "plant": (78, 134, 74),
    "window": (176, 214, 236),
    "glass": (190, 216, 224),
    "mirror": (204, 208, 216),
    "picture": (196, 96, 84),
    "door": (206, 186, 154),
    "trousers": (58, 66, 92),
    "shirt": (190, 78, 70),
    "skin": (226, 180, 150),
}
_INDEX = {name: number * _SHADES for number, name in enumerate(_COLOURS)}

Image = NDArray[np.uint16]


def _palette() -> NDArray[np.uint32]:
    # Packed as bytes R, G, B, unused; the darkest shade is 35 %.
    shade = np.linspace(0.35, 1.06, _SHADES)[None, :, None]
    rgb = np.clip(np.array(list(_COLOURS.values()))[:, None, :] * shade, 0, 255)
    packed = np.zeros((len(_COLOURS) * _SHADES, 4), dtype=np.uint8)
    packed[:, :3] = rgb.reshape(-1, 3).astype(np.uint8)
    return packed.view(np.uint32)[:, 0]


def _planks() -> NDArray[np.int16]:
    """A floor of planks, 128 x 128 texels of 1/32 m: each texel's addition to the shade."""
    random = np.random.default_rng(5)
    texels = np.zeros((128, 128), dtype=np.int16)
    for row in range(0, 128, 8):
        texels[row : row + 8] += random.integers(-5, 6)
        joint = int(random.integers(0, 128))
        texels[row : row + 8] += np.where((np.arange(128) - joint) % 128 < 64, 2, -2)
        texels[row : row + 8, joint] -= 9
        texels[row] -= 8
    return texels


class Renderer:
    """Renders frames of WIDTH x HEIGHT; keeps its tables and buffers between them."""

    def __init__(self) -> None:
        self._palette = _palette()
        self._planks = _planks()
        half = math.tan(math.radians(_FIELD_DEG / 2))
        self._focal = WIDTH / 2 / half
        # Left to right on the picture is from left (positive) to right of the view.
        self._across = (half * (1.0 - 2.0 * (np.arange(WIDTH) + 0.5) / WIDTH)).astype(np.float64)
        self._rows = np.arange(HEIGHT, dtype=np.float32)[:, None]
        below = np.arange(_HORIZON + 2, HEIGHT)
        self._floor_m = EYE_M * self._focal / (below - _HORIZON)
        self._floor_shade = self._shade(self._floor_m).astype(np.int16)
        self._dither = (np.indices((HEIGHT, WIDTH)).sum(axis=0) % 2).astype(np.uint16)
        above = np.arange(_HORIZON + 2)
        far = (WALL_HEIGHT_M - EYE_M) * self._focal / np.maximum(_HORIZON - above, 1)
        self._ceiling = (_INDEX["ceiling"] + self._shade(far)).astype(np.uint16)

    @staticmethod
    def _shade(distance_m: FloatArray) -> FloatArray:
        return np.asarray(np.clip(60.0 - 7.0 * np.sqrt(distance_m), 6, 60))

    def render(self, room: Room, x_m: float, y_m: float, heading_deg: float) -> bytes:
        """The view from the chair at that pose: HEIGHT x WIDTH pixels of R, G, B and one unused."""
        heading = math.radians(heading_deg)
        c, s = math.cos(heading), math.sin(heading)
        eye = (x_m + EYE_X_M * c, y_m + EYE_X_M * s)
        rays = np.array((c - s * self._across, s + c * self._across))  # 1 m deep each
        image = np.empty((HEIGHT, WIDTH), dtype=np.uint16)
        self._draw_floor(image, eye, rays)
        image[: _HORIZON + 2] = self._ceiling[:, None]
        depth = self._draw_walls(image, room, eye, rays)
        self._draw_solids(image, room, eye, (c, s), rays, depth)
        pixels: NDArray[np.uint32] = np.take(self._palette, image + self._dither)
        return pixels.tobytes()

    def _draw_floor(self, image: Image, eye: tuple[float, float], rays: FloatArray) -> None:
        along = self._floor_m[:, None].astype(np.float32) * 32.0
        u = (along * rays[0].astype(np.float32) + np.float32(eye[0] * 32.0)).astype(np.int32)
        v = (along * rays[1].astype(np.float32) + np.float32(eye[1] * 32.0)).astype(np.int32)
        texture = self._planks.ravel()[((v & 127) << 7) | (u & 127)]
        shade = texture + self._floor_shade[:, None]
        image[_HORIZON + 2 :] = np.maximum(shade, 1).astype(np.uint16) + _INDEX["floor"]

    def _row(self, height_m: float, depth: FloatArray) -> Float32Array:
        """The picture's row of something at that height and depth, per column."""
        return (_HORIZON - (height_m - EYE_M) * self._focal / depth).astype(np.float32)

    def _draw_walls(
        self, image: Image, room: Room, eye: tuple[float, float], rays: FloatArray
    ) -> FloatArray:
        depth, side, along = _nearest(_walls(room), eye, rays)
        shade = self._shade(depth) - 9.0 * side
        paper = np.where((along * 4.0).astype(np.int64) % 2 == 0, 0.0, -2.0)  # striped wallpaper
        colour = (_INDEX["wall"] + np.clip(shade + paper, 1, 62)).astype(np.uint16)
        rows = self._rows
        top, foot = self._row(WALL_HEIGHT_M, depth), self._row(0.0, depth)
        np.copyto(image, colour, where=(rows >= top) & (rows < foot))
        skirting = (_INDEX["skirting"] + np.clip(shade, 1, 62)).astype(np.uint16)
        np.copyto(image, skirting, where=(rows >= self._row(0.08, depth)) & (rows < foot))
        return depth

    def _draw_solids(
        self,
        image: Image,
        room: Room,
        eye: tuple[float, float],
        forward: tuple[float, float],
        rays: FloatArray,
        depth: FloatArray,
    ) -> None:
        solids = [one for one in room.solids() if not _is_wall(one)]
        shapes = [(np.array(s.corners), s.z0_m, s.z1_m, s.material) for s in solids]
        for person in room.people:
            shapes += _figure(person.x_m, person.y_m)
        seen = []
        for corners, z0_m, z1_m, material in shapes:
            relative = corners - eye
            deep = relative @ forward
            if deep.max() > 0.1:
                seen.append((float(deep.mean()), z0_m, relative, deep, z1_m, material))
        seen.sort(key=lambda shape: (-round(shape[0], 1), shape[1]))
        for _, z0_m, relative, deep, z1_m, material in seen:
            columns = self._columns(relative, deep, forward)
            self._draw_solid(image, columns, relative, rays, depth, z0_m, z1_m, material)

    def _columns(
        self, relative: FloatArray, deep: FloatArray, forward: tuple[float, float]
    ) -> slice:
        """The columns a shape can be seen in."""
        if deep.min() < 0.1:
            return slice(0, WIDTH)
        left = relative @ (-forward[1], forward[0])
        columns = WIDTH / 2 - self._focal * left / deep
        return slice(max(0, int(columns.min())), max(0, min(WIDTH, int(columns.max()) + 2)))

    def _draw_solid(
        self,
        image: Image,
        columns: slice,
        relative: FloatArray,
        rays: FloatArray,
        depth: FloatArray,
        z0_m: float,
        z1_m: float,
        material: str,
    ) -> None:
        if columns.stop <= columns.start:
            return
        near, far, side = _through(relative, rays[:, columns])
        hit = (near < far) & (far > 0.05) & (near < depth[columns] + 0.02)
        if not hit.any():
            return
        near = np.where(hit, np.maximum(near, 0.05), 1e3)
        far = np.where(hit, far, 1e3)
        shade = np.clip(self._shade(near) - 8.0 * side, 1, 62)
        base = _INDEX[material]
        top, foot = self._row(z1_m, near), self._row(z0_m, near)
        lid = self._row(z1_m, far) if z1_m < EYE_M else top
        first = max(0, int(lid[hit].min()))
        last = min(HEIGHT, int(foot[hit].max()) + 1)
        rows, part = self._rows[first:last], image[first:last, columns]
        face = (base + shade).astype(np.uint16)
        np.copyto(part, face, where=(rows >= top) & (rows < foot) & hit)
        if z1_m < EYE_M:
            face = (base + np.clip(shade + 6.0, 1, 62)).astype(np.uint16)
            np.copyto(part, face, where=(rows >= lid) & (rows < top) & hit)


def _is_wall(solid: Solid) -> bool:
    return solid.z0_m <= 0.0 and solid.z1_m >= WALL_HEIGHT_M


def _walls(room: Room) -> FloatArray:
    """Rows x1, y1, x2, y2 of everything that reaches from floor to ceiling."""
    rows = list(room.walls)
    for solid in room.solids():
        if _is_wall(solid):
            rows += solid.edges()
    return np.array(rows, dtype=np.float64)


def _nearest(
    walls: FloatArray, eye: tuple[float, float], rays: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Per ray: depth of the nearest wall, how sideways it faces (0..1), place along it in m."""
    ax, ay = walls[:, 0] - eye[0], walls[:, 1] - eye[1]
    ex, ey = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
    dx, dy = rays[0][:, None], rays[1][:, None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / (dx * ey - dy * ex)
        depth = (ax * ey - ay * ex) * inverse
        share = (ax * dy - ay * dx) * inverse
        depth[~((depth > 0.02) & (share >= 0.0) & (share <= 1.0))] = 1e3
    best = depth.argmin(axis=1)
    chosen = (np.arange(len(best)), best)
    length = np.hypot(ex, ey)
    along = np.nan_to_num(share[chosen]) * length[best]
    return depth[chosen], np.abs(ey / length)[best], along


def _through(corners: FloatArray, rays: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Per ray: depth where it enters and leaves a convex shape, how sideways it enters."""
    near = np.full(rays.shape[1], -1e3)
    far = np.full(rays.shape[1], 1e3)
    side = np.zeros(rays.shape[1])
    count = len(corners)
    for k in range(count):
        (ax, ay), (bx, by) = corners[k], corners[(k + 1) % count]
        nx, ny = by - ay, ax - bx  # outward normal of a counter-clockwise shape
        length = math.hypot(nx, ny)
        towards = nx * rays[0] + ny * rays[1]
        towards = np.where(np.abs(towards) < 1e-9, 1e-9, towards)
        depth = (nx * ax + ny * ay) / towards
        entering = towards < 0.0
        later = entering & (depth > near)
        side = np.where(later, abs(nx) / length, side)
        near = np.where(later, depth, near)
        far = np.where(~entering & (depth < far), depth, far)
    return near, far, side


def _figure(x_m: float, y_m: float) -> list[tuple[FloatArray, float, float, str]]:
    """A standing person of three stacked prisms."""
    angles = np.arange(8) * math.pi / 4
    ring = np.column_stack((np.cos(angles), np.sin(angles)))
    parts = ((0.17, 0.0, 0.85, "trousers"), (0.22, 0.85, 1.45, "shirt"), (0.11, 1.47, 1.75, "skin"))
    return [(ring * radius + (x_m, y_m), z0, z1, name) for radius, z0, z1, name in parts]
