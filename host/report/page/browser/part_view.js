// SPDX-License-Identifier: GPL-3.0-or-later
// The part in 3-D. Drawn when something changes, not all the time.
import {BufferAttribute, BufferGeometry, Matrix4, Mesh, OrthographicCamera, Points, Raycaster, Scene, Vector2, Vector3, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {LineSegments2} from 'three/addons/lines/LineSegments2.js';
import {LineSegmentsGeometry} from 'three/addons/lines/LineSegmentsGeometry.js';
import {kCoverage, kVerdicts, colourAt} from './colours.js';
import {addFindings} from './findings_view.js';
import {Labels} from './labels.js';
import {faceMaterial, kByDeviation, kByFace, kPlain, pointMaterial} from './materials.js';
import {faceAnchors, faceEdges, partGeometry} from './part_geometry.js';

const kStandardView = new Vector3(1, -1.25, 0.8).normalize();
const kMostFaceLabels = 10;

export class PartView {
  constructor(stage, data, selection, scale) {
    this.stage = stage;
    this.data = data;
    [this.canvas, this.paper] = stage.querySelectorAll('canvas');
    this.renderer = new WebGLRenderer({canvas: this.canvas, antialias: true, alpha: true});
    this.scene = new Scene();
    const [low, high] = data.part.map((corner) => new Vector3(...corner));
    this.middle = low.clone().add(high).divideScalar(2);
    this.radius = Math.max(1e-6, high.distanceTo(low) / 2);
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 20 * this.radius);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.draw());
    this.labels = new Labels(stage.querySelector('.labels'));

    this.addPart();
    this.addPoints();
    this.findings = addFindings(this.scene, data, this.edges, this.anchors, this.radius);
    this.chosen = 0;
    this.mode = 'deviation';
    this.scale = scale;
    scale.listen(() => this.setMode(this.mode));
    this.wire(selection);
    this.look(this.openingView());
    this.setMode('deviation');
    new ResizeObserver(() => this.isOnPaper || this.resize()).observe(stage);
    this.resize();
  }

  addPart() {
    const {data} = this;
    this.geometry = partGeometry(data);
    this.faceMaterial = faceMaterial();
    this.part = new Mesh(this.geometry, this.faceMaterial);
    this.anchors = faceAnchors(data);
    this.edges = faceEdges(data);
    // Drawn as narrow quads: chains of short lines of one pixel break up into dashes.
    this.edgeMaterial = new LineMaterial({linewidth: 1.25, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2});
    const edges = new LineSegments2(new LineSegmentsGeometry().setPositions([...this.edges.values()].flat()), this.edgeMaterial);
    this.outline = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({linewidth: 3, depthTest: false, transparent: true}));
    this.outline.visible = false;
    this.outline.renderOrder = 2;
    this.scene.add(this.part, edges, this.outline);
    const pattern = this.geometry.getAttribute('pattern');
    const missing = new Set(data.report.missing_faces);
    for (let v = 0; v < pattern.count; ++v) {
      const id = data.mesh.faces[v];
      pattern.setX(v, missing.has(id) ? 2 : ['undecided', 'not_measured'].includes(data.faces.get(id)?.verdict) ? 1 : 0);
    }
  }

  addPoints() {
    const {points} = this.data;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(points.places, 3));
    geometry.setAttribute('deviation', new BufferAttribute(points.deviations, 1));
    geometry.setAttribute('face', new BufferAttribute(Float32Array.from(points.faces), 1));
    this.pointMaterial = pointMaterial();
    // Depth runs from 0 to 20 radii: two per cent of one towards the eye.
    this.pointMaterial.uniforms.towards.value = 0.002;
    this.points = new Points(geometry, this.pointMaterial);
    this.points.matrixAutoUpdate = false;
    this.points.frustumCulled = false;
    this.scene.add(this.points);
  }

  wire(selection) {
    let pressed = null;
    this.canvas.addEventListener('pointerdown', (event) => (pressed = [event.clientX, event.clientY]));
    this.canvas.addEventListener('pointerup', (event) => {
      // A press that moved has turned the part.
      if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4 || event.button !== 0) return;
      selection.choose(this.faceAt(event), 'picture');
    });
    this.canvas.addEventListener('pointermove', (event) => {
      if (event.buttons) return;
      const id = this.faceAt(event);
      this.canvas.style.cursor = id ? 'pointer' : '';
      this.canvas.title = id ? `Face ${id}: ${kVerdicts[this.data.faces.get(id).verdict].word.toLowerCase()}` : '';
    });
    this.canvas.addEventListener('keydown', (event) => {
      const turn = {ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15]}[event.key];
      const zoom = {'+': 1.2, '=': 1.2, '-': 1 / 1.2}[event.key];
      if (turn) this.turn(...turn);
      else if (zoom) this.zoom(zoom);
      else if (event.key === 'Home') this.look(kStandardView);
      else if (event.key === 'Escape') selection.choose(0, 'picture');
      else return;
      event.preventDefault();
    });
    selection.listen((id, source) => {
      this.choose(id);
      if (id && source !== 'picture') this.face(id);
    });
  }

  faceAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.camera);
    const hit = caster.intersectObject(this.part)[0];
    const id = hit ? this.data.mesh.faces[hit.face.a] : 0;
    return this.data.faces.has(id) ? id : 0;
  }

  choose(id) {
    this.chosen = id;
    this.stage.dataset.chosen = id;
    this.faceMaterial.uniforms.chosen.value = id;
    this.pointMaterial.uniforms.chosen.value = id;
    const edges = this.edges.get(id);
    this.outline.visible = Boolean(edges);
    if (edges) {
      this.outline.geometry.dispose();
      this.outline.geometry = new LineSegmentsGeometry().setPositions(edges);
    }
    this.setLabels();
    this.draw();
  }

  /** Turns so that the face is seen, unless it is already. */
  face(id) {
    const anchor = this.anchors.get(id);
    if (!anchor) return;
    const towards = this.camera.position.clone().sub(this.controls.target).normalize();
    if (anchor.normal.dot(towards) < 0.25 || !this.isSeen(anchor)) this.look(this.viewOf(anchor));
  }

  /** The direction to see a place from: in front of its face, nothing before it, not far from the standard view. */
  viewOf(anchor) {
    let [best, most] = [anchor.normal.clone(), -Infinity];
    const steps = [-1, 0, 1];
    for (const x of steps) {
      for (const y of steps) {
        for (const z of steps) {
          const view = anchor.normal.clone().addScaledVector(new Vector3(x, y, z), 0.6);
          if (view.lengthSq() < 0.1) continue;
          view.normalize();
          const facing = view.dot(anchor.normal);
          const score = Math.min(0.75, facing) + 0.3 * view.dot(kStandardView);
          if (facing > 0.3 && score > most && this.isSeen(anchor, view)) [best, most] = [view, score];
        }
      }
    }
    return best;
  }

  isSeen({place, normal}, from = this.camera.position.clone().sub(this.controls.target).normalize()) {
    const caster = new Raycaster(place.clone().addScaledVector(normal, 1e-3 * this.radius), from);
    return caster.intersectObject(this.part).length === 0;
  }

  /** The standard view, or the one of those like it that sees the worst face. */
  openingView() {
    const worst = this.data.report.faces.filter((face) => face.verdict === 'fail' || face.verdict === 'undecided').map((face) => this.anchors.get(face.id)).filter(Boolean);
    if (!worst.length) return kStandardView;
    let best = kStandardView;
    let most = -1;
    for (const [x, y, z] of [[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1], [1, 1, -1], [-1, 1, -1], [1, -1, -1], [-1, -1, -1]]) {
      const view = kStandardView.clone().multiply(new Vector3(x, y, z));
      const seen = worst.filter((anchor) => anchor.normal.dot(view) > 0.2 && this.isSeen(anchor, view)).length;
      if (seen > most) [best, most] = [view, seen];
    }
    return best;
  }

  look(direction) {
    // Straight along the up axis the picture could turn about itself.
    const away = direction.clone();
    if (Math.hypot(away.x, away.y) < 1e-3) away.y = -1e-3;
    this.controls.target.copy(this.middle);
    this.camera.position.copy(this.middle).addScaledVector(away.normalize(), 10 * this.radius);
    this.controls.update();
    this.fit();
    this.draw();
  }

  /** Zooms so that the box about the part fills the picture. */
  fit() {
    this.camera.zoom = 1;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    let most = 1e-3;
    for (let k = 0; k < 8; ++k) {
      const at = new Vector3(...[0, 1, 2].map((axis) => this.data.part[(k >> axis) & 1][axis])).project(this.camera);
      most = Math.max(most, Math.abs(at.x), Math.abs(at.y));
    }
    this.camera.zoom = 0.88 / most;
    this.camera.updateProjectionMatrix();
  }

  turn(across, up) {
    const at = this.camera.position.clone().sub(this.controls.target);
    at.applyAxisAngle(this.camera.up, across);
    const right = new Vector3().crossVectors(this.camera.up, at).normalize();
    const tilted = at.clone().applyAxisAngle(right, up);
    if (Math.abs(tilted.clone().normalize().z) < 0.99) at.copy(tilted);
    this.camera.position.copy(this.controls.target).add(at);
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  setMode(mode) {
    this.mode = mode;
    this.stage.dataset.mode = mode;
    const colour = this.geometry.getAttribute('colour');
    const colours = new Map();
    for (const [id, face] of this.data.faces)
      colours.set(id, (mode === 'coverage' ? colourAt(kCoverage, face.coverage) : kVerdicts[face.verdict].colour).map((x) => x / 255));
    for (let v = 0; v < colour.count; ++v) colour.setXYZ(v, ...(colours.get(this.data.mesh.faces[v]) ?? [0.7, 0.7, 0.7]));
    colour.needsUpdate = true;
    this.faceMaterial.uniforms.mode.value = {deviation: kByDeviation, points: kPlain}[mode] ?? kByFace;
    this.faceMaterial.uniforms.fullColour.value = this.pointMaterial.uniforms.fullColour.value = this.scale.fullColour;
    this.points.visible = mode === 'points';
    this.setLabels();
    this.draw();
  }

  /** Moves the points to where another pose would have them; null: the pose chosen. */
  setPose(T_other_model) {
    this.points.matrix.copy(T_other_model ?? new Matrix4());
    this.points.matrixWorldNeedsUpdate = true;
    this.draw();
  }

  setLabels() {
    const labels = [];
    for (const face of this.data.report.faces) {
      const anchor = this.anchors.get(face.id);
      const isBad = face.verdict === 'fail' || face.verdict === 'undecided';
      if (!anchor || !(face.id === this.chosen || (isBad && labels.length < kMostFaceLabels))) continue;
      labels.push({...anchor, text: `${face.id} ${kVerdicts[face.verdict].symbol}`, kind: face.verdict, isChosen: face.id === this.chosen});
    }
    this.labels.set([...labels, ...this.findings.labels]);
  }

  showFinding(kind, index) {
    const place = this.findings.placeOf(kind, index);
    if (!place) return;
    const towards = this.camera.position.clone().sub(this.controls.target).normalize();
    if (place.normal && place.normal.dot(towards) < 0.25) this.look(this.viewOf(place));
    this.labels.flash(`${kind}${index}`);
    this.draw();
  }

  setTheme() {
    const style = getComputedStyle(this.stage);
    this.edgeMaterial.color.set(style.getPropertyValue('--edge').trim());
    this.outline.material.color.set(style.getPropertyValue('--accent').trim());
    this.draw();
  }

  resize(width = this.stage.clientWidth, height = this.stage.clientHeight) {
    if (!width || !height) return;
    this.size = [width, height];
    const ratio = this.isOnPaper ? 2 : Math.min(2, window.devicePixelRatio || 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    const tall = this.radius * Math.max(1, height / width);
    Object.assign(this.camera, {left: (-tall * width) / height, right: (tall * width) / height, top: tall, bottom: -tall});
    this.camera.updateProjectionMatrix();
    for (const material of [this.faceMaterial, this.pointMaterial, this.findings.material]) material.uniforms.pixel.value = ratio;
    this.fit();
    this.draw();
  }

  /**
   * For paper a picture of its own, in a canvas that keeps what is drawn: of a WebGL canvas that has just changed its
   * size, printers get nothing. The size is that of .stage in the style for print.
   */
  print(isOn) {
    this.isOnPaper = isOn;
    this.setTheme();
    this.resize(...(isOn ? [660, 380] : []));
    this.drawNow();
    if (!isOn) return;
    this.paper.width = this.canvas.width;
    this.paper.height = this.canvas.height;
    this.paper.getContext('2d').drawImage(this.canvas, 0, 0);
  }

  draw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    this.renderer.render(this.scene, this.camera);
    this.labels.place(this.camera, this.size);
    this.drawAxes?.(this.camera);
  }
}
