// What the colours mean: a bar with round ticks and the name of the field, on the page and in pictures.
import { css } from '../colour/colour_map';
import type { ColourScale } from '../colour/colour_scale';
import { ticksBetween } from '../colour/ticks';
import { element } from '../dom';
import type { SceneViewer } from '../scene/scene_viewer';
import type { Palette } from './theme';

const barWidth = 264;
const barHeight = 11;
const most = 5; // ticks

interface Content {
  title: string;
  scale: ColourScale | null;
  isolines: number; // their distance, 0 for none
  keys: { colour: string; text: string }[];
}

function contentOf(viewer: SceneViewer, palette: Palette): Content {
  const { shown, display, domainSize } = viewer;
  const keys = [];
  if (domainSize.inside + domainSize.ring > 0) {
    keys.push({ colour: '#2f6fd0', text: 'solved for' }, { colour: '#d23b3b', text: 'ring around' });
  }
  if (display.boundary && viewer.boundary.length > 0) keys.push({ colour: palette.boundary, text: 'boundary' });
  if (display.nonManifold && viewer.nonManifold.length > 0) {
    keys.push({ colour: palette.nonManifold, text: 'non-manifold' });
  }
  if (viewer.vectorsShown && display.vectors) keys.push({ colour: palette.arrows, text: viewer.vectorsShown });
  return {
    title: shown.kind === 'plain' ? '' : shown.name,
    scale: viewer.scale,
    isolines: display.isolines ? viewer.isolineStep : 0,
    keys,
  };
}

/** Left to right; where low is high, one colour. */
function paintBar(
  context: CanvasRenderingContext2D,
  scale: ColourScale,
  x: number,
  y: number,
  w: number,
  h: number,
): void {
  for (let i = 0; i < w; ++i) {
    context.fillStyle = css(scale.colour(scale.low + (scale.high - scale.low) * ((i + 0.5) / w)));
    context.fillRect(x + i, y, 1.5, h);
  }
}

const along = (scale: ColourScale, value: number): number =>
  scale.high > scale.low ? (value - scale.low) / (scale.high - scale.low) : 0.5;

export class Legend {
  readonly element = element('figure', { class: 'legend', hidden: true });
  private drawn = '';

  constructor(private readonly palette: () => Palette) {}

  update(viewer: SceneViewer): void {
    const content = contentOf(viewer, this.palette());
    const { scale } = content;
    // Frames come many times a second with the same scale.
    const { title, isolines, keys } = content;
    const key = JSON.stringify([title, isolines, keys, scale?.low, scale?.high, scale?.map.name, this.palette().name]);
    if (key === this.drawn) return;
    this.drawn = key;
    this.element.hidden = content.title === '' && content.keys.length === 0;
    this.element.replaceChildren();
    if (content.title) this.element.append(element('figcaption', { class: 'legend-title' }, content.title));
    if (scale) this.element.append(...this.bar(scale));
    if (content.keys.length > 0) {
      const list = element('div', { class: 'legend-keys' });
      for (const { colour, text } of content.keys) {
        const swatch = element('span', { class: 'swatch' });
        swatch.style.background = colour;
        list.append(element('span', { class: 'key' }, swatch, text));
      }
      this.element.append(list);
    }
  }

  private bar(scale: ColourScale): HTMLElement[] {
    const bar = element('canvas', { class: 'bar', width: barWidth, height: 1, 'aria-hidden': true });
    const context = bar.getContext('2d');
    if (context) paintBar(context, scale, 0, 0, barWidth, 1);
    const { ticks, factor } = ticksBetween(scale.low, scale.high, most);
    const labels = element('div', { class: 'ticks' });
    for (const { value, label } of ticks) {
      const tick = element('span', { class: 'tick' }, label);
      tick.style.left = `${100 * along(scale, value)}%`;
      labels.append(tick);
    }
    if (factor) this.element.firstElementChild?.append(element('span', { class: 'factor' }, factor));
    return [bar, labels];
  }

  /** The same on a canvas, its lower left corner at (x, y). */
  paint(context: CanvasRenderingContext2D, viewer: SceneViewer, x: number, y: number): void {
    const palette = this.palette();
    const { title, scale, keys } = contentOf(viewer, palette);
    const face = getComputedStyle(document.body).fontFamily;
    context.textBaseline = 'alphabetic';
    let line = y;
    if (keys.length > 0) {
      context.font = `12px ${face}`;
      context.textAlign = 'left';
      let at = x;
      for (const { colour, text } of keys) {
        context.fillStyle = colour;
        context.fillRect(at, line - 9, 10, 10);
        context.fillStyle = palette.text;
        context.fillText(text, at + 15, line);
        at += 15 + context.measureText(text).width + 14;
      }
      line -= 22;
    }
    let factor = '';
    if (scale) {
      const labels = ticksBetween(scale.low, scale.high, most);
      factor = labels.factor;
      context.font = `11.5px ${face}`;
      context.textAlign = 'center';
      for (const { value, label } of labels.ticks) {
        const at = x + barWidth * along(scale, value);
        context.fillStyle = palette.text;
        context.fillText(label, at, line);
        context.fillRect(at - 0.5, line - 15, 1, 4);
      }
      paintBar(context, scale, x, line - 16 - barHeight, barWidth, barHeight);
      line -= 16 + barHeight + 8;
    }
    if (title) {
      context.font = `600 13px ${face}`;
      context.textAlign = 'left';
      context.fillStyle = palette.text;
      context.fillText(title, x, line);
      if (factor) {
        const width = context.measureText(title).width;
        context.font = `12px ${face}`;
        context.fillStyle = palette.muted;
        context.fillText(factor, x + width + 8, line);
      }
    }
  }
}
