// The report of a run: how it was called, what troubled it, every number of its summary, and charts.
import { element } from '../dom';
import type { Theme } from '../look/theme';
import { reportChart } from '../plot';
import type { MeshMessage, ReportMessage } from '../protocol';

/** Values as the JSON has them: what is read here can be compared digit by digit. */
const exact = (value: unknown): string => (typeof value === 'string' ? value : JSON.stringify(value));

const isTree = (value: unknown): value is object => typeof value === 'object' && value !== null;

const shortList = 12;

function leaf(value: unknown, path: string): HTMLElement {
  const kind = typeof value === 'number' ? 'number' : typeof value === 'string' ? 'text' : 'other';
  return element('span', { class: `value ${kind}`, 'data-path': path }, exact(value));
}

/** An object as a table of names and values, a list of plain values as a line of them. */
function table(tree: object, path: string, depth: number): HTMLElement {
  const join = (key: string): string => (path ? `${path}.${key}` : key);
  const entries = Object.entries(tree);
  if (entries.length === 0) return element('span', { class: 'value other', 'data-path': path }, exact(tree));
  if (Array.isArray(tree) && !tree.some(isTree)) {
    const items = entries.map(([key, value]) => leaf(value, join(key)));
    const line = element('div', { class: 'list' }, ...items);
    return items.length <= shortList
      ? line
      : element('details', {}, element('summary', {}, `${items.length} values`), line);
  }
  const rows = entries.map(([key, value]) => {
    const name = Array.isArray(tree) ? `${Number(key) + 1}.` : key.replaceAll('_', ' ');
    if (!isTree(value)) {
      return element(
        'div',
        { class: 'fact' },
        element('span', { class: 'name', title: join(key) }, name),
        leaf(value, join(key)),
      );
    }
    const inner = table(value, join(key), depth + 1);
    if (inner.className === 'list' || inner.className.startsWith('value')) {
      return element('div', { class: 'fact' }, element('span', { class: 'name', title: join(key) }, name), inner);
    }
    return element(
      'details',
      { class: 'branch', open: depth < 1 || Object.keys(value).length <= 6 },
      element('summary', {}, name),
      inner,
    );
  });
  return element('div', { class: 'facts' }, ...rows);
}

/** Texts of every `warnings` in the summary. */
function warningsOf(summary: unknown): string[] {
  if (!isTree(summary)) return [];
  return Object.entries(summary).flatMap(([key, value]) => {
    if (key !== 'warnings') return warningsOf(value);
    return Array.isArray(value) ? value.map(exact) : value ? [exact(value)] : [];
  });
}

function commandLine(command: string, say: (text: string) => void): HTMLElement {
  const words = command.split(/( +)/).map((word) => (word.trim() ? element('span', { class: 'word' }, word) : word));
  const text = element('code', { 'data-test': 'command' }, ...words);
  const copy = async (): Promise<void> => {
    try {
      await navigator.clipboard.writeText(command);
      say('The command line is on the clipboard.');
    } catch {
      // A page from disk may not write to the clipboard: then it is selected, and the user copies it.
      getSelection()?.selectAllChildren(text);
      say('The command line is selected: copy it with Ctrl+C.');
    }
  };
  return element(
    'div',
    { class: 'command' },
    text,
    element('button', { type: 'button', 'data-test': 'copy', onclick: () => void copy() }, 'Copy'),
  );
}

export function showReport(
  host: HTMLElement,
  report: ReportMessage,
  mesh: MeshMessage | null,
  theme: Theme,
  say: (text: string) => void,
): void {
  const warnings = warningsOf(report.summary);
  const section = (title: string, ...children: (Node | false)[]): HTMLElement =>
    element('section', { class: 'group', 'aria-label': title }, element('h3', {}, title), ...children);
  host.classList.add('panel');
  host.replaceChildren(
    section('Command', commandLine(report.command, say)),
    ...(warnings.length > 0
      ? [
          element(
            'section',
            { class: 'warnings', role: 'note', 'aria-label': 'Warnings' },
            element('h3', {}, warnings.length === 1 ? 'A warning' : `${warnings.length} warnings`),
            ...warnings.map((text) => element('p', { 'data-test': 'warning' }, text)),
          ),
        ]
      : []),
    ...(mesh?.decimated ? [element('p', { class: 'notice', 'data-test': 'decimated' }, mesh.decimation)] : []),
    ...(report.charts.length > 0
      ? [section('Charts', ...report.charts.map((chart) => reportChart(chart, theme)))]
      : []),
    section('Summary', table(report.summary, '', 0)),
  );
}
