// Which colour a value has when values between low and high are shown: the rule of apps/picture/colour_map.hpp.
import { ColourMap, type MapName } from './colour_map';
import type { Colour } from './oklab';

/** A value far outside of a narrow range must stay finite when it is interpolated. */
const farthest = 1e9;
/** Stands for "not a finite number" among positions: no interpolation with a position brings it near them. */
export const noPosition = 1e30;

/** Both sides of zero matter: the smaller at least 1/20 of the larger, so that rounding below zero does not count. */
export const bothSigns = (low: number, high: number): boolean => Math.min(-low, high) > 0.05 * Math.max(-low, high);

export class ColourScale {
  readonly map: ColourMap;
  readonly diverging: boolean;
  /** Positions of low and high: colours beyond them are theirs. */
  readonly first: number;
  readonly last: number;

  /** low <= high, both finite. `wanted`: a map, or the one that suits. */
  constructor(
    readonly low: number,
    readonly high: number,
    wanted: MapName | 'automatic' = 'automatic',
  ) {
    const name = wanted !== 'automatic' ? wanted : bothSigns(low, high) ? 'diverging' : 'viridis';
    this.map = ColourMap.of(name);
    this.diverging = name === 'diverging' && Math.max(-low, high) > 0;
    this.first = low === high ? 0 : this.position(low);
    this.last = low === high ? 1 : this.position(high);
  }

  /** Where on the map a value lies, linear and not clamped; noPosition for what is not a finite number. */
  position(value: number): number {
    if (!Number.isFinite(value)) return noPosition;
    const { offset, slope } = this.line();
    if (slope === 0) return value === this.low ? 0.5 : value < this.low ? 0 : 1;
    return Math.min(Math.max(offset + slope * value, -farthest), farthest);
  }

  /** position = offset + slope value; a slope of 0: the range is one value. */
  private line(): { offset: number; slope: number } {
    if (this.diverging) return { offset: 0.5, slope: 0.5 / Math.max(-this.low, this.high) };
    if (this.low === this.high) return { offset: 0.5, slope: 0 };
    const slope = 1 / (this.high - this.low);
    return { offset: -this.low * slope, slope };
  }

  /** Positions of many values at once. */
  positions(values: ArrayLike<number>, out: Float32Array): void {
    const { offset, slope } = this.line();
    if (slope === 0) {
      for (let i = 0; i < out.length; ++i) out[i] = this.position(values[i]);
      return;
    }
    for (let i = 0; i < out.length; ++i) {
      const p = offset + slope * values[i];
      out[i] = p < farthest ? (p > -farthest ? p : this.position(values[i])) : this.position(values[i]);
    }
  }

  colour(value: number): Colour {
    const position = this.position(value);
    if (position === noPosition) return this.map.at(NaN);
    return this.map.at(Math.min(Math.max(position, this.first), this.last));
  }
}

/** The smallest and the largest finite value, [0, 0] where there is none. */
export function finiteRange(values: ArrayLike<number>): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < values.length; ++i) {
    const v = values[i];
    if (v < low && v !== -Infinity) low = v;
    if (v > high && v !== Infinity) high = v;
  }
  return low <= high ? [low, high] : [0, 0];
}

const outliers = 0.01; // of the values, at each end
const farOut = 5; // times as wide as what holds all others
const most = 20_000; // values that are looked at

/** Where a few values would leave one colour for all others: the range of the others. Else null. */
export function rangeWithoutOutliers(values: ArrayLike<number>): [number, number] | null {
  const stride = Math.max(Math.floor(values.length / most), 1);
  const sample = new Float32Array(Math.ceil(values.length / stride));
  let count = 0;
  for (let i = 0; i < values.length; i += stride) {
    if (Number.isFinite(values[i])) sample[count++] = values[i];
  }
  const sorted = sample.subarray(0, count).sort();
  const cut = Math.floor(outliers * count);
  const [low, high] = [sorted[cut], sorted[count - 1 - cut]];
  const [lowest, highest] = finiteRange(values);
  if (cut === 0 || !(high > low) || highest - lowest < farOut * (high - low)) return null;
  // Lengths and the like begin at zero.
  return [lowest >= 0 && lowest < 0.1 * high ? lowest : low, high];
}
