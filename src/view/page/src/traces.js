// The ways of the robot's tips: a line along each path, with its waypoints.

import * as THREE from "three";
import { Line2 } from "three/examples/jsm/lines/Line2.js";
import { LineGeometry } from "three/examples/jsm/lines/LineGeometry.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";

const SAMPLES = 240;
/** A tip that keeps within this (m) on every path is not traced. */
const STILL = 1e-3;

/** Lines of the tips, for each named track. */
export function traces(tips, pose, tracks) {
  const drawn = tracks.map(([kind, track]) => ({ kind, ways: ways(tips, pose, track) }));
  const moves = tips.map((_, tip) => drawn.some(({ ways }) => extent(ways[tip].points) > STILL));
  return drawn.flatMap(({ kind, ways }) => ways.filter((_, tip) => moves[tip]).map((way) => line(kind, way)));
}

function ways(tips, pose, track) {
  const found = tips.map((tip) => ({ tip: tip.urdfName, points: [], waypoints: [] }));
  const marks = new Set(track.rows.map((_, i) => track.position(Math.max(0, i - 1), i === 0 ? 0 : 1)));
  for (const position of track.samples(SAMPLES)) {
    pose(track.at(position));
    tips.forEach((tip, i) => {
      const point = tip.getWorldPosition(new THREE.Vector3());
      found[i].points.push(point);
      if (marks.has(position)) found[i].waypoints.push(point);
    });
  }
  return found;
}

function extent(points) {
  return new THREE.Box3().setFromPoints(points).getSize(new THREE.Vector3()).length();
}

function line(kind, { tip, points, waypoints }) {
  const geometry = new LineGeometry();
  geometry.setPositions(points.flatMap((point) => point.toArray()));
  const material = new LineMaterial({ linewidth: kind === "before" ? 2.5 : 4, worldUnits: false });
  const line = new Line2(geometry, material);
  line.name = `${kind} ${tip}`;
  const balls = new THREE.InstancedMesh(new THREE.SphereGeometry(1, 10, 8), new THREE.MeshBasicMaterial(), waypoints.length);
  balls.name = "waypoints";
  line.add(balls);
  balls.onBeforeRender = () => balls.material.color.copy(material.color);
  const mark = (size) => {
    const scale = new THREE.Vector3().setScalar(size);
    waypoints.forEach((point, i) => balls.setMatrixAt(i, new THREE.Matrix4().compose(point, new THREE.Quaternion(), scale)));
    balls.instanceMatrix.needsUpdate = true;
  };
  line.userData = { kind, tip, points, waypoints, mark };
  return line;
}
