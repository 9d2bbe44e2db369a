// Canvas, camera and the frames that are drawn: one when something has changed, none otherwise. Where a processor draws,
// what moves is drawn as a draft, with fewer pixels and what else `onDraft` leaves out; once it rests it is drawn in full.
import * as three from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { type Axis, fitted, frameOf, upOf } from './camera';
import { DraftPace, type DraftSize } from './draft_size';

// All colours here are what a screen shows; three shall not convert them.
three.ColorManagement.enabled = false;

const rest = 160; // ms without a change, then a draft is replaced

const fieldOfView = 28; // degrees: little perspective, as one sees a thing that is held in the hand

export interface CameraState {
  up: Axis;
  eye: [number, number, number];
  target: [number, number, number];
}

/** Canvas pixels (CSS) at the sides that lie under something else, as the legend. */
export interface Insets {
  top: number;
  right: number;
  bottom: number;
  left: number;
}

/** What draws. A context must be asked, and it must be known before the one that is drawn with is made. */
function nameOfRenderer(): string {
  const context = document.createElement('canvas').getContext('webgl2');
  if (!context) return '';
  const details = context.getExtension('WEBGL_debug_renderer_info');
  const name = String(context.getParameter(details ? details.UNMASKED_RENDERER_WEBGL : context.RENDERER));
  context.getExtension('WEBGL_lose_context')?.loseContext();
  return name;
}

export class Stage {
  readonly canvas = document.createElement('canvas');
  readonly renderer: three.WebGLRenderer;
  readonly scene = new three.Scene();
  /** What is in the mesh's coordinates. The scene has the mesh around 0 with a radius of about 1, whatever its unit. */
  readonly world = new three.Group();
  readonly camera = new three.PerspectiveCamera(fieldOfView, 1, 0.01, 100);
  readonly software: boolean;
  readonly rendererName: string;
  /** Frames that were drawn. */
  renders = 0;
  /** Milliseconds of the last one, as far as the page can tell. */
  renderTime = 0;
  insets: () => Insets = () => ({ top: 0, right: 0, bottom: 0, left: 0 });
  /** Something new is about to be shown: a picture in full would only hold it up. */
  expects: () => boolean = () => false;

  private controls: OrbitControls;
  private up: Axis = 'y';
  private pending = 0;
  private wanted = 0; // when the next picture was
  private readonly pace = new DraftPace();
  private resting: number | undefined; // a timer: the last frame was a draft
  private isDraft = false;
  private leavesOut = false;
  private viewed: [number, number] = [1, 1];
  private readonly first: (() => void)[] = [];
  private readonly before: (() => void)[] = [];
  private preparing = false;
  private readonly after: (() => void)[] = [];
  private readonly movers: (() => void)[] = [];
  /** Around all that is drawn, for near and far. */
  private readonly bounds = new three.Sphere(new three.Vector3(), 1);
  private lost = false;
  private background = '#ffffff';
  private assumed: [number, number] | null = null;

  constructor(
    private readonly host: HTMLElement,
    say: (text: string, error?: boolean) => void,
  ) {
    this.canvas.className = 'canvas';
    this.rendererName = nameOfRenderer();
    this.software = /swiftshader|llvmpipe|softpipe|software|basic render/i.test(this.rendererName);
    // Smooth edges cost a processor more than all the rest; saved pictures have them anyway.
    this.renderer = new three.WebGLRenderer({
      canvas: this.canvas,
      antialias: !this.software,
      powerPreference: 'high-performance',
    });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace;
    this.scene.add(this.world);
    host.append(this.canvas);
    this.controls = this.makeControls();
    new ResizeObserver(() => this.resize()).observe(host);
    this.canvas.addEventListener('webglcontextlost', () => {
      this.lost = true;
      say('The graphics driver has dropped the picture; it comes back by itself.');
    });
    this.canvas.addEventListener('webglcontextrestored', () => {
      this.lost = false;
      say('');
      this.setBackground(this.background); // three forgets it
    });
    this.resize();
  }

  /** Of the picture in full. */
  get pixelRatio(): number {
    return this.software ? 1 : Math.min(window.devicePixelRatio, 2);
  }
  private get draftRatio(): number {
    const [width, height] = this.viewed;
    return Math.min(this.pixelRatio, Math.sqrt(this.draftSize.pixels / (width * height)));
  }
  /** Of a draft that is drawn now. */
  get draftSize(): DraftSize {
    return this.pace.size;
  }
  get size(): [number, number] {
    return this.viewed;
  }
  get upAxis(): Axis {
    return this.up;
  }

  /** Draw soon. */
  invalidate(): void {
    if (this.preparing) return; // the frame that is about to be drawn has it
    window.clearTimeout(this.resting);
    this.resting = undefined;
    if (this.pending !== 0) return;
    this.wanted = performance.now();
    this.pending = requestAnimationFrame(() => this.frame(this.drafts));
  }
  get waiting(): boolean {
    return this.pending !== 0 || this.resting !== undefined;
  }

  private get drafts(): boolean {
    return this.software && (this.leavesOut || this.draftRatio < this.pixelRatio);
  }
  /** Whether the frame that is drawn now is a draft. */
  get draft(): boolean {
    return this.isDraft;
  }
  /** Drafts are worth while whatever their size: something is left out. */
  set leavingOut(on: boolean) {
    this.leavesOut = on;
  }
  /** Before all that follows from what is shown; it may still be changed. */
  atFirst(listener: () => void): void {
    this.first.push(listener);
  }
  beforeRender(listener: () => void): void {
    this.before.push(listener);
  }
  afterRender(listener: () => void): void {
    this.after.push(listener);
  }
  /** After the user has moved the camera. */
  onCamera(listener: () => void): void {
    this.movers.push(listener);
  }

  private frame(draft: boolean): void {
    this.pending = 0;
    if (this.lost) return;
    const start = performance.now();
    this.isDraft = draft;
    const ratio = draft ? this.draftRatio : this.pixelRatio;
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
    this.render();
    this.renderTime = performance.now() - start;
    ++this.renders;
    for (const listener of this.after) listener();
    if (!draft) return;
    const { wanted } = this;
    setTimeout(() => this.pace.drawn(performance.now() - wanted)); // after the browser has taken the picture
    if (this.pending === 0) this.refineLater();
  }

  /** What a draft has shown is drawn in full, unless something has changed again by then or is about to. */
  private refineLater(): void {
    this.resting = window.setTimeout(() => (this.expects() ? this.refineLater() : this.refine()), rest);
  }
  private refine(): void {
    this.resting = undefined;
    if (this.pending === 0) this.pending = requestAnimationFrame(() => this.frame(false));
  }

  private render(): void {
    this.preparing = true;
    try {
      for (const listener of this.first) listener();
    } finally {
      this.preparing = false;
    }
    this.draw();
  }

  /** What is shown as it is: results that wait to be shown go on waiting. */
  private draw(): void {
    this.preparing = true;
    try {
      for (const listener of this.before) listener();
    } finally {
      this.preparing = false;
    }
    this.clip();
    this.renderer.render(this.scene, this.camera);
  }

  /** Draws the picture as `change` makes it, and then as it was before the browser shows either: what is compiled when it is
   * drawn first is there when it is wanted. */
  rehearse(change: () => void, back: () => void): void {
    if (this.lost) return;
    this.isDraft = this.drafts;
    change();
    this.draw();
    back();
    this.invalidate();
  }

  /** Draws now, width x height pixels with edges smoothed `finer` times, and hands the canvas to `use`; then all is as
   * before. */
  capture(width: number, height: number, finer: number, use: (canvas: HTMLCanvasElement) => void): void {
    const { aspect } = this.camera;
    this.isDraft = false;
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width * finer, height * finer, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    try {
      this.render();
      use(this.canvas);
    } finally {
      this.camera.aspect = aspect;
      this.resize();
    }
  }

  /** Of what is drawn to. */
  get drawingSize(): three.Vector2 {
    return this.renderer.getDrawingBufferSize(new three.Vector2());
  }

  /** Drawing pixels of the frame that is drawn now for each of the page. */
  get drawnRatio(): number {
    return this.drawingSize.y / this.size[1];
  }

  resize(): void {
    this.viewed = [Math.max(this.host.clientWidth, 1), Math.max(this.host.clientHeight, 1)];
    const [width, height] = this.viewed;
    this.renderer.setPixelRatio(this.drafts ? this.draftRatio : this.pixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  setBackground(colour: string): void {
    this.background = colour;
    this.renderer.setClearColor(colour);
    this.invalidate();
  }

  /** Puts the mesh into the scene. */
  place(centre: three.Vector3, scale: number): void {
    this.world.scale.setScalar(scale);
    this.world.position.copy(centre).multiplyScalar(-scale);
    this.world.updateMatrixWorld(true);
  }
  get scale(): number {
    return this.world.scale.x;
  }
  private toScene(point: three.Vector3): three.Vector3 {
    return this.world.localToWorld(point);
  }

  /** A sphere around all that is drawn, in the mesh's coordinates. */
  setBounds(centre: three.Vector3, radius: number): void {
    this.bounds.center.copy(this.toScene(centre.clone()));
    this.bounds.radius = Math.max(radius * this.scale, 1e-3);
  }

  /** The camera is among what is drawn. */
  get isInside(): boolean {
    return this.camera.position.distanceTo(this.bounds.center) < this.bounds.radius;
  }

  private clip(): void {
    const away = this.camera.position.distanceTo(this.bounds.center);
    const radius = 1.15 * this.bounds.radius;
    this.camera.far = away + radius;
    this.camera.near = Math.max(away - radius, this.camera.far * 2e-4);
    this.camera.updateProjectionMatrix();
  }

  /** Looks from a view (see frameOf) so that all positions are seen; without a view from where it looks now. */
  fit(positions: Float32Array, view?: string, up: Axis = this.up, aspect = this.camera.aspect): void {
    if (up !== this.up) this.setUp(up);
    const frame = view ? frameOf(view, up) : this.frameNow();
    const [width, height] = this.assumed ?? this.size;
    const { top, right, bottom, left } = this.insets();
    const tangent = Math.tan((fieldOfView * Math.PI) / 360);
    const free = [Math.max(1 - (left + right) / width, 0.3), Math.max(1 - (top + bottom) / height, 0.3)];
    const across = 0.9 * tangent * aspect * free[0];
    const upward = 0.9 * tangent * free[1];
    const { eye, target } = fitted(positions, frame, [across, upward]);
    this.toScene(eye);
    this.toScene(target);
    // The middle of what is free is not the middle of the canvas.
    const distance = eye.distanceTo(target);
    const shift = new three.Vector3()
      .addScaledVector(frame.right, ((right - left) / width) * tangent * aspect * distance)
      .addScaledVector(frame.up, ((top - bottom) / height) * tangent * distance);
    eye.add(shift);
    target.add(shift);
    this.camera.up.copy(upOf(up));
    // Orbit controls cannot hold a camera exactly above its target: they would turn it.
    if (Math.abs(frame.toward.dot(this.camera.up)) > 1 - 1e-9) eye.addScaledVector(frame.up, -1e-5 * distance);
    this.camera.position.copy(eye);
    this.controls.target.copy(target);
    this.controls.update();
    this.invalidate();
  }

  /** Fits as for a canvas of another size. */
  fitFor(width: number, height: number, fit: () => void): void {
    this.assumed = [width, height];
    fit();
    this.assumed = null;
  }

  get state(): CameraState {
    return { up: this.up, eye: this.camera.position.toArray(), target: this.controls.target.toArray() };
  }
  set state({ up, eye, target }: CameraState) {
    this.setUp(up);
    this.camera.position.fromArray(eye);
    this.controls.target.fromArray(target);
    this.controls.update();
    this.invalidate();
  }

  /** The camera stays out of a drag that a tool has taken. */
  set free(free: boolean) {
    this.controls.enabled = free;
  }

  /** In the mesh's coordinates. */
  ray(x: number, y: number): three.Ray {
    const place = this.canvas.getBoundingClientRect();
    const caster = new three.Raycaster();
    this.camera.updateMatrixWorld();
    caster.setFromCamera(
      new three.Vector2((2 * (x - place.left)) / place.width - 1, 1 - (2 * (y - place.top)) / place.height),
      this.camera,
    );
    const ray = caster.ray.applyMatrix4(this.world.matrixWorld.clone().invert());
    ray.direction.normalize();
    return ray;
  }

  /** Client pixels of a point of the mesh; null behind the camera. */
  project(point: three.Vector3): [number, number] | null {
    const at = this.seen(point);
    const place = this.canvas.getBoundingClientRect();
    return at && [place.left + at[0] * place.width, place.top + at[1] * place.height];
  }
  /** The same in pixels of the canvas, for which the browser need not lay out the page. */
  onCanvas(point: three.Vector3): [number, number] | null {
    const at = this.seen(point);
    const [width, height] = this.size;
    return at && [at[0] * width, at[1] * height];
  }
  /** From the upper left corner, 0, to the lower right, 1. */
  private seen(point: three.Vector3): [number, number] | null {
    this.camera.updateMatrixWorld();
    const seen = this.toScene(point.clone()).project(this.camera);
    return seen.z > 1 ? null : [0.5 + 0.5 * seen.x, 0.5 - 0.5 * seen.y];
  }

  /** Where the camera looks, in the mesh's coordinates: the axes of the scene are the mesh's. */
  get direction(): three.Vector3 {
    return this.camera.getWorldDirection(new three.Vector3());
  }

  /** What a pixel spans at distance 1. */
  get pixelAngle(): number {
    return (2 * Math.tan((fieldOfView * Math.PI) / 360)) / this.size[1];
  }

  private frameNow(): { right: three.Vector3; up: three.Vector3; toward: three.Vector3 } {
    this.camera.updateMatrixWorld();
    const frame = { right: new three.Vector3(), up: new three.Vector3(), toward: new three.Vector3() };
    this.camera.matrixWorld.extractBasis(frame.right, frame.up, frame.toward);
    return frame;
  }

  private setUp(up: Axis): void {
    this.up = up;
    this.camera.up.copy(upOf(up));
    // Orbit controls read the axis when they are made.
    const { target } = this.controls;
    this.controls.dispose();
    this.controls = this.makeControls();
    this.controls.target.copy(target);
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.zoomToCursor = true;
    controls.rotateSpeed = 0.9;
    controls.minDistance = 1e-3;
    controls.maxDistance = 100;
    controls.addEventListener('change', () => this.invalidate());
    controls.addEventListener('end', () => {
      for (const listener of this.movers) listener();
    });
    return controls;
  }
}
