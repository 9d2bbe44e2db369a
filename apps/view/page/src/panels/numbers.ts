// Numbers as people read and type them.

/** Four digits, without zeros that say nothing. */
export function short(x: number, digits = 4): string {
  if (!Number.isFinite(x)) return String(x);
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e-3 && size < 1e6) return String(Number(x.toPrecision(digits)));
  return x
    .toExponential(digits - 1)
    .replace(/\.?0+e/, 'e')
    .replace('e+', 'e');
}

export function counted(n: number, noun = '', plural = `${noun}s`): string {
  const digits = n.toLocaleString('en');
  return noun === '' ? digits : `${digits} ${n === 1 ? noun : plural}`;
}

export function duration(seconds: number): string {
  if (seconds < 1e-3) return `${short(seconds * 1e6, 3)} µs`;
  if (seconds < 1) return `${short(seconds * 1e3, 3)} ms`;
  if (seconds < 120) return `${short(seconds, 3)} s`;
  return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

/** null where the text is no number. A comma may stand for the point. */
export function parsed(text: string): number | null {
  const cleaned = text.trim().replace(',', '.');
  const value = Number(cleaned);
  return cleaned === '' || !Number.isFinite(value) ? null : value;
}

export function clamped(x: number, low: number, high: number): number {
  return Math.min(Math.max(x, low), high);
}

/** No more digits than a hand can place. */
export function neat(x: number): number {
  return Number(x.toPrecision(5));
}
