// What is drawn: camera, light, robot, ghosts, objects, traces and contacts of one picture.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Labels } from "./labels.js";
import { kept } from "./kept.js";
import { boxesOf, direction, fit } from "./outlook.js";
import { Meshes, ghostOf, objectOf, place, robotOf, tips } from "./robot.js";
import { traces } from "./traces.js";

export function color(name) {
  return new THREE.Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());
}

export class Stage {
  constructor(canvas, labels) {
    this.canvas = canvas;
    this.labels = new Labels(labels);
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 500);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    canvas.addEventListener("keydown", (event) => this.turn(event));
    this.lights();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  lights() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8890a0, 1.9));
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(2, -3, 5);
    this.scene.add(sun);
  }

  /** Shows a picture in place of the one before. */
  show(picture, space, before, after, moving) {
    this.clear();
    Object.assign(this, { picture, before, after, moving, world: new THREE.Group(), highlighted: [], floor: null });
    // A refused path is the input still: there is nothing after it.
    this.isRefused = Boolean(picture.result.reason);
    this.world.name = "world";
    this.scene.add(this.world);
    const meshes = new Meshes(picture.meshes);
    this.robot = robotOf(picture, meshes);
    this.robot.name = "robot";
    this.world.add(this.robot);
    this.objects(meshes);
    this.ghosts = ["start", "goal", "before"].map((name) => this.ghost(name));
    this.tips = tips(this.robot, picture);
    this.traces = traces(this.tips, (q) => place(this.robot, picture, q), this.isRefused ? [["before", before]] : [["before", before], ["after", moving]]);
    this.traces.forEach((trace) => this.world.add(trace));
    this.kept = kept(picture, this.robot, after);
    this.kept.forEach((mark) => this.world.add(mark));
    this.contacts();
    this.settle();
    this.paint();
  }

  clear() {
    if (!this.world) return;
    this.world.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose?.();
    });
    this.scene.remove(this.world);
    this.labels.clear();
  }

  objects(meshes) {
    this.obstacles = this.picture.objects.map((object) => {
      const made = objectOf(object, meshes, new THREE.MeshStandardMaterial({ roughness: 0.85 }));
      (object.link ? this.robot.links[object.link] : this.world).add(made);
      this.labels.add(object.name, "object", made);
      return made;
    });
  }

  ghost(name) {
    const material = new THREE.MeshStandardMaterial({ transparent: true, opacity: name === "before" ? 0.4 : 0.17,
      depthWrite: false, roughness: 0.9, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 });
    const ghost = ghostOf(this.robot, this.picture, material);
    ghost.name = `ghost-${name}`;
    const track = name === "before" ? this.before : this.after;
    place(ghost, this.picture, track.at(name === "goal" ? 1 : 0));
    ghost.visible = name !== "before";
    this.world.add(ghost);
    return Object.assign(ghost, { material });
  }

  contacts() {
    const { result } = this.picture;
    const found = this.isRefused ? [result] : [...(result.holds ?? [])];
    const smallest = result.smallest_clearance;
    if (!this.isRefused && smallest && !found.some((contact) => contact.amount === smallest.amount)) found.push(smallest);
    this.contactMarks = found.map((contact) => this.contact(contact));
  }

  contact(contact) {
    const group = new THREE.Group();
    group.name = `contact ${contact.names.join(" × ")}`;
    const ends = contact.points.map((point) => new THREE.Vector3(...point));
    const material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true });
    for (const end of ends) {
      const ball = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), material);
      ball.position.copy(end);
      ball.renderOrder = 5;
      group.add(ball);
    }
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(ends), new THREE.LineBasicMaterial({ depthTest: false }));
    line.renderOrder = 5;
    group.add(line);
    group.userData.contact = contact;
    this.world.add(group);
    return group;
  }

  /** Takes the colours of the page. */
  paint() {
    if (!this.world) return;
    const [before, after, bad] = ["--before", "--after", "--bad"].map(color);
    this.ghosts.forEach((ghost) => ghost.material.color.copy(ghost.name === "ghost-before" || this.isRefused ? before : after));
    this.traces.forEach((trace) => trace.material.color.copy(trace.userData.kind === "before" ? before : after));
    this.contactMarks.forEach((group) => group.children.forEach((mark) => mark.material.color.copy(bad)));
    this.highlight(this.highlighted ?? []);
    this.grid();
  }

  /** Marks bodies and constraints, by their names, as those that are meant. */
  highlight(names) {
    this.highlighted = names;
    const [bad, object, keeps] = ["--bad", "--object", "--kept"].map(color);
    this.kept.forEach((mark) => mark.paint(names.includes(mark.name) ? bad : keeps));
    this.world.traverse((mesh) => {
      const name = mesh.userData.object ?? mesh.userData.link;
      if (!mesh.isMesh || !name || !mesh.material.emissive || this.isGhost(mesh)) return;
      mesh.userData.own ??= mesh.material.color.clone();
      const own = mesh.userData.object ? object : mesh.userData.own;
      mesh.material.color.copy(names.includes(name) ? bad : own);
      mesh.material.emissive.copy(bad).multiplyScalar(names.includes(name) ? 0.3 : 0);
    });
    this.draw();
  }

  isGhost(mesh) {
    return this.ghosts.some((ghost) => ghost.material === mesh.material);
  }

  grid() {
    if (this.floor) this.world.remove(this.floor);
    const size = Math.max(2, Math.ceil(this.size));
    const grid = new THREE.GridHelper(size, size * 4, color("--grid"), color("--grid"));
    grid.rotateX(Math.PI / 2);
    grid.position.set(Math.round(this.target.x), Math.round(this.target.y), Math.min(0, this.lowest) - 0.002);
    grid.material.transparent = true;
    grid.material.opacity = 0.55;
    this.floor = grid;
    this.world.add(grid);
  }

  /** Puts the camera where all is seen, and gives marks a size that fits. */
  settle() {
    const moving = [this.robot, ...this.ghosts.slice(0, 2)].flatMap(boxesOf);
    const way = this.traces.flatMap((trace) => trace.userData.points);
    const box = moving.reduce((all, own) => all.union(own), new THREE.Box3().setFromPoints(way));
    if (box.isEmpty()) box.setFromCenterAndSize(new THREE.Vector3(), new THREE.Vector3(1, 1, 1));
    // A floor of any size is no reason to look from afar.
    const near = box.clone().expandByScalar(box.getSize(new THREE.Vector3()).length() * 0.35);
    const around = this.obstacles.flatMap(boxesOf);
    around.filter((own) => near.containsBox(own)).forEach((own) => box.union(own));
    this.size = box.getSize(new THREE.Vector3()).length();
    this.lowest = box.min.z;
    const corners = [...moving, ...around.filter((own) => box.containsBox(own))].flatMap((own) =>
      [0, 1, 2, 3, 4, 5, 6, 7].map((i) => new THREE.Vector3(...["x", "y", "z"].map((axis, k) => own[(i >> k) & 1 ? "max" : "min"][axis]))));
    const seen = this.contactMarks.flatMap((mark) => mark.userData.contact.points.map((point) => new THREE.Vector3(...point)));
    const from = direction([...way, ...seen], around, box.getCenter(new THREE.Vector3()), this.size * 1.6);
    Object.assign(this.camera, { near: this.size / 400, far: this.size * 40 });
    this.camera.updateProjectionMatrix();
    this.target = fit(this.camera, corners.length ? [...corners, ...way] : [box.min, box.max], from);
    this.controls.target.copy(this.target);
    this.controls.update();
    const mark = this.size / 190;
    this.contactMarks.forEach((group) => group.children.forEach((part) => part.isMesh && part.scale.setScalar(mark)));
    this.traces.forEach((trace) => trace.userData.mark(mark * 0.8));
    this.kept.forEach((own) => own.size(mark * 1.2, this.size / 9));
  }

  /** Moves the robot to a position of the answer, and the ghost to the same one of the input. */
  at(position) {
    place(this.robot, this.picture, this.moving.at(position));
    this.kept.forEach((mark) => mark.follow());
    const ghost = this.ghosts.find(({ name }) => name === "ghost-before");
    if (ghost.visible) place(ghost, this.picture, this.before.at(position));
    this.draw();
  }

  /** Shows or hides a kind of things. */
  toggle(kind, on) {
    if (kind === "ends") this.ghosts.slice(0, 2).forEach((ghost) => (ghost.visible = on));
    if (kind === "before") this.ghosts[2].visible = on;
    if (kind === "traces") this.traces.forEach((trace) => (trace.visible = on));
    if (kind === "kept") this.kept.forEach((mark) => (mark.visible = on));
    if (kind === "contacts") this.contactMarks.forEach((mark) => (mark.visible = on));
    if (kind === "names") this.labels.show("object", on);
    if (kind === "through") {
      for (const { material } of this.obstacles.flatMap((group) => group.children)) {
        Object.assign(material, { transparent: on, opacity: on ? 0.3 : 1, depthWrite: !on, needsUpdate: true });
      }
    }
    if (kind === "collision") {
      this.robot.traverse((part) => {
        if (part.isURDFCollider) part.visible = on;
        if (part.isURDFVisual) part.visible = !on;
      });
    }
    this.draw();
  }

  turn(event) {
    const step = 0.12;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const up = new THREE.Vector3(0, 0, 1);
    const side = new THREE.Vector3().crossVectors(up, offset).normalize();
    const moves = {
      ArrowLeft: () => offset.applyAxisAngle(up, -step),
      ArrowRight: () => offset.applyAxisAngle(up, step),
      ArrowUp: () => offset.angleTo(up) > 0.25 && offset.applyAxisAngle(side, -step),
      ArrowDown: () => offset.angleTo(up) < 2.9 && offset.applyAxisAngle(side, step),
      "+": () => offset.multiplyScalar(0.9),
      "-": () => offset.multiplyScalar(1.1),
    };
    if (!moves[event.key] || !this.world) return;
    event.preventDefault();
    moves[event.key]();
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.traces?.forEach((trace) => trace.material.resolution.set(width, height));
    this.draw();
  }

  /** Draws with the next frame, however often it is asked for. */
  draw() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = null;
      this.renderer.render(this.scene, this.camera);
      this.labels.place(this.camera, this.canvas.parentElement);
    });
  }
}
