// What a reload finds again, for as long as the tab is open. Storage may be denied (a file opened from disk, a strict
// browser): then nothing is remembered, and nothing fails.

// The address tells sessions apart; their token is in it, and the key leaves it out of sight of nobody else's page.
const prefix = `beltrami${location.pathname}:`;

export function recall<T>(key: string, otherwise: T): T {
  try {
    const text = sessionStorage.getItem(prefix + key);
    return text === null ? otherwise : (JSON.parse(text) as T);
  } catch {
    return otherwise;
  }
}

export function remember(key: string, value: unknown): void {
  try {
    sessionStorage.setItem(prefix + key, JSON.stringify(value));
  } catch {
    // Denied or full.
  }
}
