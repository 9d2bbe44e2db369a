// Where the vertices are and how they are shaded. Moves are noted at once and worked out when a frame is drawn, however
// many have come since the last.
import * as three from 'three';
import { type Adjacency, adjacencyOf, boxOf, computeNormals, computeNormalsOf } from './geometry';
import { IndexSet } from './index_set';
import { StreamedAttribute } from './stream';

export class Surface {
  readonly position: StreamedAttribute;
  readonly normal: StreamedAttribute;
  readonly centre = new three.Vector3();
  radius = 0;
  readonly diagonal: number;

  private adjacency: Adjacency | null = null; // made when it is first needed
  private given: Float32Array | null = null; // normals
  private rough: Uint32Array | null = null; // the triangles that the normals are of, where not of all
  /** What has moved since the last frame. */
  private moved: 'nothing' | 'some' | 'all' = 'all';
  private readonly touched: IndexSet;
  private triangleSet: IndexSet | null = null; // empty between its uses
  /** Those away from rest, where not all may be. */
  private away: Uint32Array | 'all' = new Uint32Array();

  /** `creased`: vertices without a normal of their own, where more than two triangles meet at an edge. */
  constructor(
    readonly rest: Float32Array,
    readonly triangles: Uint32Array,
    private readonly creased: Uint32Array,
  ) {
    this.touched = new IndexSet(rest.length / 3);
    this.position = new StreamedAttribute(rest.slice(), 3);
    this.normal = new StreamedAttribute(new Float32Array(rest.length), 3);
    this.bound();
    this.diagonal = 2 * this.radius;
  }

  get vertices(): number {
    return this.rest.length / 3;
  }
  /** The triangles at each vertex. */
  get around(): Adjacency {
    return (this.adjacency ??= adjacencyOf(this.triangles, 3, this.vertices));
  }
  get now(): Float32Array {
    return this.position.numbers;
  }

  atRest(): void {
    if (this.away === 'all') {
      this.now.set(this.rest);
      this.moved = 'all';
    } else {
      this.putBack();
    }
    this.away = new Uint32Array();
  }

  setPositions(positions: Float32Array): void {
    this.now.set(positions);
    this.moved = 'all';
    this.away = 'all';
  }

  displace(vertices: Uint32Array, displacement: Float32Array): void {
    this.atRest();
    const { now, rest } = this;
    for (let i = 0; i < vertices.length; ++i) {
      const v = vertices[i];
      for (let k = 0; k < 3; ++k) now[3 * v + k] = rest[3 * v + k] + displacement[3 * i + k];
    }
    this.touch(vertices);
    this.away = vertices.slice();
  }

  setNormals(normals: Float32Array | null): void {
    if (this.given === normals) return;
    this.given = normals;
    this.moved = 'all';
  }

  private putBack(): void {
    const { now, rest, away } = this;
    if (away === 'all') return;
    for (const v of away) {
      for (let k = 0; k < 3; ++k) now[3 * v + k] = rest[3 * v + k];
    }
    this.touch(away);
  }

  private touch(vertices: Uint32Array): void {
    if (this.moved === 'all' || vertices.length === 0) return;
    for (const v of vertices) this.touched.add(v);
    this.moved = this.touched.size > this.vertices / 4 ? 'all' : 'some';
  }

  /** Works out what has moved; false: nothing has. `fewer`: triangles that do for the normals this time. */
  settle(fewer: Uint32Array | null): boolean {
    if (this.moved === 'nothing') {
      if (this.rough && this.rough !== fewer) this.shade(fewer ?? this.triangles);
      return false;
    }
    if (this.moved === 'all' || this.rough) this.settleAll(fewer);
    else this.settleSome();
    this.touched.clear();
    this.moved = 'nothing';
    return true;
  }

  private settleAll(fewer: Uint32Array | null): void {
    this.shade(fewer ?? this.triangles);
    this.position.changed();
    this.bound();
  }

  private shade(triangles: Uint32Array): void {
    const { given } = this;
    if (given) this.normal.numbers.set(given);
    else computeNormals(this.now, triangles, this.normal.numbers);
    this.crease();
    this.rough = given || triangles === this.triangles ? null : triangles;
    this.normal.changed();
  }

  private crease(): void {
    if (!this.given) for (const v of this.creased) this.normal.numbers.fill(0, 3 * v, 3 * v + 3);
  }

  /** Vertices away from rest, where they are few. */
  get someAway(): Uint32Array | null {
    return this.away === 'all' || this.away.length > this.vertices / 8 ? null : this.away;
  }

  /** Writes the triangles that have one of the vertices from `at` on, each once, as many as there is room for; where they
   * end. */
  trianglesAround(vertices: Uint32Array, into: Uint32Array, at: number): number {
    if (vertices.length === 0) return at;
    const { start, list } = this.around;
    const found = (this.triangleSet ??= new IndexSet(this.triangles.length / 3));
    for (const v of vertices) for (let j = start[v]; j < start[v + 1]; ++j) found.add(list[j]);
    for (const i of found.values) {
      if (at + 3 > into.length) break;
      for (let k = 0; k < 3; ++k) into[at++] = this.triangles[3 * i + k];
    }
    found.clear();
    return at;
  }

  private settleSome(): void {
    const moved = this.touched.sorted;
    this.position.changedAt(moved);
    this.stretch(moved);
    if (this.given) return;
    const { start, list } = this.around;
    for (const v of moved) {
      for (let j = start[v]; j < start[v + 1]; ++j) {
        for (let k = 0; k < 3; ++k) this.touched.add(this.triangles[3 * list[j] + k]);
      }
    }
    const around = this.touched.sorted;
    computeNormalsOf(around, around.length, this.now, this.triangles, this.around, this.normal.numbers);
    this.crease();
    this.normal.changedAt(around);
  }

  private bound(): void {
    const { low, high } = boxOf(this.now);
    this.centre.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    this.radius = 0.5 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  }

  /** The bounding sphere takes in what has moved out of it. */
  private stretch(moved: Uint32Array): void {
    const { now, centre } = this;
    let square = this.radius ** 2;
    for (const v of moved) {
      const x = now[3 * v] - centre.x;
      const y = now[3 * v + 1] - centre.y;
      const z = now[3 * v + 2] - centre.z;
      square = Math.max(square, x * x + y * y + z * z);
    }
    this.radius = Math.sqrt(square);
  }
}
