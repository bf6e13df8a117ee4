"""`make bench SUITE=render`: a frame of both renderers, colour and depth read back, with shadow.

Characters of about 5, 27 and 135 thousand triangles stand in 640 × 480 pixels under a sun with
shadow and two lamps; once more with a material of five maps of 1024 x 1024 texels (colour, metal
and roughness, normals, occlusion, emission), wound about them. Every frame moves the mesh, draws it
and reads it. pyrender alone draws the same scene with the same passes and without moving; our
pyrender renderer is measured beside it the same way. All take turns frame by frame, so that other
work on the machine meets all alike; the best frame counts, since everything else only adds to it.
Time of the processor is summed over its cores. The characters are the rigs of the data folder where
they are present, else balls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from time import perf_counter, process_time
from typing import Any

import numpy as np

from motorcade.animation import Character, Placement
from motorcade.animation.appearance import Appearance, Material, MaterialPart, TextureMap
from motorcade.animation.skin import palette, skin
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.render.backends.fast import FastRenderer
from motorcade.render.backends.platform import Context, choose_platform, new_context
from motorcade.render.backends.pyrender_backend import OffscreenRenderer
from motorcade.render.backends.renderer import (
    FAR_M,
    NEAR_M,
    OPENCV_T_OPENGL,
    Renderer,
    shadow_camera,
)
from motorcade.render.light import character_lighting
from motorcade.render.scene import Layer, Lighting, Surface
from motorcade.tracking.cameras.camera import Camera
from tests.bench.data import data_folder

__all__ = ["RenderRow", "bench_render", "render_table"]

RIGS = {
    4881: "astroboy/astro_max_dae.glb",
    26756: "makehuman/mh_male_ge53_27k.glb",
    134960: "makehuman/mh_male_ge53_135k_dressed.glb",
}
CAMERA = Camera(640, 480, 648.0, 648.0, 319.5, 239.5)
HEIGHT_M = 1.7
SUNLIGHT = np.array([-0.3, 0.35, -0.9]) / np.linalg.norm([-0.3, 0.35, -0.9])
FRAMES = 40
OURS, ALONE = "pyrender renderer", "pyrender alone"


@dataclass(frozen=True)
class RenderRow:
    """Milliseconds of the best frame: by the clock, and of the processor over all cores."""

    triangles: int
    drawn_by: str
    wall_ms: float
    cpu_ms: float


def bench_render() -> dict[str, Any]:
    """Measure everything. Returns a JSON-ready tree: the OpenGL driver, and rows (`RenderRow`).

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    rows: list[RenderRow] = []
    with FastRenderer(8, 8) as renderer:
        driver = renderer.driver
    for triangles, rig in RIGS.items():
        path = data_folder() / "rigs" / rig
        if path.is_file():
            from motorcade.animation.formats import read_character

            character = read_character(path)
            rows += _measured(_posed(character), character)
        else:
            rows += _measured(_ball(triangles), None)
    return {"driver": driver, "rows": [asdict(row) for row in rows]}


def render_table(found: Mapping[str, Any]) -> str:
    """A row a renderer and size, and how our pyrender renderer compares with pyrender alone."""
    lines = [f"{'a frame of 640 x 480, ' + found['driver']:<66}{'clock':>10}{'processor':>12}"]
    by_size: dict[int, dict[str, Any]] = {}
    for row in found["rows"]:
        by_size.setdefault(row["triangles"], {})[row["drawn_by"]] = row
    for triangles, rows in by_size.items():
        for drawn_by, row in rows.items():
            name = f"{triangles} triangles, {drawn_by}"
            lines.append(f"{name:<66}{row['wall_ms']:>7.1f} ms{row['cpu_ms']:>9.1f} ms")
        clock, processor = (rows[OURS][key] / rows[ALONE][key] for key in ("wall_ms", "cpu_ms"))
        name = f"{triangles} triangles, {OURS} over {ALONE}"
        lines.append(f"{name:<66}{clock:>10.2f}{processor:>12.2f}")
    return "\n".join(lines)


def _measured(surface: Surface, character: Character | None) -> list[RenderRow]:
    """Best frames of everything that can draw the surface, taken in turns."""
    light = character_lighting(_STAND, Motor.stack([_VIEW]), HEIGHT_M, SUNLIGHT)
    size = CAMERA.width, CAMERA.height
    with (
        FastRenderer(*size) as fast,
        FastRenderer(*size) as painted,
        OffscreenRenderer(*size) as ours,
    ):
        context = new_context(choose_platform(), *size)
        fast.show([surface], light)
        painted.show([replace(surface, appearance=_paint(surface))], light)
        ours.show([surface], light)
        ours.render(CAMERA, _VIEW)
        alone = _pyrender_alone(context, surface, light)
        jobs: dict[str, Callable[[], object]] = {"fast renderer": lambda: _moved(fast, surface)}
        jobs["fast renderer, textured"] = lambda: _moved(painted, surface)
        if character is not None:
            entries = _palette(character)
            fast.bind(0, character, "motor")
            placement = _placement(character)
            jobs["fast renderer, carried in a shader"] = lambda: _carried(fast, entries, placement)
        jobs["pyrender renderer, moved"] = lambda: _moved(ours, surface)
        jobs[OURS] = lambda: ours.render(CAMERA, _VIEW)
        jobs[ALONE] = alone
        best = _best(jobs)
        context.destroy()
    count = len(surface.triangles)
    return [RenderRow(count, name, *spent) for name, spent in best.items()]


def _best(jobs: Mapping[str, Callable[[], object]]) -> dict[str, tuple[float, float]]:
    """Milliseconds by the clock and of the processor, the best of each job."""
    best = dict.fromkeys(jobs, (np.inf, np.inf))
    for turn in range(FRAMES + 1):
        for name, draw in jobs.items():
            clock, processor = perf_counter(), process_time()
            draw()
            spent = 1e3 * (perf_counter() - clock), 1e3 * (process_time() - processor)
            if turn:  # the first frame compiles and uploads
                best[name] = min(best[name][0], spent[0]), min(best[name][1], spent[1])
    return best


def _moved(renderer: Renderer, surface: Surface) -> Layer:
    renderer.move(0, surface.vertices, surface.normals)
    return renderer.render(CAMERA, _VIEW)


def _carried(renderer: FastRenderer, entries: FloatArray, placement: Placement) -> Layer:
    renderer.pose(0, entries, placement)
    return renderer.render(CAMERA, _VIEW)


def _pyrender_alone(context: Context, surface: Surface, light: Lighting) -> Callable[[], object]:
    """Pyrender's own renderer on a scene of its own; it needs to have been imported by ours."""
    import pyrender

    white = np.ones((len(surface.vertices), 3)) if surface.colors is None else surface.colors
    look = pyrender.MetallicRoughnessMaterial(metallicFactor=0.0, roughnessFactor=surface.roughness)
    mesh = pyrender.Primitive(
        surface.vertices,
        surface.normals,
        color_0=np.concatenate([white, np.ones((len(white), 1))], axis=1),
        indices=surface.triangles,
        material=look,
    )
    scene = pyrender.Scene(bg_color=(0.0, 0.0, 0.0, 0.0), ambient_light=light.ambient)
    scene.add(pyrender.Mesh([mesh]))
    sun = pyrender.DirectionalLight(light.sun.color, light.sun.intensity)
    scene.add(sun, pose=shadow_camera(light)[0].as_matrix())
    for lamp in light.lamps:
        pose = np.eye(4)
        pose[:3, 3] = lamp.position_m
        scene.add(pyrender.PointLight(lamp.color, lamp.intensity), pose=pose)
    lens = pyrender.IntrinsicsCamera(
        CAMERA.fx, CAMERA.fy, CAMERA.cx + 0.5, CAMERA.cy + 0.5, NEAR_M, FAR_M
    )
    scene.add(lens, pose=(_VIEW @ OPENCV_T_OPENGL).as_matrix())
    context.make_current()
    renderer = pyrender.renderer.Renderer(CAMERA.width, CAMERA.height)
    flags = pyrender.RenderFlags
    wanted = flags.OFFSCREEN | flags.RGBA | flags.SHADOWS_DIRECTIONAL

    def draw() -> object:
        context.make_current()
        return renderer.render(scene, wanted)

    return draw


def _placement(character: Character) -> Placement:
    return Placement(Motor.identity(), HEIGHT_M / character.height_m)


def _palette(character: Character) -> FloatArray:
    return palette(character.skeleton, character.clips[0].at(0.3), "motor")[0]


def _posed(character: Character) -> Surface:
    vertices, normals = skin(character, character.clips[0].at(0.3), "motor")
    return Surface(
        _placement(character).apply(vertices), normals, character.triangles, character.colors
    )


def _ball(triangles: int) -> Surface:
    """An upright egg as high as a character, of about so many triangles."""
    rings = round(np.sqrt(triangles / 4.0)) + 1
    across, around = np.meshgrid(
        np.linspace(0.0, np.pi, rings), np.linspace(0.0, 2.0 * np.pi, 2 * rings), indexing="ij"
    )
    out = [np.sin(across) * np.cos(around), np.sin(across) * np.sin(around), np.cos(across)]
    normals = np.stack(out, axis=-1).reshape(-1, 3)
    number = np.arange(len(normals)).reshape(rings, 2 * rings)
    corner = [number[i : rings - 1 + i, j : 2 * rings - 1 + j] for i in (0, 1) for j in (0, 1)]
    faces = [np.stack([corner[k] for k in row], -1) for row in ((0, 2, 1), (1, 2, 3))]
    half = np.array([0.15, 0.15, 0.5]) * HEIGHT_M
    middle = np.array([0.0, 0.0, 0.5 * HEIGHT_M])
    return Surface(middle + half * normals, normals, np.concatenate(faces).reshape(-1, 3))


def _paint(surface: Surface) -> Appearance:
    """Five maps of smooth noise, once about the upright axis and once from foot to head."""
    rng = np.random.default_rng(0)

    def noise(low: float, high: float) -> TextureMap:
        coarse = rng.uniform(low, high, (128, 128, 4)).astype(np.uint8)
        coarse[..., 3] = 255
        return TextureMap(np.ascontiguousarray(np.kron(coarse, np.ones((8, 8, 1), np.uint8))))

    x, y, z = surface.vertices.T
    around = np.arctan2(y, x) / (2.0 * np.pi) + 0.5
    places = np.stack([around, 1.0 - z / HEIGHT_M], axis=1).astype(np.float32)
    normals = noise(98, 158)
    normals.pixels[..., 2] = 255
    material = Material(
        base_map=noise(0, 256),
        metallic_roughness_map=noise(0, 256),
        normal_map=normals,
        occlusion_map=noise(128, 256),
        emission=(0.1, 0.1, 0.1),
        emission_map=noise(0, 256),
    )
    part = MaterialPart(material, 0, len(surface.triangles))
    return Appearance((part,), places[None])


def _view() -> Motor:
    """`world_T_camera` 3.9 m before the character, level with its middle."""
    forward = Rotor.from_matrix(np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]))
    return Motor.from_rotor_translation(forward, np.array([3.9, 0.0, 0.5 * HEIGHT_M]))


_STAND = Placement(Motor.identity(), 1.0)
_VIEW = _view()
