// What the panels see of the picture: src/scene/ implements it, src/panels/ uses it.
import type { Arrays, MeshMessage } from './protocol';

export type Vec3 = [number, number, number];

/** Where a ray meets the surface as it is now. */
export interface Hit {
  vertex: number; // the nearest corner
  corners: Vec3; // vertex numbers of the triangle
  weights: Vec3; // barycentric
  point: Vec3; // where it is now
  rest: Vec3; // the same point of the surface at rest
  normal: Vec3;
}

/** Takes the pointer before the camera does. */
export interface Tool {
  cursor: string;
  /** True: the tool takes this drag, and the camera stays. */
  down(hit: Hit | null, event: PointerEvent): boolean;
  /** Only during a drag that was taken. `hit` is worked out when it is asked for. */
  move(hit: () => Hit | null, event: PointerEvent): void;
  up(event: PointerEvent): void;
}

export interface Marker {
  vertex: number;
  color: string; // CSS
  label: string;
}

export interface ScalarOptions {
  /** Ends of the scale; without them those of the values, or what the user typed. */
  range?: [number, number];
  /** Scale ends grow with the frames but never shrink: for drags. */
  growing?: boolean;
}

export interface Viewer {
  readonly mesh: MeshMessage;
  /** Positions at rest, 3 a vertex. */
  readonly rest: Float32Array;

  // What the surface is coloured by; one at a time.
  showPlain(): void;
  showScalar(name: string, values: Float32Array, options?: ScalarOptions): void;
  showColors(name: string, rgb: Float32Array): void;

  // Where the vertices are. Normals follow unless they are given.
  atRest(): void;
  setPositions(positions: Float32Array): void;
  /** Only these are displaced, all others at rest; fast where they are few. */
  displace(vertices: Uint32Array, displacement: Float32Array): void;
  /** For shading only; null: those of the positions. */
  setNormals(normals: Float32Array | null): void;

  showVectors(name: string, vectors: Float32Array | null): void;
  /** Level of each: 2 solved for, 1 in the ring around. null: no domain is shown. */
  showDomain(domain: { vertices: Uint32Array; levels: Uint32Array } | null): void;
  setMarkers(markers: Marker[]): void;
  /** An arrow of length `vector` at a place; null: none. */
  setArrow(arrow: { at: Vec3; vector: Vec3 } | null): void;

  setTool(tool: Tool | null): void;
  /** Client pixels. */
  pick(x: number, y: number): Hit | null;
  /** Calls `visit` for the corners of the triangles at a vertex, or the ends of the segments: some more than once, and
   * itself. */
  neighbours(vertex: number, visit: (other: number) => void): void;
  screenOf(vertex: number): [number, number] | null;
  /** Where the ray under a pixel meets the plane through `at` that faces the camera. */
  onPlane(at: Vec3, x: number, y: number): Vec3;
  /** Of the bounding box. */
  readonly diagonal: number;
  /** The value that is shown at a vertex (3 numbers for colours), or null. */
  valueAt(vertex: number): number[] | null;
}

/** Of a simulation. In a report `step` counts the moments that it holds. */
export interface Moment {
  step: number;
  time: number;
  values: Float32Array;
}

/** Moments under a scrubber: the newest is shown unless the user holds another. */
export interface Timeline {
  reset(name: string): void;
  /** Of those before only the steps stay that are multiples of `every`. */
  add(moment: Moment, every: number): void;
  readonly shown: Moment | null;
  readonly count: number;
  hide(): void;
}

/** A chart that grows. */
export interface LivePlot {
  readonly element: HTMLElement;
  add(x: number, y: number[]): void;
  clear(): void;
}

export interface Shell {
  readonly viewer: Viewer;
  readonly timeline: Timeline;
  livePlot(options: { title: string; across: string; lines: string[]; height?: number }): LivePlot;
  /** A line at the bottom; an error stays until the next. */
  say(text: string, error?: boolean): void;
}

/** Makes the scene of a mesh message. */
export type MakeViewer = (mesh: MeshMessage, arrays: Arrays) => Viewer;
