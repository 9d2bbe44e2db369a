// Charts: lines that grow while something runs, and those of a report.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { powerOfTen, shortNumber, ticksBetween } from './colour/ticks';
import { element } from './dom';
import type { Palette, Theme } from './look/theme';
import type { ChartData } from './protocol';
import type { LivePlot } from './viewer';

interface Options {
  title: string;
  across: string;
  up: string;
  lines: string[];
  height: number;
  logarithmic: boolean;
}

type Series = (number | null)[];

/** A figure with a chart that is as wide as its place and wears the theme. */
class Chart {
  readonly element: HTMLElement;
  private readonly host = element('div', { class: 'chart-canvas' });
  private plot: uPlot | null = null;
  private width = 0;
  private data: [Series, ...Series[]];

  constructor(
    private readonly options: Options,
    theme: Theme,
  ) {
    this.data = [[], ...options.lines.map((): Series => [])];
    this.element = element(
      'figure',
      { class: 'chart' },
      options.title && element('figcaption', {}, options.title),
      this.host,
    );
    theme.onChange((palette) => this.make(palette));
    new ResizeObserver(([entry]) => {
      const width = Math.floor(entry.contentRect.width);
      if (width === this.width || width === 0) return;
      this.width = width;
      if (this.plot) this.plot.setSize({ width, height: this.options.height });
      else this.make(theme.palette);
    }).observe(this.host);
  }

  set(data: [Series, ...Series[]]): void {
    this.data = data;
    this.plot?.setData(data as uPlot.AlignedData);
  }

  /** Colours are given when a chart is made: another theme makes it again. */
  private make(palette: Palette): void {
    this.plot?.destroy();
    this.plot = null;
    if (this.width === 0) return; // not on the page yet
    const { options } = this;
    const axis = (label: string, side: 2 | 3): uPlot.Axis => ({
      label,
      labelSize: label ? 18 : 0,
      labelFont: '11px system-ui, sans-serif',
      font: '11px system-ui, sans-serif',
      stroke: palette.muted,
      gap: 3,
      size:
        side === 2
          ? 24
          : (_, values) => Math.max(26, 8 + 6.4 * Math.max(0, ...(values ?? []).map((v) => v?.length ?? 0))),
      grid: { stroke: palette.line, width: 1 },
      ticks: { show: false },
      space: side === 2 ? 54 : 30,
      ...(side === 3 && options.logarithmic
        ? {
            splits: (_, __, low, high) => decades(low, high),
            filter: (_, splits) => splits,
            values: (_, splits) => splits.map((y) => powerOfTen(Math.round(Math.log10(y)))),
          }
        : { values: (_, splits) => labelled(splits) }),
    });
    const common: uPlot.Series = { spanGaps: false, points: { show: this.data[0].length === 1 } };
    this.plot = new uPlot(
      {
        width: this.width,
        height: options.height,
        padding: [8, 18, 0, 0],
        legend: { show: options.lines.length > 1, live: false },
        cursor: { points: { size: 6 }, drag: { x: false, y: false } },
        scales: { x: { time: false }, y: options.logarithmic ? { distr: 3 } : {} },
        axes: [axis(options.across, 2), axis(options.up, 3)],
        series: [
          { label: options.across },
          ...options.lines.map((label, i) => ({
            ...common,
            label,
            stroke: palette.series[i % palette.series.length],
            width: 1.5,
          })),
        ],
        hooks: { setCursor: [(plot) => this.read(plot)] },
      },
      this.data as uPlot.AlignedData,
      this.host,
    );
    this.plot.over.append(this.reading);
  }

  private readonly reading = element('div', { class: 'chart-reading', hidden: true });

  /** What is under the cursor, in words. */
  private read(plot: uPlot): void {
    const index = plot.cursor.idx;
    this.reading.hidden = index === null || index === undefined || (plot.cursor.left ?? -1) < 0;
    if (index === null || index === undefined) return;
    const parts = this.options.lines.map((name, i) => {
      const y = this.data[i + 1][index];
      return y === null || y === undefined
        ? ''
        : `${this.options.lines.length > 1 ? `${name} ` : ''}${shortNumber(y, 5)}`;
    });
    const x = this.data[0][index];
    this.reading.textContent = `${x === null ? '' : shortNumber(x, 5)}: ${parts.filter(Boolean).join(', ')}`;
  }
}

/** Powers of ten, not more than a few. */
function decades(low: number, high: number): number[] {
  const first = Math.ceil(Math.log10(low) - 1e-9);
  const last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(Math.ceil((last - first) / 6), 1);
  return Array.from({ length: Math.max(Math.floor((last - first) / step) + 1, 0) }, (_, i) => 10 ** (first + i * step));
}

function labelled(splits: number[]): string[] {
  const { factor } = ticksBetween(splits[0] ?? 0, splits[splits.length - 1] ?? 0, splits.length);
  return splits.map((split) => (factor ? shortNumber(split, 3) : shortNumber(split, 6)));
}

const redrawn = 100; // ms between two pictures of a plot: the mesh is what must be quick

export class GrowingPlot implements LivePlot {
  private readonly chart: Chart;
  private x: number[] = [];
  private y: number[][];
  private waiting = false;
  private drawn = -Infinity;

  constructor(options: { title: string; across: string; lines: string[]; height?: number }, theme: Theme) {
    this.y = options.lines.map(() => []);
    this.chart = new Chart({ up: '', logarithmic: false, ...options, height: options.height ?? 150 }, theme);
  }
  get element(): HTMLElement {
    return this.chart.element;
  }

  add(x: number, y: number[]): void {
    // A chart goes forward: what would step back begins it anew.
    if (this.x.length > 0 && x < this.x[this.x.length - 1]) this.clear();
    this.x.push(x);
    this.y.forEach((line, i) => line.push(y[i] ?? NaN));
    if (this.x.length > 4000) this.thin();
    this.redraw();
  }
  clear(): void {
    this.x = [];
    this.y = this.y.map(() => []);
    this.redraw();
  }

  private thin(): void {
    const half = <T>(list: T[]): T[] => list.filter((_, i) => i % 2 === 0 || i === list.length - 1);
    this.x = half(this.x);
    this.y = this.y.map(half);
  }

  private redraw(): void {
    if (this.waiting) return;
    this.waiting = true;
    const left = this.drawn + redrawn - performance.now();
    window.setTimeout(() => requestAnimationFrame(() => this.draw()), Math.max(left, 0));
  }
  private draw(): void {
    this.waiting = false;
    this.drawn = performance.now();
    this.chart.set([this.x, ...this.y]);
  }
}

/** Lines with places of their own each are put on common ones; where a line has no value there is none, and it goes on
 * between its neighbours. */
export function reportChart(chart: ChartData, theme: Theme): HTMLElement {
  const made = new Chart(
    {
      title: chart.title,
      across: chart.across,
      up: chart.up,
      lines: chart.lines.map(({ name }) => name),
      height: 230,
      logarithmic: chart.logarithmic,
    },
    theme,
  );
  const tables: uPlot.AlignedData[] = chart.lines.map(({ x, y }) => {
    // null as x says nothing; null as y is a gap; a logarithmic axis has no place for 0.
    const points = x
      .map((at, i) => [at, chart.logarithmic && !((y[i] ?? 0) > 0) ? null : y[i]] as const)
      .filter((point): point is [number, number | null] => point[0] !== null)
      .sort((p, q) => p[0] - q[0]);
    return [points.map(([at]) => at), points.map(([, value]) => value)];
  });
  if (tables.length > 0) made.set(uPlot.join(tables) as [Series, ...Series[]]);
  return made.element;
}
