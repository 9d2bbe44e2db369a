// Curves through colour space whose lightness changes evenly, so that equal differences of a number look equal, also in
// grey and to colour-blind eyes. Viridis and the diverging map are those of apps/picture/colour_map.cpp.
import { type Colour, colourOf, type Oklab, oklabOf } from './oklab';

export type MapName = 'viridis' | 'magma' | 'cividis' | 'grey' | 'diverging';

export const mapTitles: Record<MapName, string> = {
  viridis: 'Viridis',
  magma: 'Magma',
  cividis: 'Cividis',
  grey: 'Grey',
  diverging: 'Diverging, zero in the middle',
};

/** What is drawn where a value is not a finite number. */
export const noValueColour: Colour = [0.55, 0.55, 0.55];

const entries = 1024;

// Ten equidistant colours each; in between, straight lines in Oklab.
// Viridis and magma: S. van der Walt and N. Smith, CC0.
const viridis = [0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725];
const magma = [0x000004, 0x180f3e, 0x451077, 0x721f81, 0x9f2f7f, 0xcd4071, 0xf1605d, 0xfd9567, 0xfec98d, 0xfcfdbf];
// Cividis: J. Nuñez, C. Anderton and R. Renslow, PLOS ONE 13(7), 2018, CC0.
const cividis = [0x00204d, 0x00336f, 0x39486b, 0x575c6d, 0x707173, 0x8a8779, 0xa69d75, 0xc4b56c, 0xe4cf5b, 0xffea46];

function along(anchors: number[]): (t: number) => Oklab {
  const points = anchors.map(oklabOf);
  return (t) => {
    const i = Math.min(Math.floor(t * (points.length - 1)), points.length - 2);
    const w = t * (points.length - 1) - i;
    const [p, q] = [points[i], points[i + 1]];
    return {
      lightness: p.lightness + w * (q.lightness - p.lightness),
      a: p.a + w * (q.a - p.a),
      b: p.b + w * (q.b - p.b),
    };
  };
}

// Lightness falls evenly from the middle, which is grey enough to stand out from white paper; the colourfulness rises
// to what a screen can show at that lightness.
function diverging(t: number): Oklab {
  const away = Math.abs(2 * t - 1);
  const chroma = 0.155 * Math.sin(0.5 * Math.PI * Math.min(1, 1.3 * away));
  const hue = ((t < 0.5 ? 256 : 27) * Math.PI) / 180;
  return { lightness: 0.93 - 0.51 * away, a: chroma * Math.cos(hue), b: chroma * Math.sin(hue) };
}

const curves: Record<MapName, (t: number) => Oklab> = {
  viridis: along(viridis),
  magma: along(magma),
  cividis: along(cividis),
  grey: (t) => ({ lightness: 0.22 + 0.75 * t, a: 0, b: 0 }),
  diverging,
};

export class ColourMap {
  /** RGBA bytes of equidistant positions from 0 to 1, as a texture takes them. */
  readonly table = new Uint8Array(4 * entries);

  private static readonly made = new Map<MapName, ColourMap>();

  static of(name: MapName): ColourMap {
    let map = ColourMap.made.get(name);
    if (!map) ColourMap.made.set(name, (map = new ColourMap(name)));
    return map;
  }

  private constructor(readonly name: MapName) {
    for (let i = 0; i < entries; ++i) {
      const [r, g, b] = colourOf(curves[name](i / (entries - 1)));
      this.table.set([Math.round(255 * r), Math.round(255 * g), Math.round(255 * b), 255], 4 * i);
    }
  }

  /** The colour at a position in [0, 1]; beyond it, that of the nearer end; noValueColour for NaN. */
  at(position: number): Colour {
    if (Number.isNaN(position)) return noValueColour;
    const entry = 4 * Math.round(Math.min(Math.max(position, 0), 1) * (entries - 1));
    return [this.table[entry] / 255, this.table[entry + 1] / 255, this.table[entry + 2] / 255];
  }
}

export const css = ([r, g, b]: Colour): string =>
  `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`;
