// Round numbers along a scale, as apps/picture/ticks.cpp has them, and numbers for people.

export interface Ticks {
  ticks: { value: number; label: string }[];
  /** What the labels are to be multiplied by, such as ×10⁻⁵; '' for nothing. */
  factor: string;
}

const minus = '\u2212';
const raised = '\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079';

const exponentOf = (value: number): number => Math.floor(Math.log10(value));

export const powerOfTen = (exponent: number): string =>
  '10' +
  (exponent < 0 ? '\u207b' : '') +
  [...String(Math.abs(exponent))].map((digit) => raised[Number(digit)]).join('');

/** 1, 2 or 5 times a power of ten, at least `rough`. */
export function roundStep(rough: number): number {
  const power = 10 ** exponentOf(rough);
  for (const factor of [1, 2, 5]) {
    if (factor * power >= rough * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

const withSign = (value: number, digits: string): string =>
  value < 0 && /[1-9]/.test(digits) ? minus + digits : digits;

/** About `wanted` ticks from low to high, both finite; one where they are equal. */
export function ticksBetween(low: number, high: number, wanted: number): Ticks {
  const largest = Math.max(Math.abs(low), Math.abs(high));
  let unit = 1;
  let factor = '';
  if (largest > 0 && (largest >= 1e5 || largest < 1e-3)) {
    const exponent = Math.max(exponentOf(largest), -307);
    unit = 10 ** exponent;
    factor = '\u00d7' + powerOfTen(exponent);
  }
  const from = low / unit;
  const to = high / unit;
  if (!(to > from))
    return { ticks: [{ value: low, label: withSign(from, String(Number(Math.abs(from).toPrecision(6)))) }], factor };
  const step = roundStep((to - from) / Math.max(wanted, 1));
  const decimals = Math.min(Math.max(-exponentOf(step * (1 + 1e-9)), 0), 12);
  const slack = 0.005 * (to - from); // the end is as good as at the round number: too close to see
  const first = Math.ceil((from - slack) / step);
  const ticks = [];
  for (let i = 0; i <= 2 * wanted + 2; ++i) {
    const value = (first + i) * step;
    if (value > to + slack) break;
    ticks.push({
      value: Math.min(Math.max(value * unit, low), high),
      label: withSign(value, Math.abs(value).toFixed(decimals)),
    });
  }
  return { ticks, factor };
}

/** A number for reading: `digits` significant digits, no trailing zeros, powers of ten where it is very large or small. */
export function shortNumber(value: number, digits = 4): string {
  if (Number.isNaN(value)) return 'no value';
  if (!Number.isFinite(value)) return value > 0 ? '\u221e' : minus + '\u221e';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const exponent = exponentOf(size);
    const mantissa = Number((size / 10 ** exponent).toPrecision(digits));
    return (value < 0 ? minus : '') + (mantissa === 1 ? '' : `${mantissa}\u00d7`) + powerOfTen(exponent);
  }
  return String(Number(value.toPrecision(digits))).replace('-', minus);
}

/** 34,835 */
export const counted = (count: number): string => count.toLocaleString('en-US');
