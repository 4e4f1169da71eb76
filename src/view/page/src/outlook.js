// From where a picture is looked at: from where the way is seen, and near enough to fill the stage.

import * as THREE from "three";

/** Directions that are tried (rad about z), the usual one first. */
const AROUND = [-0.9, -0.3, 0.3, 0.9, -1.5, 1.5, 2.2, -2.2, 3.1];
const ABOVE = 0.5;
/** Points of the way that are looked for. */
const LOOKED_FOR = 24;

/** Boxes of the meshes of an object, in the world. */
export function boxesOf(object) {
  const boxes = [];
  object.updateWorldMatrix(true, true);
  object.traverse((part) => {
    if (!part.isMesh || part.isInstancedMesh || part.isLine2) return;
    part.geometry.boundingBox ?? part.geometry.computeBoundingBox();
    boxes.push(part.geometry.boundingBox.clone().applyMatrix4(part.matrixWorld));
  });
  return boxes;
}

/** The direction from which most of these points are hidden by fewest boxes. */
export function direction(points, boxes, middle, distance) {
  const step = Math.max(1, Math.floor(points.length / LOOKED_FOR));
  const looked = points.filter((_, i) => i % step === 0);
  const [hit, ray] = [new THREE.Vector3(), new THREE.Ray()];
  const hidden = (eye) => looked.filter((point) => {
    ray.set(eye, point.clone().sub(eye).normalize());
    const far = eye.distanceTo(point) * 0.995;
    return boxes.some((box) => ray.intersectBox(box, hit) && hit.distanceTo(eye) < far && !box.containsPoint(point));
  }).length;
  const directions = AROUND.map((angle) =>
    new THREE.Vector3(Math.cos(angle) * Math.cos(ABOVE), Math.sin(angle) * Math.cos(ABOVE), Math.sin(ABOVE)));
  const counts = directions.map((way) => hidden(middle.clone().addScaledVector(way, distance)));
  return directions[counts.indexOf(Math.min(...counts))];
}

/** Moves the camera along a direction so that these points fill its picture; gives the point that it looks at. */
export function fit(camera, points, way) {
  const target = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
  let distance = 2 * new THREE.Box3().setFromPoints(points).getSize(new THREE.Vector3()).length() + 0.1;
  for (let round = 0; round < 6; round++) {
    camera.position.copy(target).addScaledVector(way, distance);
    camera.lookAt(target);
    camera.updateMatrixWorld(true);
    const seen = new THREE.Box2();
    points.forEach((point) => seen.expandByPoint(point.clone().project(camera)));
    const [center, size] = [seen.getCenter(new THREE.Vector2()), seen.getSize(new THREE.Vector2())];
    const half = Math.tan((camera.fov * Math.PI) / 360) * distance;
    target.add(new THREE.Vector3(center.x * half * camera.aspect, center.y * half, 0).applyQuaternion(camera.quaternion));
    distance *= Math.max(size.x / 1.66, size.y / 1.72, 1e-3);
  }
  camera.position.copy(target).addScaledVector(way, distance);
  return target;
}
