// What lies under a ray. Triangles are found through a tree that is built at the first pick and refitted, not built
// again, when the surface has moved since.
import * as three from 'three';
import { MeshBVH } from 'three-mesh-bvh';
import type { Hit, Vec3 } from '../viewer';

export class Picker {
  private tree: MeshBVH | null = null;
  private moved = false;
  private readonly geometry = new three.BufferGeometry();

  /** `position`: of the drawn surface, as it moves. `loose`: vertices that are in no triangle but drawn. */
  constructor(
    private readonly position: three.BufferAttribute,
    private readonly rest: Float32Array,
    private readonly triangles: Uint32Array,
    private readonly loose: Uint32Array,
  ) {}

  get built(): boolean {
    return this.tree !== null || this.triangles.length === 0;
  }

  build(): void {
    if (this.built) return;
    // The tree sorts the triangles: it gets its own list.
    this.geometry.setAttribute('position', this.position);
    this.geometry.setIndex(new three.BufferAttribute(this.triangles.slice(), 1));
    this.tree = new MeshBVH(this.geometry, { targetLeafSize: 8 });
    this.moved = false;
  }

  /** The surface is no longer where the tree has it. */
  invalidate(): void {
    this.moved = true;
  }

  /** `radius`: of the angle (per distance) in which a loose vertex is hit. */
  pick(ray: three.Ray, radius: number): Hit | null {
    this.build();
    if (this.moved) this.tree?.refit();
    this.moved = false;
    return this.pickTriangle(ray) ?? this.pickLoose(ray, radius);
  }

  private pickTriangle(ray: three.Ray): Hit | null {
    const found = this.tree?.raycastFirst(ray, three.DoubleSide);
    if (!found?.face) return null;
    const corners: Vec3 = [found.face.a, found.face.b, found.face.c];
    const [a, b, c] = corners.map((v) => this.at(v));
    const weights = three.Triangle.getBarycoord(found.point, a, b, c, new three.Vector3());
    const w: Vec3 = weights ? [weights.x, weights.y, weights.z] : [1, 0, 0];
    const distances = [a, b, c].map((corner) => corner.distanceToSquared(found.point));
    const normal = found.face.normal.clone();
    if (normal.dot(ray.direction) > 0) normal.negate();
    return {
      vertex: corners[distances.indexOf(Math.min(...distances))],
      corners,
      weights: w,
      point: found.point.toArray(),
      rest: [0, 1, 2].map((k) => corners.reduce((sum, v, i) => sum + w[i] * this.rest[3 * v + k], 0)) as Vec3,
      normal: normal.toArray(),
    };
  }

  /** The frontmost of the vertices near the ray. */
  private pickLoose(ray: three.Ray, radius: number): Hit | null {
    const { array } = this.position;
    const { origin: o, direction: d } = ray;
    let best = -1;
    let nearest = Infinity;
    for (let i = 0; i < this.loose.length; ++i) {
      const v = 3 * this.loose[i];
      const x = array[v] - o.x;
      const y = array[v + 1] - o.y;
      const z = array[v + 2] - o.z;
      const along = x * d.x + y * d.y + z * d.z;
      if (along <= 0 || along >= nearest) continue;
      const aside = x * x + y * y + z * z - along * along;
      if (aside > (radius * along) ** 2) continue;
      // Nearer to the ray wins over a little nearer to the eye.
      const cost = along + 4 * Math.sqrt(Math.max(aside, 0));
      if (cost < nearest) {
        nearest = cost;
        best = this.loose[i];
      }
    }
    if (best < 0) return null;
    return {
      vertex: best,
      corners: [best, best, best],
      weights: [1, 0, 0],
      point: this.at(best).toArray(),
      rest: [this.rest[3 * best], this.rest[3 * best + 1], this.rest[3 * best + 2]],
      normal: d.clone().negate().toArray(),
    };
  }

  private at(v: number): three.Vector3 {
    return new three.Vector3().fromBufferAttribute(this.position, v);
  }
}
