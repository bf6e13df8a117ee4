// A character as three.js draws it, posed by the joints that Python computed for every frame.
//
// The joints stand in the character's own space and are no part of the scene, and the skin is
// bound detached: three.js would else take the placement off again that the mesh has in the world.

import {
  GLTFLoader,
  Group,
  Matrix4,
  MeshLambertMaterial,
  Quaternion,
  Vector3,
} from "studio/vendor.js";
import { behindThings } from "studio/hiding.js";
import { behindLens } from "studio/lens.js";
import { bytesOf, row } from "studio/look.js";

const place = new Vector3();
const turn = new Quaternion();
const size = new Vector3();

/** Sets a matrix from x y z, w x y z, and a scale. @returns {Matrix4} */
export function setPose(matrix, pose, scale = 1) {
  place.set(pose[0], pose[1], pose[2]);
  turn.set(pose[4], pose[5], pose[6], pose[3]);
  return matrix.compose(place, turn, size.setScalar(scale));
}

// What a matt material takes over from one with metal and roughness.
const KEPT = [
  ...["name", "map", "alphaMap", "emissiveMap", "normalMap", "normalScale", "aoMap", "side"],
  ...["color", "emissive", "emissiveIntensity", "opacity", "transparent", "alphaTest"],
  ...["vertexColors", "depthWrite", "flatShading"],
];

const footage = { greyFootage: { value: false } };
const GREY = `#include <colorspace_fragment>
  // Luma of Rec. 709 on the stored values, as the film has it.
  if (greyFootage) gl_FragColor.rgb = vec3(dot(gl_FragColor.rgb, vec3(0.2126, 0.7152, 0.0722)));`;

/** Draw figures as the footage is. @param {boolean} grey whether it has no colour */
export function drawGrey(grey) {
  footage.greyFootage.value = grey;
}

/** Take the footage's colours on, or its lack of them. */
function likeFootage(material) {
  const before = material.onBeforeCompile;
  material.onBeforeCompile = (shader, renderer) => {
    before.call(material, shader, renderer);
    Object.assign(shader.uniforms, footage);
    shader.fragmentShader = `uniform bool greyFootage;\n${shader.fragmentShader.replace("#include <colorspace_fragment>", GREY)}`;
  };
  material.customProgramCacheKey = () => "figure";
  return material;
}

/** A matt material in place of a glossy one: half as dear to draw, and the film shows the gloss. */
function matt(material) {
  if (!material.isMeshStandardMaterial) return likeFootage(behindThings(behindLens(material)));
  const kept = Object.fromEntries(KEPT.map((name) => [name, material[name]]));
  return likeFootage(behindThings(behindLens(new MeshLambertMaterial(kept))));
}

export class Figure {
  /** @param {object} character of a look @returns {Promise<Figure>} */
  static async load(character) {
    const gltf = await new GLTFLoader().parseAsync(bytesOf(character.gltf).buffer, "");
    return new Figure(character, gltf.scene);
  }

  constructor(character, loaded) {
    this.character = character;
    this.object = new Group();
    this.object.name = character.name;
    this.object.matrixAutoUpdate = false;
    this.meshes = [];
    loaded.traverse((one) => {
      if (one.isMesh) this.meshes.push(one);
    });
    for (const mesh of this.meshes) this.#take(mesh);
    this.show(0);
  }

  #take(mesh) {
    mesh.removeFromParent();
    mesh.position.set(0, 0, 0);
    mesh.quaternion.identity();
    mesh.scale.setScalar(1);
    mesh.frustumCulled = false;
    mesh.material = matt(mesh.material);
    if (mesh.isSkinnedMesh) {
      mesh.bindMode = "detached";
      mesh.bindMatrix.identity();
      mesh.bindMatrixInverse.identity();
      for (const bone of mesh.skeleton.bones) bone.matrixWorldAutoUpdate = false;
    }
    this.object.add(mesh);
  }

  /** Take the pose of a frame, or another that its joints are dragged to. */
  show(frame, dragged = null) {
    const { joints, morphs, world_T_character: stands } = this.character;
    const stand = row(stands, frame);
    const all = dragged ?? row(joints, frame);
    this.shown = all;
    for (const mesh of this.meshes) {
      if (mesh.isSkinnedMesh) {
        mesh.skeleton.bones.forEach((bone, number) => {
          const pose = all.subarray(8 * number, 8 * number + 8);
          setPose(bone.matrixWorld, pose, pose[7]);
        });
      }
      if (morphs) mesh.morphTargetInfluences?.splice(0, Infinity, ...row(morphs, frame));
    }
    setPose(this.object.matrix, stand, stand[7]);
    this.object.matrixWorldNeedsUpdate = true;
  }

  /** Where a joint of the pose on show is, in the world. @returns {Vector3} */
  joint(number) {
    const at = new Vector3(...this.shown.subarray(8 * number, 8 * number + 3));
    return at.applyMatrix4(this.object.matrix);
  }

  /** Where on the ground the root stands, in the world. @returns {Vector3} */
  footing(into) {
    const shown = this.meshes.find((one) => one.isSkinnedMesh)?.skeleton.bones[0].matrixWorld;
    into.setFromMatrixPosition(shown ?? new Matrix4());
    return into.setZ(0).applyMatrix4(this.object.matrix);
  }

  /**
   * Vertices of the pose on show, in the world: what tests compare with Python's.
   *
   * @returns {Vector3[]}
   */
  vertices() {
    this.object.updateMatrixWorld(true);
    return this.meshes.flatMap((mesh) => {
      mesh.skeleton?.update();
      const count = mesh.geometry.attributes.position.count;
      return Array.from({ length: count }, (_, index) =>
        mesh.getVertexPosition(index, new Vector3()).applyMatrix4(mesh.matrixWorld),
      );
    });
  }
}
