// A robot as the loader makes it of the picture's URDF, and solids of scenes.

import * as THREE from "three";
import URDFLoader from "urdf-loader";
import { creased } from "./normals.js";

function bytes(text) {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0)).buffer;
}

/** Geometries of the picture's meshes, by number; each is made when it is first asked for. */
export class Meshes {
  constructor(meshes) {
    this.meshes = meshes;
    this.made = [];
  }

  geometry(number) {
    return (this.made[number] ??= this.make(this.meshes[number]));
  }

  make({ vertices, triangles }) {
    return creased(new Float32Array(bytes(vertices)), new Uint32Array(bytes(triangles)), Math.PI / 5);
  }
}

/** A capsule along z, as ours are. */
function capsule(radius, length) {
  return new THREE.CapsuleGeometry(radius, length, 12, 24).rotateX(Math.PI / 2);
}

function standing(material) {
  return new THREE.MeshStandardMaterial({ color: material.color, opacity: material.opacity,
    transparent: material.opacity < 1, roughness: 0.62, metalness: 0.12 });
}

/** The robot of a picture, with visuals and colliders, at its zero. */
export function robotOf(picture, meshes) {
  const loader = new URDFLoader();
  loader.parseCollision = true;
  loader.loadMeshCb = (name, _manager, material, done) => {
    const [kind, ...numbers] = name.split(":");
    const geometry = kind === "mesh" ? meshes.geometry(Number(numbers[0])) : capsule(...numbers.map(Number));
    done(new THREE.Mesh(geometry, material));
  };
  const robot = loader.parse(picture.urdf);
  for (const object of [...Object.values(robot.links)]) {
    for (const part of object.children) {
      if (!part.isURDFVisual && !part.isURDFCollider) continue;
      part.traverse((mesh) => {
        if (mesh.isMesh) mesh.material = standing(mesh.material);
        mesh.userData.link = object.urdfName;
      });
      if (part.isURDFCollider) part.visible = false;
    }
  }
  return ready(robot, picture);
}

/** Another robot of the same shapes, in one material. */
export function ghostOf(robot, picture, material) {
  const ghost = robot.clone();
  ghost.traverse((object) => {
    if (object.isMesh) object.material = material;
  });
  return ready(ghost, picture);
}

function ready(robot, picture) {
  for (const joint of Object.values(robot.joints)) {
    joint.ignoreLimits = true;
    joint.origPosition ??= joint.position.clone();
    joint.origQuaternion ??= joint.quaternion.clone();
  }
  for (const { joint, kind, values } of picture.held) setJoint(robot.joints[joint], kind, values);
  return robot;
}

function setJoint(joint, kind, values) {
  if (kind !== "planar" && kind !== "floating") {
    joint.setJointValue(values[0]);
    return;
  }
  // A floating joint's rotation is a quaternion here, and the loader's is none.
  const [x, y] = values;
  const turn = new THREE.Quaternion();
  if (kind === "planar") turn.setFromAxisAngle(new THREE.Vector3(0, 0, 1), values[2]);
  else turn.set(...values.slice(3, 7)).normalize();
  joint.jointValue = [...values];
  const shift = new THREE.Vector3(x, y, kind === "planar" ? 0 : values[2]);
  joint.position.copy(shift.applyQuaternion(joint.origQuaternion)).add(joint.origPosition);
  joint.quaternion.copy(joint.origQuaternion).multiply(turn);
  joint.matrixWorldNeedsUpdate = true;
}

/** Places a robot at a configuration. */
export function place(robot, picture, configuration) {
  for (const { joint, kind, q } of picture.driven) {
    const count = kind === "planar" ? 3 : kind === "floating" ? 7 : 1;
    setJoint(robot.joints[joint], kind, configuration.slice(q, q + count));
  }
  robot.updateMatrixWorld(true);
}

/** An object of the scene. */
export function objectOf(object, meshes, material) {
  const group = new THREE.Group();
  group.name = object.name;
  setPose(group, object.pose);
  for (const solid of object.solids) {
    const mesh = solidOf(solid, meshes, material.clone());
    mesh.userData.object = object.name;
    group.add(mesh);
  }
  return group;
}

/** A solid where it is in its object. */
export function solidOf(solid, meshes, material) {
  const mesh = new THREE.Mesh(geometryOf(solid, meshes), material);
  setPose(mesh, solid.pose);
  return mesh;
}

function geometryOf(solid, meshes) {
  switch (solid.kind) {
    case "box": return new THREE.BoxGeometry(...solid.size);
    case "sphere": return new THREE.SphereGeometry(solid.radius, 32, 20);
    case "cylinder": return new THREE.CylinderGeometry(solid.radius, solid.radius, solid.length, 40).rotateX(Math.PI / 2);
    case "capsule": return capsule(solid.radius, solid.length);
    default: return meshes.geometry(solid.mesh);
  }
}

function setPose(object, [x, y, z, i, j, k, w]) {
  object.position.set(x, y, z);
  object.quaternion.set(i, j, k, w);
}

/** Joints that a finger has at most; a longer chain is an arm. */
const FINGER = 2;

/** Links whose way tells where the robot goes: what moves last in each chain; of a hand, what carries its fingers. */
export function tips(robot, picture) {
  const moving = new Set(picture.driven.map(({ joint }) => joint));
  const below = (object) => object.children.flatMap((child) => (child.isURDFJoint ? [child] : []));
  // Of a link: the next moving joints below it.
  const next = (link) => below(link).flatMap((joint) => {
    const child = joint.children.find((part) => part.isURDFLink);
    if (!child) return [];
    return moving.has(joint.urdfName) || joint.mimicJoint ? [child] : next(child);
  });
  const found = [];
  const walk = (link) => {
    const after = next(link);
    const isHand = after.length > 1 && after.every((child) => isFinger(child, FINGER));
    if (after.length === 0 || isHand) found.push(link);
    else after.forEach(walk);
  };
  const isFinger = (link, joints) => {
    const after = next(link);
    return joints > 0 && (after.length === 0 || (after.length === 1 && isFinger(after[0], joints - 1)));
  };
  const first = next(robot);
  // A robot that branches at its root has a tip in each branch.
  (first.length ? first : [robot]).forEach(walk);
  return found;
}
