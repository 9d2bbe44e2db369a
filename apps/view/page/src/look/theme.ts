// Light and dark: what the system prefers, unless the user says otherwise.
import { recall, remember } from './memory';

export type ThemeName = 'light' | 'dark';

/** Colours of what is drawn on canvases, which style sheets do not reach. */
export interface Palette {
  name: ThemeName;
  background: string;
  surface: string;
  text: string;
  muted: string;
  line: string;
  wire: [number, number, number, number];
  boundary: string;
  nonManifold: string;
  arrows: string;
  force: string;
  halo: string;
  /** Lines of charts: told apart by lightness too. */
  series: string[];
}

const palettes: Record<ThemeName, Palette> = {
  light: {
    name: 'light',
    background: '#eff1f4',
    surface: '#c3ccd8',
    text: '#1b2330',
    muted: '#5a6675',
    line: '#d6dbe2',
    wire: [0.08, 0.1, 0.14, 0.42],
    boundary: '#d9730d',
    nonManifold: '#c8102e',
    arrows: '#20262f',
    force: '#d3540f',
    halo: '#ffffff',
    series: ['#2563b0', '#c2410c', '#12805c', '#8a3ea8', '#8a6a00', '#475569'],
  },
  dark: {
    name: 'dark',
    background: '#14171c',
    surface: '#a4afbd',
    text: '#e6eaf0',
    muted: '#9aa5b4',
    line: '#303742',
    wire: [0.02, 0.03, 0.05, 0.5],
    boundary: '#ffa64d',
    nonManifold: '#ff4d6a',
    arrows: '#f3f6fa',
    force: '#ff8b3d',
    halo: '#14171c',
    series: ['#6cabf0', '#f2965a', '#4fc39a', '#c58be0', '#d6b648', '#a3b1c4'],
  },
};

export class Theme {
  private readonly preference = matchMedia('(prefers-color-scheme: dark)');
  private readonly listeners: ((palette: Palette) => void)[] = [];
  private chosen: ThemeName | null;

  constructor() {
    const known = recall<string>('theme', '');
    this.chosen = known === 'light' || known === 'dark' ? known : null;
    this.preference.addEventListener('change', () => this.tell());
    document.documentElement.dataset.theme = this.name;
  }

  get name(): ThemeName {
    return this.chosen ?? (this.preference.matches ? 'dark' : 'light');
  }
  /** What the user said; null: as the system. */
  get choice(): ThemeName | null {
    return this.chosen;
  }
  get palette(): Palette {
    return palettes[this.name];
  }

  /** null: as the system. */
  choose(name: ThemeName | null, keep = true): void {
    this.chosen = name;
    if (keep) remember('theme', name ?? '');
    this.tell();
  }
  toggle(): void {
    this.choose(this.name === 'dark' ? 'light' : 'dark');
  }

  /** Called at once, and after every change. */
  onChange(listener: (palette: Palette) => void): void {
    this.listeners.push(listener);
    listener(this.palette);
  }

  private tell(): void {
    document.documentElement.dataset.theme = this.name;
    for (const listener of this.listeners) listener(this.palette);
  }
}
