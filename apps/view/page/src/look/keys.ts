// Keys, and the sheet that tells of them.
import { element } from '../dom';

export interface Shortcut {
  keys: string[]; // as KeyboardEvent.key has them
  shown: string;
  what: string;
  act: (key: string) => void;
}

const writing = 'input:not([type=range]):not([type=checkbox]):not([type=radio]), select, textarea, [contenteditable]';

/** Whoever has the focus comes first: letters in a text field are text, arrows on a slider are the slider's. */
function isTaken(event: KeyboardEvent): boolean {
  const { target, key } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return true;
  if (!(target instanceof Element)) return false;
  if (target.closest(writing) || target.closest('dialog')) return true;
  if (key.startsWith('Arrow'))
    return target.closest('input, [role=tab], [role=separator], [role=slider], svg') !== null;
  return key === ' ' && target.closest('button, input, summary, a') !== null;
}

export function listen(shortcuts: Shortcut[]): void {
  document.addEventListener('keydown', (event) => {
    if (isTaken(event)) return;
    const shortcut = shortcuts.find(({ keys }) => keys.includes(event.key));
    if (!shortcut) return;
    event.preventDefault();
    shortcut.act(event.key);
  });
}

export class HelpSheet {
  private readonly dialog: HTMLDialogElement;

  constructor(shortcuts: Shortcut[]) {
    const row = (keys: string, what: string): HTMLElement =>
      element('div', { class: 'help-row' }, element('kbd', {}, keys), element('span', {}, what));
    this.dialog = element(
      'dialog',
      { class: 'help', 'aria-label': 'Keyboard and mouse' },
      element('h2', {}, 'Keyboard'),
      element('div', { class: 'help-rows' }, ...shortcuts.map(({ shown, what }) => row(shown, what))),
      element('h2', {}, 'Mouse'),
      element(
        'div',
        { class: 'help-rows' },
        row('drag', 'turn; with a tool in hand, on the surface: use it'),
        row('right drag', 'move'),
        row('wheel', 'nearer and farther'),
      ),
      element('button', { type: 'button', class: 'primary', onclick: () => this.dialog.close() }, 'Close'),
    );
    this.dialog.addEventListener('click', (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
    document.body.append(this.dialog);
  }

  toggle(): void {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }
}
