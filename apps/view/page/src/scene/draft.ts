// What a processor draws of a surface while it moves: fewer triangles, and on them all of those around vertices that are
// away from rest, or the tip of a poke would be missing.
import * as three from 'three';
import { coarser } from './geometry';
import type { Surface } from './surface';

export class Draft {
  /** Those that are drawn everywhere. */
  readonly triangles: Uint32Array;
  readonly geometry: three.BufferGeometry;
  private readonly index: Uint32Array;
  private away: Uint32Array = new Uint32Array();

  /** `make`: the surface's attributes with this list of triangles. */
  constructor(
    private readonly surface: Surface,
    vertices: number,
    make: (index: Uint32Array) => three.BufferGeometry,
  ) {
    this.triangles = coarser(surface.rest, surface.triangles, vertices);
    this.index = new Uint32Array(2 * this.triangles.length);
    this.index.set(this.triangles);
    this.geometry = make(this.index);
    this.geometry.index?.setUsage(three.DynamicDrawUsage);
    this.geometry.setDrawRange(0, this.triangles.length);
  }

  /** Before a draft is drawn. */
  follow(): void {
    const away = this.surface.someAway ?? new Uint32Array();
    if (away.length === this.away.length && away.every((v, i) => v === this.away[i])) return;
    this.away = away;
    const { index, geometry } = this;
    const first = this.triangles.length;
    const end = this.surface.trianglesAround(away, index, first);
    geometry.setDrawRange(0, end);
    geometry.index?.clearUpdateRanges();
    if (end === first || !geometry.index) return;
    geometry.index.addUpdateRange(first, end - first);
    geometry.index.needsUpdate = true;
  }
}
