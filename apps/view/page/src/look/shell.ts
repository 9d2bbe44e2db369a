// The frame of the page: the picture, tasks beside it, legend, timeline and status line on and below it.
import { element, icon } from '../dom';
import { GrowingPlot } from '../plot';
import type { Task } from '../protocol';
import type { LivePlot, Shell } from '../viewer';
import type { SceneViewer } from '../scene/scene_viewer';
import { Legend } from './legend';
import { recall, remember } from './memory';
import { Theme } from './theme';
import { MomentTimeline } from './timeline';

export type Tab = Task | 'report';

const titles: Record<Tab, string> = {
  report: 'Report',
  look: 'Look',
  heat: 'Heat',
  wave: 'Wave',
  paint: 'Paint',
  poke: 'Poke',
  harmonics: 'Harmonics',
};

const icons = {
  camera: 'M2 5h3l1-1.8h4L11 5h3v8H2zM8 6.6a2.3 2.3 0 1 0 0 4.6 2.3 2.3 0 0 0 0-4.6z',
  theme: 'M8 1.8a6.2 6.2 0 1 0 0 12.4A6.2 6.2 0 0 0 8 1.8zM8 2v12M10 2.7v10.6M12 4v8',
  help: 'M5.8 6a2.3 2.3 0 1 1 3.4 2c-.8.5-1.2.9-1.2 1.8M8 12.2v.2',
  fit: 'M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4',
  panel: 'M2 3h12v10H2zM6.5 3v10',
};

export interface Actions {
  fit(): void;
  screenshot(): void;
  help(): void;
}

const narrowest = 260;
const widest = 900;

export class PageShell implements Shell {
  readonly theme = new Theme();
  readonly timeline = new MomentTimeline();
  readonly legend = new Legend(() => this.theme.palette);
  readonly stage = element('div', { class: 'stage' });
  readonly hosts: Record<Tab, HTMLElement>;
  /** The user, not the program, has changed the tab. */
  onTab: (tab: Tab) => void = () => {};

  private picture: SceneViewer | null = null;
  private current: Tab;
  private readonly tabs = new Map<Tab, HTMLButtonElement>();
  private readonly title = element('h1', {}, 'Beltrami');
  private readonly brief = element('span', { class: 'brief' });
  private readonly status = element('div', { class: 'status', role: 'status' });
  private readonly veil = element('div', { class: 'veil' }, element('p', {}, 'Waiting for the mesh\u2026'));
  private readonly side: HTMLElement;
  private readonly page: HTMLElement;

  constructor(shown: Tab[], actions: Actions) {
    this.current = shown[0];
    const panels = shown.map((tab) =>
      element('section', {
        class: 'tab-panel',
        id: `panel-${tab}`,
        role: 'tabpanel',
        'aria-labelledby': `tab-${tab}`,
        hidden: true,
      }),
    );
    this.hosts = Object.fromEntries(shown.map((tab, i) => [tab, panels[i]])) as Record<Tab, HTMLElement>;

    const list = element('div', {
      class: 'tabs',
      role: 'tablist',
      'aria-label': 'Task',
      onkeydown: (e: KeyboardEvent) => this.roam(e),
    });
    for (const tab of shown) {
      const button = element(
        'button',
        {
          type: 'button',
          role: 'tab',
          id: `tab-${tab}`,
          'aria-controls': `panel-${tab}`,
          'data-test': `tab-${tab}`,
          onclick: () => this.choose(tab, true),
        },
        titles[tab],
      );
      this.tabs.set(tab, button);
      list.append(button);
    }
    this.side = element(
      'aside',
      { class: 'side', 'aria-label': 'Controls' },
      list,
      element('div', { class: 'panels' }, ...panels),
    );

    const tool = (path: string, label: string, key: string, action: () => void, test: string): HTMLElement =>
      element(
        'button',
        {
          class: 'quiet',
          type: 'button',
          title: `${label} (${key})`,
          'aria-label': label,
          'data-test': test,
          onclick: action,
        },
        icon(path),
      );
    this.page = element(
      'div',
      { class: 'page' },
      element(
        'header',
        { class: 'top' },
        this.title,
        this.brief,
        element(
          'div',
          { class: 'tools', role: 'toolbar', 'aria-label': 'Picture' },
          tool(icons.fit, 'Fit', 'f', actions.fit, 'fit'),
          tool(icons.camera, 'Save the picture', 's', actions.screenshot, 'screenshot'),
          tool(icons.theme, 'Light or dark', 'd', () => this.theme.toggle(), 'theme'),
          tool(icons.panel, 'Show or hide the controls', 'c', () => this.toggleSide(), 'side'),
          tool(icons.help, 'Keyboard', '?', actions.help, 'help'),
        ),
      ),
      this.side,
      this.splitter(),
      element('main', { class: 'middle' }, this.stage, this.timeline.element),
      this.status,
    );
    this.stage.append(this.legend.element, this.veil);
    document.body.append(this.page);
    this.setWidth(recall('side', 372));
    this.page.classList.toggle('bare', recall('bare', false));
    this.choose(this.current, false);
  }

  get viewer(): SceneViewer {
    if (!this.picture) throw new Error('there is no mesh yet');
    return this.picture;
  }

  /** The mesh has come. */
  attach(viewer: SceneViewer): void {
    this.picture = viewer;
    const { mesh } = viewer;
    document.title = `${mesh.name} \u2013 Beltrami`;
    this.title.textContent = mesh.name;
    this.brief.textContent = mesh.brief;
    this.brief.title = mesh.brief;
    this.veil.hidden = true;
    viewer.onChange(() => this.legend.update(viewer));
    // Where there is little room the mesh is fitted above the legend, else beside it; whether or not there is one yet.
    viewer.stage.insets = () => ({ top: 0, right: 0, bottom: this.stage.clientWidth < 720 ? 64 : 0, left: 0 });
    this.theme.onChange((palette) => {
      viewer.wear(palette);
      this.legend.update(viewer);
    });
  }

  /** There is no picture, or not yet; why. */
  excuse(text: string): void {
    this.veil.hidden = false;
    this.veil.replaceChildren(element('p', {}, text));
  }

  livePlot(options: { title: string; across: string; lines: string[]; height?: number }): LivePlot {
    return new GrowingPlot(options, this.theme);
  }

  say(text: string, error = false): void {
    this.status.textContent = text;
    this.status.classList.toggle('error', error);
    // Errors are read aloud at once.
    this.status.setAttribute('role', error ? 'alert' : 'status');
  }

  get said(): string {
    return this.status.textContent ?? '';
  }

  get tab(): Tab {
    return this.current;
  }

  choose(tab: Tab, byUser: boolean): void {
    if (!this.tabs.has(tab)) return;
    const changed = tab !== this.current;
    this.current = tab;
    for (const [name, button] of this.tabs) {
      const chosen = name === tab;
      button.setAttribute('aria-selected', String(chosen));
      button.tabIndex = chosen ? 0 : -1;
      this.hosts[name].hidden = !chosen;
    }
    if (changed && byUser) this.onTab(tab);
  }

  /** Arrow keys go through the tabs. */
  private roam(event: KeyboardEvent): void {
    const order = [...this.tabs.keys()];
    const at = order.indexOf(this.current);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: order.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    const tab = order[(to + order.length) % order.length];
    this.choose(tab, true);
    this.tabs.get(tab)?.focus();
  }

  toggleSide(): void {
    remember('bare', this.page.classList.toggle('bare'));
  }

  private setWidth(pixels: number): void {
    const width = Math.round(Math.min(Math.max(pixels, narrowest), widest));
    this.page.style.setProperty('--side', `${width}px`);
    this.handle.setAttribute('aria-valuenow', String(width));
    remember('side', width);
  }

  private readonly handle = element('div', {
    class: 'splitter',
    role: 'separator',
    tabindex: 0,
    'aria-orientation': 'vertical',
    'aria-label': 'Width of the controls',
    'aria-valuemin': narrowest,
    'aria-valuemax': widest,
  });

  private splitter(): HTMLElement {
    const { handle } = this;
    handle.addEventListener('pointerdown', (event) => {
      handle.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    handle.addEventListener('pointermove', (event) => {
      if (handle.hasPointerCapture(event.pointerId))
        this.setWidth(event.clientX - this.side.getBoundingClientRect().left);
    });
    handle.addEventListener('keydown', (event) => {
      const by = { ArrowLeft: -24, ArrowRight: 24 }[event.key];
      if (by === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      this.setWidth(this.side.clientWidth + by);
    });
    return handle;
  }
}
