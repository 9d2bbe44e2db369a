// Filter curves: gain over frequency, linear between points, constant before the first and behind the last.
import { neat } from './numbers';

export type Point = [frequency: number, gain: number];

export function gainAt(curve: readonly Point[], frequency: number): number {
  const behind = curve.findIndex(([f]) => f > frequency);
  if (behind === -1) return curve[curve.length - 1][1];
  if (behind === 0) return curve[0][1];
  const [[f0, g0], [f1, g1]] = [curve[behind - 1], curve[behind]];
  return g0 + ((g1 - g0) * (frequency - f0)) / (f1 - f0);
}

/** Over [low, high]: what the program takes for all frequencies that its basis does not hold. */
export function meanGain(curve: readonly Point[], low: number, high: number): number {
  if (!(high > low)) return gainAt(curve, low);
  const inner = curve.filter(([f]) => f > low && f < high);
  let integral = 0;
  let [f0, g0]: Point = [low, gainAt(curve, low)];
  for (const [f, g] of inner) {
    integral += 0.5 * (g0 + g) * (f - f0);
    [f0, g0] = [f, g];
  }
  // A step at the end belongs to what lies behind it.
  const first = curve.find(([f]) => f >= high);
  const [last, lastGain] = inner.at(-1) ?? [low, g0];
  const end =
    first === undefined || first[0] === last
      ? lastGain
      : lastGain + ((first[1] - lastGain) * (high - last)) / (first[0] - last);
  integral += 0.5 * (g0 + end) * (high - f0);
  return integral / (high - low);
}

export type Preset = 'identity' | 'low-pass' | 'high-pass' | 'band' | 'notch' | 'enhance' | 'exaggerate';

export const presets: Preset[] = ['identity', 'low-pass', 'high-pass', 'band', 'notch', 'enhance', 'exaggerate'];

/** Made for a basis that ends at `cutoff`, so that each does something that can be seen. */
export function presetCurve(preset: Preset, cutoff: number, nyquist: number): Point[] {
  return exactPreset(preset, cutoff, nyquist).map(([frequency, gain]) => [neat(frequency), gain]);
}

function exactPreset(preset: Preset, cutoff: number, nyquist: number): Point[] {
  const c = cutoff > 0 ? Math.min(cutoff, nyquist) : nyquist / 5;
  const plateau = (inside: number, outside: number): Point[] => [
    [0, outside],
    [0.2 * c, outside],
    [0.3 * c, inside],
    [0.6 * c, inside],
    [0.7 * c, outside],
    [nyquist, outside],
  ];
  const ramp = (low: number, before: number, high: number, behind: number): Point[] => [
    [0, before],
    [low * c, before],
    [high * c, behind],
    [nyquist, behind],
  ];
  switch (preset) {
    case 'identity':
      return [
        [0, 1],
        [nyquist, 1],
      ];
    case 'low-pass':
      return ramp(0.3, 1, 0.5, 0);
    case 'high-pass':
      return ramp(0.1, 0, 0.2, 1);
    case 'band':
      return plateau(1, 0);
    case 'notch':
      return plateau(0, 1);
    case 'enhance':
      return ramp(0.3, 1, 0.6, 1.8);
    case 'exaggerate':
      return plateau(2, 1);
  }
}
