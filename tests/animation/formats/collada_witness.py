"""A second reading of Collada scenes, written apart from the readers: one node, one time at once.

It follows the specification literally with the standard library's XML, the roots of numpy's
polynomials and scipy's rotations, and shares no code with the library. It knows translations,
rotations and scales in stacks, and channels that are Bézier curves of time and value.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
SPACE = "{http://www.collada.org/2005/11/COLLADASchema}"
MEMBER = {"X": 0, "Y": 1, "Z": 2, "ANGLE": 3}
BERNSTEIN = np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 3, 0, 0], [1, 0, 0, 0]], float)
"""Coefficients of u³ … 1 from four control values."""


class Curve:
    """A channel: control points as the file has them, one number of a transform each.

    Keys (K,), values (K, width), handles (K, width, 2) of time and value.
    """

    def __init__(self, keys: Array, values: Array, into: Array, out: Array) -> None:
        self.keys, self.values, self.into, self.out = keys, values, into, out

    def at(self, time_s: float) -> Array:
        """The numbers at a time, held before the first key and after the last."""
        if time_s <= self.keys[0]:
            return self.values[0]
        if time_s >= self.keys[-1]:
            return self.values[-1]
        k = int(np.flatnonzero(self.keys <= time_s)[-1])
        found = []
        for number in range(self.values.shape[1]):
            out, into = self.out[k, number], self.into[k + 1, number]
            clock = np.array([self.keys[k], out[0], into[0], self.keys[k + 1]])
            value = [self.values[k, number], out[1], into[1], self.values[k + 1, number]]
            cubic = BERNSTEIN @ clock - [0.0, 0.0, 0.0, time_s]
            roots = np.roots(np.where(np.abs(cubic) > 1e-12, cubic, 0.0))
            real = roots[np.abs(roots.imag) < 1e-7].real
            (u,) = real[(real > -1e-9) & (real < 1.0 + 1e-9)]
            found.append(np.polyval(BERNSTEIN @ value, u))
        return np.array(found)


class ColladaWitness:
    """The scene of a `.dae` and its curves."""

    def __init__(self, path: Path) -> None:
        self._root = ElementTree.parse(path).getroot()
        self._by_id = {one.get("id"): one for one in self._root.iter() if one.get("id")}
        self.curves: dict[tuple[str, str], list[tuple[slice, Curve]]] = {}
        for channel in self._root.iter(SPACE + "channel"):
            node, _, rest = channel.attrib["target"].partition("/")
            sid, _, member = rest.partition(".")
            where = slice(MEMBER[member], MEMBER[member] + 1) if member else slice(None)
            made = self._curve(channel.attrib["source"])
            self.curves.setdefault((node, sid), []).append((where, made))

    def world(self, time_s: float) -> dict[str, Array]:
        """World matrices (4, 4) of all nodes by identifier, in the file's axes and unit."""
        made: dict[str, Array] = {}
        scene = self._root.find(f".//{SPACE}visual_scene")
        assert scene is not None
        waiting = [(one, np.eye(4)) for one in scene.findall(SPACE + "node")]
        while waiting:
            node, above = waiting.pop()
            here = above @ self._local(node, time_s)
            made[node.attrib["id"]] = here
            waiting += [(one, here) for one in node.findall(SPACE + "node")]
        return made

    def span(self) -> tuple[float, float]:
        """First and last key of all curves."""
        keys = [curve.keys for parts in self.curves.values() for _, curve in parts]
        return min(float(k[0]) for k in keys), max(float(k[-1]) for k in keys)

    def _local(self, node: ElementTree.Element, time_s: float) -> Array:
        made = np.eye(4)
        for step in node:
            kind = step.tag.removeprefix(SPACE)
            if kind not in ("translate", "rotate", "scale"):
                continue
            values = np.array(step.text.split(), float)
            for where, curve in self.curves.get((node.attrib["id"], step.get("sid")), []):
                values[where] = curve.at(time_s)
            matrix = np.eye(4)
            if kind == "translate":
                matrix[:3, 3] = values
            elif kind == "scale":
                matrix[:3, :3] = np.diag(values)
            else:
                axis = values[:3] / np.linalg.norm(values[:3])
                matrix[:3, :3] = Rotation.from_rotvec(np.radians(values[3]) * axis).as_matrix()
            made = made @ matrix
        return made

    def _curve(self, source: str) -> Curve:
        sampler = self._by_id[source.removeprefix("#")]
        given = {
            one.get("semantic"): self._numbers(one.attrib["source"])
            for one in sampler
            if one.get("semantic") != "INTERPOLATION"
        }
        keys = given["INPUT"]
        into, out = (given[f"{side}_TANGENT"].reshape(len(keys), -1, 2) for side in ("IN", "OUT"))
        return Curve(keys, given["OUTPUT"].reshape(len(keys), -1), into, out)

    def _numbers(self, source: str) -> Array:
        array = self._by_id[source.removeprefix("#")].find(SPACE + "float_array")
        return np.array(array.text.split(), float)
