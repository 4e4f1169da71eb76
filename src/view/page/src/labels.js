// Names that stand beside things, as text of the page.

import * as THREE from "three";

export class Labels {
  constructor(element) {
    this.element = element;
    this.labels = [];
  }

  add(text, kind, at) {
    const span = document.createElement("span");
    span.className = kind;
    span.textContent = text;
    this.element.append(span);
    this.labels.push({ span, kind, at });
    return span;
  }

  /** One label of a kind that has no other, at a point; none without a text. */
  only(kind, text, point) {
    this.labels = this.labels.filter((label) => label.kind !== kind || label.span.remove());
    if (text) this.add(text, kind, { point: new THREE.Vector3(...point) });
  }

  show(kind, on) {
    this.hidden = { ...this.hidden, [kind]: !on };
  }

  clear() {
    this.labels = [];
    this.element.replaceChildren();
  }

  place(camera, { clientWidth, clientHeight }) {
    for (const { span, kind, at } of this.labels) {
      const point = at.point ? at.point.clone() : middle(at);
      point.project(camera);
      const seen = !this.hidden?.[kind] && Math.abs(point.x) < 1 && Math.abs(point.y) < 1 && point.z < 1;
      span.style.display = seen ? "" : "none";
      span.style.left = `${((point.x + 1) / 2) * clientWidth}px`;
      span.style.top = `${((1 - point.y) / 2) * clientHeight}px`;
    }
  }
}

function middle(object) {
  const mesh = object.children[0];
  if (!mesh) return object.getWorldPosition(new THREE.Vector3());
  mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
  return mesh.geometry.boundingBox.getCenter(new THREE.Vector3()).applyMatrix4(mesh.matrixWorld);
}
