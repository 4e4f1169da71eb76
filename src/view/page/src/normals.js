// Normals that leave round parts round and edges sharp.

import * as THREE from "three";

/** Triangles of an indexed geometry, each corner with the mean normal of the faces there that turn less than `angle`. */
export function creased(positions, triangles, angle) {
  const count = triangles.length / 3;
  const faces = new Float32Array(triangles.length);
  const at = new Int32Array(positions.length / 3 + 1);
  const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  for (let face = 0; face < count; face++) {
    [a, b, c].forEach((corner, k) => corner.fromArray(positions, 3 * triangles[3 * face + k]));
    b.sub(a).cross(c.sub(a)).normalize().toArray(faces, 3 * face);
    for (let k = 0; k < 3; k++) at[triangles[3 * face + k] + 1]++;
  }
  for (let vertex = 1; vertex < at.length; vertex++) at[vertex] += at[vertex - 1];
  const around = new Int32Array(triangles.length);
  const next = at.slice();
  triangles.forEach((vertex, corner) => (around[next[vertex]++] = Math.floor(corner / 3)));
  const corners = new Float32Array(triangles.length * 3);
  const normals = new Float32Array(triangles.length * 3);
  const least = Math.cos(angle);
  triangles.forEach((vertex, corner) => {
    const own = 3 * Math.floor(corner / 3);
    let [x, y, z] = [0, 0, 0];
    for (let i = at[vertex]; i < at[vertex + 1]; i++) {
      const other = 3 * around[i];
      const turn = faces[own] * faces[other] + faces[own + 1] * faces[other + 1] + faces[own + 2] * faces[other + 2];
      if (turn < least) continue;
      x += faces[other];
      y += faces[other + 1];
      z += faces[other + 2];
    }
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], 3 * corner);
    corners.set(positions.subarray(3 * vertex, 3 * vertex + 3), 3 * corner);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
  return geometry;
}
