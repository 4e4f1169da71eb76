// What the path keeps besides clearance: where points and directions may be, where the robot stands and along its path.

import * as THREE from "three";
import { place, solidOf } from "./robot.js";

/** Places of the path at which directions are drawn. */
const ALONG = 16;

/** A fan of each edge about the origin. */
function fan(edges) {
  const triangles = edges.flatMap((edge) => edge.slice(1).flatMap((point, i) => [0, 0, 0, ...edge[i], ...point]));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(triangles, 3));
  return geometry;
}

function line(points, material) {
  return new THREE.Line(new THREE.BufferGeometry().setFromPoints(points.map((point) => new THREE.Vector3(...point))), material);
}

/** One constraint: its region, and what is watched. */
class Mark extends THREE.Group {
  constructor({ name, sight }, robot) {
    super();
    this.name = name;
    Object.assign(this, { sight, robot });
    this.fill = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.22, depthWrite: false, side: THREE.DoubleSide });
    this.ink = new THREE.LineBasicMaterial();
    this.faint = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.35 });
    this.region = new THREE.Group();
    this.watched = new THREE.Group();
    this.add(this.region, this.watched);
    if (sight.point) this.points();
    else this.directions();
  }

  points() {
    for (const solid of this.sight.solids) {
      const mesh = solidOf(solid, null, this.fill);
      mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry, 30), this.faint));
      this.region.add(mesh);
    }
    this.ball = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), new THREE.MeshBasicMaterial());
    this.ball.position.set(...this.sight.point);
    this.watched.add(this.ball);
  }

  directions() {
    this.region.add(new THREE.Mesh(fan(this.sight.edges), this.fill), ...this.sight.edges.map((edge) => line(edge, this.ink)));
    this.watched.add(line([[0, 0, 0], this.sight.direction], this.ink));
  }

  /** Where a link is; the world without one. */
  link(name) {
    return name === null ? new THREE.Matrix4() : this.robot.links[name].matrixWorld;
  }

  /** Follows the robot. */
  follow() {
    const [own, eye] = [this.link(this.sight.link), this.link(this.sight.seen_from)];
    for (const [group, frame] of [[this.region, eye], [this.watched, own]]) {
      frame.decompose(group.position, group.quaternion, new THREE.Vector3());
    }
    // A direction is nowhere: it is drawn at its link, or, of the world's, at who sees it.
    if (this.sight.direction) {
      const at = new THREE.Vector3().setFromMatrixPosition(this.sight.link === null ? eye : own);
      this.region.position.copy(at);
      this.watched.position.copy(at);
    }
    this.updateMatrixWorld(true);
  }

  /** The edges where the robot stands, to stay there. */
  trail() {
    if (!this.sight.direction) return [];
    const { position, quaternion } = this.region;
    return this.sight.edges.map((edge) => {
      const drawn = line(edge, this.faint);
      drawn.position.copy(position);
      drawn.quaternion.copy(quaternion);
      return drawn;
    });
  }

  /** Gives marks and directions a size that fits. */
  size(mark, reach) {
    this.ball?.scale.setScalar(mark);
    if (!this.sight.direction) return;
    [this.region, ...this.trails.children].forEach((drawn) => drawn.scale.setScalar(reach));
    this.watched.scale.setScalar(1.25 * reach);
  }

  paint(ink) {
    for (const material of [this.fill, this.ink, this.faint, this.ball?.material]) material?.color.copy(ink);
  }
}

/** All that a picture's path keeps and that is somewhere. */
export function kept(picture, robot, track) {
  const drawn = picture.kept.constraints.filter(({ sight }) => sight);
  const marks = drawn.map((constraint) => new Mark(constraint, robot));
  const step = Math.max(1, Math.ceil(track.rows.length / ALONG));
  const positions = track.rows.map((_, i) => track.position(Math.max(0, i - 1), i === 0 ? 0 : 1)).filter((_, i) => i % step === 0);
  for (const mark of marks) mark.add((mark.trails = new THREE.Group()));
  for (const position of marks.length ? positions : []) {
    place(robot, picture, track.at(position));
    for (const mark of marks) {
      mark.follow();
      mark.trail().forEach((drawn) => mark.trails.add(drawn));
    }
  }
  return marks;
}
