// Arrows: a vector field at an even subset of vertices, and the force of a poke.
import * as three from 'three';
import { finiteRange, rangeWithoutOutliers } from '../colour/colour_scale';
import { evenSubset } from './geometry';
import { arrowFragment, arrowVertex } from './shaders';

const sides = 8;

/** See arrowVertex: a shaft, a disc and a cone around z. */
function arrowShape(): { position: number[]; normal: number[]; index: number[] } {
  const position: number[] = [];
  const normal: number[] = [];
  const index: number[] = [];
  const ring = (radius: number, z: number, outward: number, forward: number): number => {
    const first = position.length / 3;
    for (let i = 0; i < sides; ++i) {
      const angle = (2 * Math.PI * i) / sides;
      position.push(radius * Math.cos(angle), radius * Math.sin(angle), z);
      normal.push(outward * Math.cos(angle), outward * Math.sin(angle), forward);
    }
    return first;
  };
  const band = (low: number, high: number): void => {
    for (let i = 0; i < sides; ++i) {
      const j = (i + 1) % sides;
      index.push(low + i, low + j, high + j, low + i, high + j, high + i);
    }
  };
  band(ring(0.22, 0, 1, 0), ring(0.22, 1, 1, 0));
  band(ring(0.22, 1, 0, -1), ring(0.75, 1, 0, -1));
  band(ring(0.75, 1, 0.95, 0.3), ring(0, 2, 0.95, 0.3));
  return { position, normal, index };
}

export class Arrows {
  readonly object: three.Mesh;
  private readonly geometry = new three.InstancedBufferGeometry();
  readonly uniforms = {
    stretch: { value: 1 },
    thickness: { value: 1 },
    ink: { value: new three.Color() },
  };

  constructor() {
    const shape = arrowShape();
    this.geometry.setAttribute('position', new three.Float32BufferAttribute(shape.position, 3));
    this.geometry.setAttribute('normal', new three.Float32BufferAttribute(shape.normal, 3));
    this.geometry.setIndex(shape.index);
    this.object = new three.Mesh(
      this.geometry,
      new three.ShaderMaterial({
        vertexShader: arrowVertex,
        fragmentShader: arrowFragment,
        uniforms: this.uniforms,
        side: three.DoubleSide,
      }),
    );
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  /** 3 numbers an arrow each. */
  place(at: Float32Array, span: Float32Array): void {
    this.geometry.setAttribute('at', new three.InstancedBufferAttribute(at, 3));
    this.geometry.setAttribute('span', new three.InstancedBufferAttribute(span, 3));
    this.geometry.instanceCount = at.length / 3;
    this.object.visible = at.length > 0;
  }
}

/** A vector on every vertex, some of them drawn. */
export class VectorField {
  readonly arrows = new Arrows();
  private vectors: Float32Array | null = null;
  private chosen = new Uint32Array();
  private spacing = 0;
  private longest = 0;
  private wanted = 1200;
  private length = 1;

  constructor(private readonly rest: Float32Array) {}

  /** `wanted` arrows, the longest `length` times their distance; a few that are much longer are drawn as long as that. */
  shape(wanted: number, length: number, positions: Float32Array): void {
    if (wanted !== this.wanted) this.chosen = new Uint32Array();
    this.wanted = wanted;
    this.length = length;
    this.set(this.vectors, positions);
  }

  set(vectors: Float32Array | null, positions: Float32Array): void {
    this.vectors = vectors;
    this.arrows.object.visible = vectors !== null;
    if (!vectors) return;
    if (this.chosen.length === 0) {
      const { vertices, spacing } = evenSubset(this.rest, this.wanted);
      this.chosen = new Uint32Array(vertices);
      this.spacing = spacing;
    }
    const lengths = new Float32Array(vectors.length / 3);
    for (let v = 0; v < lengths.length; ++v) {
      lengths[v] = Math.hypot(vectors[3 * v], vectors[3 * v + 1], vectors[3 * v + 2]);
    }
    this.longest = (rangeWithoutOutliers(lengths) ?? finiteRange(lengths))[1];
    this.follow(positions);
  }

  /** After the vertices have moved. */
  follow(positions: Float32Array): void {
    const { vectors, chosen } = this;
    if (!vectors) return;
    const at = new Float32Array(3 * chosen.length);
    const span = new Float32Array(3 * chosen.length);
    for (let i = 0; i < chosen.length; ++i) {
      for (let k = 0; k < 3; ++k) {
        at[3 * i + k] = positions[3 * chosen[i] + k];
        const component = vectors[3 * chosen[i] + k];
        span[3 * i + k] = Number.isFinite(component) ? component : 0;
      }
      const length = Math.hypot(span[3 * i], span[3 * i + 1], span[3 * i + 2]);
      if (length > this.longest) for (let k = 0; k < 3; ++k) span[3 * i + k] *= this.longest / length;
    }
    this.arrows.place(at, span);
    const full = 0.95 * this.length * this.spacing;
    this.arrows.uniforms.stretch.value = this.longest > 0 ? full / this.longest : 0;
    this.arrows.uniforms.thickness.value = 0.2 * full;
  }
}
