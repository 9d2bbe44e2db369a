// The picture: the mesh with what it is coloured by, what lies on it, and what the user points at.
import * as three from 'three';
import { type MapName, noValueColour } from '../colour/colour_map';
import { ColourScale, finiteRange } from '../colour/colour_scale';
import { roundStep } from '../colour/ticks';
import type { Palette } from '../look/theme';
import type { Arrays, MeshMessage } from '../protocol';
import type { Hit, Marker, ScalarOptions, Tool, Vec3, Viewer } from '../viewer';
import { Arrows, VectorField } from './arrows';
import type { Axis } from './camera';
import { Draft } from './draft';
import { FieldLook } from './field_material';
import { type Adjacency, adjacencyOf, edgesOf, outwardSide } from './geometry';
import { Markers } from './markers';
import { Picker } from './picker';
import { Pointer } from './pointer';
import { pointFragment, pointVertex, surfaceFragment, surfaceVertex, wireFragment, wireVertex } from './shaders';
import { Stage } from './stage';
import { StreamedAttribute } from './stream';
import { Surface } from './surface';
import { ThickLines } from './thick_lines';

/** How the user wants the picture, whatever it shows. */
export interface Display {
  map: MapName | 'automatic';
  /** Typed for the field of this name; others, and all with null, are shown as their values are. */
  range: { of: string; ends: [number, number] } | null;
  isolines: boolean;
  isolineCount: number;
  wireframe: boolean;
  boundary: boolean;
  nonManifold: boolean;
  facets: boolean;
  vectors: boolean;
  vectorCount: number;
  vectorLength: number;
}

export const plainDisplay: Display = {
  map: 'automatic',
  range: null,
  isolines: false,
  isolineCount: 12,
  wireframe: false,
  boundary: false,
  nonManifold: false,
  facets: false,
  vectors: true,
  vectorCount: 1200,
  vectorLength: 1,
};

export type Shown =
  | { kind: 'plain' }
  | { kind: 'scalar'; name: string; values: Float32Array; low: number; high: number }
  | { kind: 'colors'; name: string; values: Float32Array };

/** The Hit and where the pointer is; null: over nothing. */
export type HoverListener = (hit: Hit | null, x: number, y: number) => void;

const markerPixels = 15; // across

const arrayOf = (arrays: Arrays, name: string): Uint32Array => {
  const found = arrays[name];
  return found instanceof Uint32Array ? found : new Uint32Array();
};

export class SceneViewer implements Viewer {
  readonly rest: Float32Array;
  readonly diagonal: number;
  readonly boundary: Uint32Array;
  readonly nonManifold: Uint32Array;
  /** Number of each vertex in the file, where the mesh was decimated. */
  readonly vertexOf: Uint32Array | null;
  readonly markers = new Markers();

  private readonly surface: Surface;
  private readonly picker: Picker;
  private readonly pointer: Pointer;
  private readonly look = new FieldLook();
  private readonly vectors: VectorField;
  private readonly force = new Arrows();
  private readonly segments: ThickLines | null = null;
  private readonly ends: Uint32Array; // of the segments
  private segmentsAround: Adjacency | null = null;
  private readonly geometry = new three.BufferGeometry();
  private readonly value: StreamedAttribute;
  private readonly level: StreamedAttribute;
  private rgb: StreamedAttribute | null = null;

  /** Triangles that do for the normals of a draft. */
  private roughly: Uint32Array | null = null;
  private wire: three.LineSegments | null = null;
  private boundaryLines: ThickLines | null = null;
  private nonManifoldLines: ThickLines | null = null;
  private readonly boundaryColour = { value: new three.Color() };
  private readonly nonManifoldColour = { value: new three.Color() };
  private readonly wireUniforms = {
    resolution: this.look.uniforms.resolution,
    edge: { value: 0 },
    ink: { value: new three.Vector4() },
  };

  private field: Shown = { kind: 'plain' };
  private fieldScale = new ColourScale(0, 1);
  private fieldMoved = false;
  private vectorName = '';
  private domain: { vertices: Uint32Array; levels: Uint32Array } | null = null;
  private shownDisplay: Display = { ...plainDisplay };
  private readonly listeners: (() => void)[] = [];
  private readonly hovers: HoverListener[] = [];

  constructor(
    readonly stage: Stage,
    readonly mesh: MeshMessage,
    arrays: Arrays,
  ) {
    this.rest = arrays.positions as Float32Array;
    const triangles = arrayOf(arrays, 'triangles');
    const segments = arrayOf(arrays, 'segments');
    this.ends = segments;
    const points = arrayOf(arrays, 'points');
    this.boundary = arrayOf(arrays, 'boundary');
    this.nonManifold = arrayOf(arrays, 'non_manifold');
    this.vertexOf = arrays.vertex_of instanceof Uint32Array ? arrays.vertex_of : null;

    this.surface = new Surface(this.rest, triangles, this.nonManifold);
    this.diagonal = this.surface.diagonal;
    const scale = this.diagonal > 0 ? 2 / this.diagonal : 1;
    stage.place(this.surface.centre, scale);
    stage.setBounds(this.surface.centre, this.surface.radius);

    const vertices = this.rest.length / 3;
    this.value = new StreamedAttribute(new Float32Array(vertices), 1);
    this.level = new StreamedAttribute(new Float32Array(vertices), 1);
    this.geometry.setAttribute('position', this.surface.position);
    this.geometry.setAttribute('normal', this.surface.normal);
    this.geometry.setAttribute('value', this.value);
    this.geometry.setAttribute('level', this.level);
    this.look.set('GLOSS', !stage.software);

    if (triangles.length > 0) {
      const material = this.look.material(surfaceVertex, surfaceFragment);
      material.polygonOffset = true; // lines lie on it
      material.polygonOffsetFactor = 1;
      material.polygonOffsetUnits = 1;
      const drawn = new three.Mesh(this.indexed(triangles), material);
      this.add(drawn);
      if (stage.software && this.rest.length / 3 > 1.5 * stage.draftSize.vertices) this.draftSurface(drawn);
      // The inside of a closed surface is not seen. A graphics card does not mind drawing it, a processor does.
      if (stage.software && this.boundary.length + this.nonManifold.length === 0 && !mesh.decimated) {
        const outward = outwardSide(this.rest, triangles);
        const outside = outward === 1 ? three.FrontSide : outward === -1 ? three.BackSide : three.DoubleSide;
        stage.beforeRender(() => (material.side = stage.isInside ? three.DoubleSide : outside));
      }
    }
    if (segments.length > 0) {
      this.segments = new ThickLines(segments, this.look, { width: 3, nearer: 0 });
      this.segments.moveTo(this.rest);
      this.add(this.segments.object);
    }
    if (points.length > 0) {
      const size = { value: scale * this.pointSize(points.length) };
      this.add(
        new three.Points(this.indexed(points), this.look.material(pointVertex, pointFragment, { pointSize: size })),
      );
    }
    this.vectors = new VectorField(this.rest);
    this.add(this.vectors.arrows.object);
    this.add(this.markers.object);
    // The force is seen from all sides: it is drawn last, on a depth of its own.
    this.force.uniforms.thickness.value = 0.016 * this.diagonal;
    this.force.object.renderOrder = 10;
    this.force.object.onBeforeRender = (renderer) => renderer.clearDepth();
    this.add(this.force.object);
    this.wireUniforms.edge.value = scale * mesh.mean_edge;

    const loose = new Uint32Array(points.length + segments.length);
    loose.set(points);
    loose.set(segments, points.length);
    this.picker = new Picker(this.surface.position, this.rest, triangles, loose);
    this.pointer = new Pointer({
      canvas: stage.canvas,
      pick: (x, y) => this.pick(x, y),
      leaveCamera: (free) => (stage.free = free),
      hover: (hit, x, y) => {
        for (const listener of this.hovers) listener(hit, x, y);
      },
    });
    stage.beforeRender(() => this.settle());
    this.setField({ kind: 'plain' });
  }

  /** While something moves a processor draws fewer triangles, for which there must be nothing that shows each of them. */
  private draftSurface(drawn: three.Mesh): void {
    const full = drawn.geometry;
    const made = new Map<number, Draft>();
    this.stage.leavingOut = true;
    this.stage.beforeRender(() => {
      const drafts = this.stage.draft && !this.display.wireframe && !this.display.facets;
      const draft = drafts ? this.draftOf(this.stage.draftSize.vertices, made) : null;
      draft?.follow();
      drawn.geometry = draft?.geometry ?? full;
      // Of a large mesh the normals take as long as the picture.
      const large = this.surface.vertices > 5 * this.stage.draftSize.vertices && this.surface.someAway === null;
      this.roughly = draft && large ? draft.triangles : null;
    });
  }

  private draftOf(vertices: number, made: Map<number, Draft>): Draft {
    const known = made.get(vertices);
    if (known) return known;
    const draft = new Draft(this.surface, vertices, (index) => this.indexed(index));
    made.set(vertices, draft);
    return draft;
  }

  private add(object: three.Object3D): void {
    object.frustumCulled = false;
    this.stage.world.add(object);
  }

  /** The vertices' attributes with a list of those that are drawn. */
  private indexed(index: Uint32Array): three.BufferGeometry {
    const geometry = new three.BufferGeometry();
    for (const [name, attribute] of Object.entries(this.geometry.attributes)) geometry.setAttribute(name, attribute);
    if (this.rgb) geometry.setAttribute('rgb', this.rgb);
    geometry.setIndex(new three.BufferAttribute(index, 1));
    this.indexedGeometries.push(geometry);
    return geometry;
  }
  private readonly indexedGeometries: three.BufferGeometry[] = [];

  /** Points that nearly touch. */
  private pointSize(count: number): number {
    return this.mesh.mean_edge > 0 ? 1.1 * this.mesh.mean_edge : (1.2 * this.diagonal) / Math.sqrt(count);
  }

  // What the surface is coloured by.

  /** So that the first field need not wait. */
  rehearseField(): void {
    if (this.field.kind !== 'plain') return;
    this.stage.rehearse(
      () => this.showScalar('', new Float32Array(this.rest.length / 3)),
      () => this.showPlain(),
    );
  }

  showPlain(): void {
    this.setField({ kind: 'plain' });
  }

  showScalar(name: string, values: Float32Array, options: ScalarOptions = {}): void {
    let [low, high] = options.range ?? finiteRange(values);
    if (options.growing && this.field.kind === 'scalar' && this.field.name === name) {
      low = Math.min(low, this.field.low);
      high = Math.max(high, this.field.high);
    }
    this.setField({ kind: 'scalar', name, values, low, high });
  }

  showColors(name: string, rgb: Float32Array): void {
    this.setField({ kind: 'colors', name, values: rgb });
  }

  private setField(field: Shown): void {
    this.field = field;
    this.fieldMoved = true;
    if (field.kind === 'scalar') {
      const [low, high] = this.typedRange ?? [field.low, field.high];
      this.fieldScale = new ColourScale(low, high, this.display.map);
      this.look.setScale(this.fieldScale);
    }
    this.look.set('SCALAR', field.kind === 'scalar');
    this.look.set('COLOURS', field.kind === 'colors');
    const lines = field.kind === 'scalar' && this.display.isolines && this.isolineStep > 0;
    this.look.setIsolines(lines ? this.fieldScale : null, this.isolineStep);
    this.tell();
  }

  /** What the user typed for the field that is shown; it goes before what a task wants. */
  get typedRange(): [number, number] | null {
    const { range } = this.display;
    return this.field.kind === 'scalar' && range?.of === this.field.name ? range.ends : null;
  }

  get shown(): Shown {
    return this.field;
  }
  get scale(): ColourScale | null {
    return this.field.kind === 'scalar' ? this.fieldScale : null;
  }
  /** Round, so that lines are at round numbers. */
  get isolineStep(): number {
    const { low, high } = this.fieldScale;
    return high > low ? roundStep((high - low) / Math.max(this.display.isolineCount, 1)) : 0;
  }

  valueAt(vertex: number): number[] | null {
    if (this.field.kind === 'plain') return null;
    const columns = this.field.kind === 'scalar' ? 1 : 3;
    return [...this.field.values.subarray(columns * vertex, columns * (vertex + 1))];
  }

  // Where the vertices are.

  atRest(): void {
    this.surface.atRest();
    this.moved();
  }
  setPositions(positions: Float32Array): void {
    this.surface.setPositions(positions);
    this.moved();
  }
  displace(vertices: Uint32Array, displacement: Float32Array): void {
    this.surface.displace(vertices, displacement);
    this.moved();
  }
  setNormals(normals: Float32Array | null): void {
    this.surface.setNormals(normals);
    this.stage.invalidate();
  }
  private moved(): void {
    this.picker.invalidate();
    this.stage.invalidate();
  }
  positionOf(vertex: number): Vec3 {
    return [...this.surface.now.subarray(3 * vertex, 3 * vertex + 3)] as Vec3;
  }
  get positions(): Float32Array {
    return this.surface.now;
  }

  // What lies on it.

  showVectors(name: string, vectors: Float32Array | null): void {
    this.vectorName = vectors ? name : '';
    this.vectors.set(vectors, this.surface.now);
    this.applyVectors();
    this.tell();
  }
  get vectorsShown(): string {
    return this.vectorName;
  }
  private applyVectors(): void {
    this.vectors.arrows.object.visible = this.vectorName !== '' && this.display.vectors;
  }

  showDomain(domain: { vertices: Uint32Array; levels: Uint32Array } | null): void {
    if (!domain && !this.domain) return;
    const levels = this.level.numbers;
    const before = this.domain;
    for (const v of before?.vertices ?? []) levels[v] = 0;
    if (before) this.level.changedAt(before.vertices.slice().sort());
    this.domain = domain && { vertices: domain.vertices.slice(), levels: domain.levels };
    if (domain) {
      for (let i = 0; i < domain.vertices.length; ++i) levels[domain.vertices[i]] = domain.levels[i];
      this.level.changedAt(domain.vertices.slice().sort());
    }
    this.segments?.setLevels(levels);
    this.look.set('DOMAIN', domain !== null);
    if ((before === null) !== (domain === null)) this.tell();
    else this.stage.invalidate();
  }
  /** Vertices that are solved for, and those of the ring. */
  get domainSize(): { inside: number; ring: number } {
    let inside = 0;
    for (const level of this.domain?.levels ?? []) inside += level === 2 ? 1 : 0;
    return { inside, ring: (this.domain?.vertices.length ?? 0) - inside };
  }

  setMarkers(markers: Marker[]): void {
    this.markers.set(markers, this.surface.now);
    this.stage.invalidate();
  }

  setArrow(arrow: { at: Vec3; vector: Vec3 } | null): void {
    this.force.place(new Float32Array(arrow?.at ?? []), new Float32Array(arrow?.vector ?? []));
    this.stage.invalidate();
  }

  // How the user wants it.

  get display(): Display {
    return this.shownDisplay;
  }
  set display(display: Display) {
    const before = this.shownDisplay;
    this.shownDisplay = display;
    this.look.set('FACETS', display.facets);
    if (display.wireframe && !this.wire) this.makeWire();
    if (this.wire) this.wire.visible = display.wireframe;
    if (display.boundary && !this.boundaryLines) {
      this.boundaryLines = this.overlay(this.boundary, 3, this.boundaryColour);
    }
    if (this.boundaryLines) this.boundaryLines.object.visible = display.boundary;
    if (display.nonManifold && !this.nonManifoldLines) {
      this.nonManifoldLines = this.overlay(this.nonManifold, 4, this.nonManifoldColour);
    }
    if (this.nonManifoldLines) this.nonManifoldLines.object.visible = display.nonManifold;
    if (display.vectorCount !== before.vectorCount || display.vectorLength !== before.vectorLength) {
      this.vectors.shape(display.vectorCount, display.vectorLength, this.surface.now);
    }
    this.applyVectors();
    this.setField(this.field);
  }

  private makeWire(): void {
    const triangles = this.surface.triangles;
    const geometry = new three.BufferGeometry();
    geometry.setAttribute('position', this.surface.position);
    geometry.setIndex(new three.BufferAttribute(edgesOf(triangles, this.surface.vertices), 1));
    this.wire = new three.LineSegments(
      geometry,
      new three.ShaderMaterial({
        vertexShader: wireVertex,
        fragmentShader: wireFragment,
        uniforms: this.wireUniforms,
        transparent: true,
        depthWrite: false,
      }),
    );
    this.wire.renderOrder = 1;
    this.add(this.wire);
  }

  /** Edges in one colour over the surface. They wear a look of their own: they have no field. */
  private overlay(edges: Uint32Array, width: number, colour: three.IUniform): ThickLines {
    const plain = new FieldLook();
    const lines = new ThickLines(edges, plain, {
      width,
      nearer: 0.0012,
      uniforms: { plain: colour, resolution: this.look.uniforms.resolution, pixels: this.look.uniforms.pixels },
    });
    lines.object.renderOrder = 2;
    lines.moveTo(this.surface.now);
    this.add(lines.object);
    return lines;
  }

  wear(palette: Palette): void {
    this.look.wear(palette);
    this.wireUniforms.ink.value.set(...palette.wire);
    this.boundaryColour.value.set(palette.boundary);
    this.nonManifoldColour.value.set(palette.nonManifold);
    this.vectors.arrows.uniforms.ink.value.set(palette.arrows);
    this.force.uniforms.ink.value.set(palette.force);
    this.markers.uniforms.halo.value.set(palette.halo);
    this.stage.setBackground(palette.background);
  }

  /** From a view (frameOf), or from where the camera is. */
  fit(view?: string, up?: Axis, aspect?: number): void {
    this.stage.fit(this.surface.now, view, up, aspect);
  }

  // What the user points at.

  setTool(tool: Tool | null): void {
    this.pointer.setTool(tool);
  }
  pick(x: number, y: number): Hit | null {
    return this.picker.pick(this.stage.ray(x, y), 7 * this.stage.pixelAngle);
  }
  /** The first pick needs a tree, which large meshes take a while to build: better before the user waits for it. */
  preparePicking(): void {
    this.picker.build();
  }
  neighbours(vertex: number, visit: (other: number) => void): void {
    const corners = this.surface.triangles.length > 0 ? 3 : 2;
    const cells = corners === 3 ? this.surface.triangles : this.ends;
    const { start, list } =
      corners === 3 ? this.surface.around : (this.segmentsAround ??= adjacencyOf(cells, 2, this.surface.vertices));
    for (let j = start[vertex]; j < start[vertex + 1]; ++j)
      for (let k = 0; k < corners; ++k) visit(cells[corners * list[j] + k]);
  }
  screenOf(vertex: number): [number, number] | null {
    return this.stage.project(new three.Vector3(...this.positionOf(vertex)));
  }
  /** The same in pixels of the canvas. */
  canvasOf(vertex: number): [number, number] | null {
    return this.stage.onCanvas(new three.Vector3(...this.positionOf(vertex)));
  }
  onPlane(at: Vec3, x: number, y: number): Vec3 {
    const plane = new three.Plane().setFromNormalAndCoplanarPoint(this.stage.direction, new three.Vector3(...at));
    const met = this.stage.ray(x, y).intersectPlane(plane, new three.Vector3());
    return met ? met.toArray() : at;
  }
  onHover(listener: HoverListener): void {
    this.hovers.push(listener);
  }

  /** After what is shown, or how, has changed. */
  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }
  private tell(): void {
    this.stage.invalidate();
    for (const listener of this.listeners) listener();
  }

  /** Before a frame: everything that has changed since the last goes to the graphics card. */
  private settle(): void {
    const size = this.stage.drawingSize;
    const ratio = this.stage.drawnRatio;
    this.look.uniforms.resolution.value.copy(size);
    this.look.uniforms.pixels.value = ratio;
    this.look.uniforms.skyward.value
      .copy(this.stage.camera.up)
      .transformDirection(this.stage.camera.matrixWorldInverse);
    this.markers.uniforms.size.value = markerPixels * ratio;
    this.markers.uniforms.depth.value = 1.2 * markerPixels * this.stage.pixelAngle;
    if (this.surface.settle(this.stage.draft ? this.roughly : null)) {
      const { now, centre, radius } = this.surface;
      this.stage.setBounds(centre, radius);
      this.segments?.moveTo(now);
      this.boundaryLines?.moveTo(now);
      this.nonManifoldLines?.moveTo(now);
      this.markers.follow(now);
      if (this.vectorName) this.vectors.follow(now);
    }
    if (this.fieldMoved) this.settleField();
  }

  private settleField(): void {
    this.fieldMoved = false;
    if (this.field.kind === 'scalar') {
      this.fieldScale.positions(this.field.values, this.value.numbers);
      this.value.changed();
      this.segments?.setValues(this.value.numbers);
    } else if (this.field.kind === 'colors') {
      if (!this.rgb) {
        this.rgb = new StreamedAttribute(new Float32Array(this.rest.length), 3);
        for (const geometry of this.indexedGeometries) geometry.setAttribute('rgb', this.rgb);
      }
      const out = this.rgb.numbers;
      const values = this.field.values;
      const grey = noValueColour[0];
      for (let i = 0; i < out.length; ++i) out[i] = values[i] >= 0 ? Math.min(values[i], 1) : values[i] < 0 ? 0 : grey;
      this.rgb.changed();
      this.segments?.setColours(out);
    }
  }
}
