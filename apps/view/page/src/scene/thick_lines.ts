// Segments some pixels wide on the mesh: boundary and non-manifold edges, and meshes of segments with their field.
import * as three from 'three';
import type { FieldLook } from './field_material';
import { thickFragment, thickVertex } from './shaders';

const quad = new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0]);

export class ThickLines {
  readonly object: three.Mesh;
  private readonly geometry = new three.InstancedBufferGeometry();
  private readonly material: three.ShaderMaterial;
  private readonly buffers = new Map<string, three.InstancedBufferAttribute>();

  /** `ends`: 2 vertex numbers a segment. */
  constructor(
    private readonly ends: Uint32Array,
    look: FieldLook,
    /** width: in pixels of the page. */
    options: { width: number; nearer: number; uniforms?: Record<string, three.IUniform> },
  ) {
    this.geometry.setAttribute('position', new three.BufferAttribute(quad, 3));
    this.geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.geometry.instanceCount = this.count;
    this.material = look.material(thickVertex, thickFragment, {
      width: { value: options.width },
      nearer: { value: options.nearer },
      ...options.uniforms,
    });
    this.material.transparent = true;
    for (const name of ['from', 'to']) this.buffer(name, 3);
    for (const name of ['values', 'levels']) this.buffer(name, 2);
    this.object = new three.Mesh(this.geometry, this.material);
    this.object.frustumCulled = false;
  }

  get count(): number {
    return this.ends.length / 2;
  }

  moveTo(positions: Float32Array): void {
    this.gather('from', positions, 3, 0);
    this.gather('to', positions, 3, 1);
  }

  setValues(values: Float32Array): void {
    this.pair('values', values);
  }
  setLevels(levels: Float32Array): void {
    this.pair('levels', levels);
  }
  setColours(rgb: Float32Array): void {
    this.buffer('rgbFrom', 3);
    this.buffer('rgbTo', 3);
    this.gather('rgbFrom', rgb, 3, 0);
    this.gather('rgbTo', rgb, 3, 1);
  }

  private pair(name: string, values: Float32Array): void {
    const buffer = this.buffer(name, 2);
    const out = buffer.array as Float32Array;
    for (let i = 0; i < out.length; ++i) out[i] = values[this.ends[i]];
    buffer.needsUpdate = true;
  }

  private gather(name: string, of: Float32Array, columns: number, end: 0 | 1): void {
    const buffer = this.buffer(name, columns);
    const out = buffer.array as Float32Array;
    for (let s = 0; s < this.count; ++s) {
      const v = columns * this.ends[2 * s + end];
      for (let k = 0; k < columns; ++k) out[columns * s + k] = of[v + k];
    }
    buffer.needsUpdate = true;
  }

  private buffer(name: string, columns: number): three.InstancedBufferAttribute {
    let buffer = this.buffers.get(name);
    if (!buffer) {
      buffer = new three.InstancedBufferAttribute(new Float32Array(columns * this.count), columns);
      this.buffers.set(name, buffer);
      this.geometry.setAttribute(name, buffer);
    }
    return buffer;
  }
}
