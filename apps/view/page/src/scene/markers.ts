// Balls on vertices, of constant size on the screen: sources, impulses, values that are held.
import * as three from 'three';
import type { Marker } from '../viewer';
import { markerFragment, markerVertex } from './shaders';

export class Markers {
  readonly object: three.Points;
  readonly uniforms = {
    size: { value: 1 },
    depth: { value: 0 },
    halo: { value: new three.Color('#fff') },
  };
  private readonly geometry = new three.BufferGeometry();
  private list: Marker[] = [];

  constructor() {
    this.object = new three.Points(
      this.geometry,
      new three.ShaderMaterial({
        vertexShader: markerVertex,
        fragmentShader: markerFragment,
        uniforms: this.uniforms,
        transparent: true,
      }),
    );
    this.object.frustumCulled = false;
    this.object.visible = false;
    this.object.renderOrder = 5;
  }

  get all(): readonly Marker[] {
    return this.list;
  }

  set(markers: Marker[], positions: Float32Array): void {
    this.list = markers;
    const colours = new Float32Array(3 * markers.length);
    const colour = new three.Color();
    markers.forEach((marker, i) => colour.set(marker.color).toArray(colours, 3 * i));
    // Buffers have a size of their own each: a change of their number makes new ones.
    this.geometry.dispose();
    this.geometry.setAttribute('position', new three.BufferAttribute(new Float32Array(3 * markers.length), 3));
    this.geometry.setAttribute('colour', new three.BufferAttribute(colours, 3));
    this.object.visible = markers.length > 0;
    this.follow(positions);
  }

  follow(positions: Float32Array): void {
    if (this.list.length === 0) return;
    const place = this.geometry.getAttribute('position') as three.BufferAttribute;
    this.list.forEach(({ vertex }, i) => {
      for (let k = 0; k < 3; ++k) (place.array as Float32Array)[3 * i + k] = positions[3 * vertex + k];
    });
    place.needsUpdate = true;
  }
}
