"""Counts the files of the product whose functions run in a task: how far one has to read for it.

    python -m tests.house.files_run                a whole run, one interpolation, one vertex
    python -m tests.house.files_run --list         and their names, in the order of a reader
    python -m tests.house.files_run --list vertex  of one task

Imports do not count, nor what they call; only functions that the task itself calls.
"""

from __future__ import annotations

import inspect
import sys
import tempfile
import threading
from pathlib import Path
from types import FrameType, FunctionType
from typing import Any

import numpy as np

ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")


def files_of(task: FunctionType) -> list[str]:
    """Product files, by path below the repository, in which a function ran during the task.

    They are in the order in which they were entered first.
    """
    codes: dict[str, bool] = {}

    def note(frame: FrameType, event: str, argument: Any) -> None:
        # Bodies of modules and classes are no functions: they run when something is imported.
        code = frame.f_code
        if event != "call" or not code.co_flags & inspect.CO_OPTIMIZED or code.co_filename in codes:
            return
        above: FrameType | None = frame
        while above is not None and above.f_code is not task.__code__:
            if above.f_code.co_name == "<module>":
                return
            above = above.f_back
        codes[code.co_filename] = True

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        task()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    import motorcade.ga

    root = Path(motorcade.ga.__file__).parents[1]
    paths = [Path(name) for name in codes if Path(name).is_relative_to(root)]
    below = [path.relative_to(root) for path in paths]
    return [str(path) for path in below if path.parts[0] in ROOMS]


def run() -> FunctionType:
    """The whole graph on the embedded recording, computed from the start."""
    from motorcade.replays.cli import main

    def task() -> None:
        with tempfile.TemporaryDirectory() as folder:
            main(["demo", "--out", folder])

    return task


def interpolate() -> FunctionType:
    """The path between two motors; of one pose on it, what runs is compiled."""
    from motorcade.ga import Motor

    start, end = Motor.random(np.random.default_rng(0), (2,))
    return lambda: start.interpolate(end, np.linspace(0.0, 1.0, 1000))


def vertex() -> FunctionType:
    """A character's vertices, from a glTF file to pixels."""
    from motorcade.animation import mannequin, read_character, skin, write_gltf
    from motorcade.ga import Motor, Rotor
    from motorcade.render import Lighting, Sun, Surface, new_renderer
    from motorcade.tracking import Camera

    figure = mannequin()
    camera = Camera(320, 240, 250.0, 250.0, 159.5, 119.5)
    upright = Rotor.from_rotation_vector([-np.pi / 2, 0.0, 0.0])
    world_T_camera = Motor.from_rotor_translation(upright, [0.0, -3.0, 0.9])
    folder = tempfile.TemporaryDirectory()
    path = Path(folder.name, "figure.glb")
    write_gltf(path, figure)
    light = Lighting((0.3, 0.3, 0.3), Sun((0.3, 0.5, -0.8), 3.0), (), (0.0, 0.0, 0.9), 1.5)

    def task() -> None:
        read = read_character(path)
        folder.cleanup()
        vertices, normals = skin(read, read.clips[0].at(0.5))
        surface = Surface(vertices, normals, read.triangles, read.colors)
        with new_renderer("fast", camera.width, camera.height) as renderer:
            renderer.show([surface], light)
            renderer.render(camera, world_T_camera)

    return task


def smooth() -> FunctionType:
    """A path smoothed by the usual method."""
    from motorcade.fusion.motions import MOTIONS
    from motorcade.fusion.smoothing import smooth as smooth_path

    path = MOTIONS["handheld"].sampled(30.0, 4.0)
    return lambda: smooth_path(path)


def gesture() -> FunctionType:
    """An object of a scene dragged by one finger on an image."""
    from motorcade.animation.authoring import Drag, Scene, SceneEditor, VersorObjectPose
    from motorcade.animation.authoring.pointing import DragPlane, Ray, moved
    from motorcade.ga import Similarity

    still = VersorObjectPose(Similarity.identity())
    editor = SceneEditor(Scene({"cup": None}, {"cup": still}))
    plane = DragPlane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    rays = [Ray([x, 0.0, 2.0], [0.0, 0.0, -1.0]) for x in (0.0, 0.2)]

    def task() -> None:
        editor.begin(Drag("cup", "similarity", frame="parent"))
        editor.drag_to(moved(plane, *rays))
        editor.end()

    return task


def script() -> FunctionType:
    """A CLUScript written as C."""
    from motorcade.ga.codegen.programs import compile_script
    from motorcade.ga.codegen.targets import c
    from motorcade.ga.script import parse

    def task() -> None:
        program = compile_script(parse("?area = (x*e1) ^ (y*e2);", "area"), "area", None)
        c.write(program, None)

    return task


TASKS = {task.__name__: task for task in (run, smooth, interpolate, vertex, gesture, script)}


def main() -> None:
    named = [name for name in sys.argv[1:] if name != "--list"]
    for prepare in (TASKS[name] for name in named or TASKS):
        task_files = files_of(prepare())
        print(f"{len(task_files):4} files  {prepare.__doc__}")
        if "--list" in sys.argv:
            print("\n".join(f"       {name}" for name in task_files))


if __name__ == "__main__":
    main()
