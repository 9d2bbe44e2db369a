// How a field becomes colour: uniforms that surface, segments and points share, and switches that are compiled in, since
// what a fragment does not need it shall not pay for.
import * as three from 'three';
import { ColourMap, noValueColour } from '../colour/colour_map';
import type { ColourScale } from '../colour/colour_scale';
import type { Palette } from '../look/theme';

export type Switch = 'SCALAR' | 'COLOURS' | 'ISOLINES' | 'DOMAIN' | 'FACETS' | 'GLOSS';

const nowhere = 1e9;

export class FieldLook {
  readonly uniforms = {
    map: { value: null as three.DataTexture | null },
    ends: { value: new three.Vector2(0, 1) },
    plain: { value: new three.Color() },
    noValue: { value: new three.Color(...noValueColour) },
    isolines: { value: new three.Vector3(0, 1, nowhere) },
    inside: { value: new three.Color(0x2f6fd0) },
    ring: { value: new three.Color(0xd23b3b) },
    rim: { value: new three.Color(0x5e1010) },
    skyward: { value: new three.Vector3(0, 1, 0) },
    resolution: { value: new three.Vector2(1, 1) },
    pixels: { value: 1 }, // of the drawing, for each of the page
  };
  private readonly materials: three.ShaderMaterial[] = [];
  private readonly switches = new Set<Switch>();
  private readonly textures = new Map<ColourMap, three.DataTexture>();

  material(
    vertexShader: string,
    fragmentShader: string,
    own: Record<string, three.IUniform> = {},
  ): three.ShaderMaterial {
    const made = new three.ShaderMaterial({
      vertexShader,
      fragmentShader,
      uniforms: { ...this.uniforms, ...own },
      side: three.DoubleSide,
    });
    this.materials.push(made);
    this.define(made);
    return made;
  }

  set(name: Switch, on: boolean): void {
    if (this.switches.has(name) === on) return;
    if (on) this.switches.add(name);
    else this.switches.delete(name);
    for (const material of this.materials) this.define(material);
  }

  private define(material: three.ShaderMaterial): void {
    material.defines = Object.fromEntries([...this.switches].map((name) => [name, 1]));
    material.needsUpdate = true;
  }

  setScale(scale: ColourScale): void {
    let texture = this.textures.get(scale.map);
    if (!texture) {
      const { table } = scale.map;
      texture = new three.DataTexture(table, table.length / 4, 1, three.RGBAFormat);
      texture.minFilter = texture.magFilter = three.LinearFilter;
      texture.needsUpdate = true;
      this.textures.set(scale.map, texture);
    }
    this.uniforms.map.value = texture;
    this.uniforms.ends.value.set(scale.first, scale.last);
  }

  /** Lines at the multiples of `step`; null: none. The line of zero is stronger where zero is the middle. */
  setIsolines(scale: ColourScale | null, step: number): void {
    this.set('ISOLINES', scale !== null);
    if (!scale) return;
    // Counted from the multiple nearest to the range, or float loses the lines of a narrow range far from zero.
    const at = Math.round(scale.low / step) * step;
    const from = scale.position(at);
    const apart = scale.position(at + step) - from;
    this.uniforms.isolines.value.set(from, apart > 0 ? apart : 1, scale.diverging ? 0.5 : nowhere);
  }

  wear(palette: Palette): void {
    this.uniforms.plain.value.set(palette.surface);
  }
}
