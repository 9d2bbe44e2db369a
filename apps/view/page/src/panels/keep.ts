// What to take away: the result as a file, and the command lines that do the same.
import { download, element } from '../dom';
import type { Request, SavedMessage, Task } from '../protocol';
import type { Shell } from '../viewer';
import { button, group, row, write } from './parts';

const formats = ['ply', 'obj', 'vtu', 'csv'] as const;

export class Keep {
  readonly element: HTMLElement;
  private readonly lines: HTMLElement;
  private readonly commands: HTMLElement;
  private readonly copied: HTMLElement;

  /** csv: what is in the CSV file. step: of the moment that is looked at. */
  constructor(
    task: Task,
    csv: string,
    send: (request: Request) => void,
    step: () => number | undefined = () => undefined,
  ) {
    const files = formats.map((format) => {
      const save = () => send(format === 'csv' ? { do: 'save', format } : { do: 'save', format, step: step() });
      const made = button(format.toUpperCase(), `${task}-save-${format}`, save);
      made.title = format === 'csv' ? `Save ${csv}` : `Save the mesh and the result as ${format.toUpperCase()}`;
      return made;
    });
    this.lines = element('pre', { tabindex: 0, 'data-test': `${task}-command`, 'aria-label': 'Command lines' });
    this.copied = element('span', { class: 'copied', role: 'status' });
    const copy = button('Copy', `${task}-copy`, () => void this.copy(), 'quiet');
    this.commands = element('div', { class: 'commands' }, this.lines, row(copy, this.copied));
    this.element = group('Save', row(...files), this.commands);
    this.command([]);
  }

  command(lines: string[]): void {
    this.commands.hidden = lines.length === 0;
    write(this.lines, lines.join('\n'));
    write(this.copied, '');
  }

  private async copy(): Promise<void> {
    const text = this.lines.textContent ?? '';
    try {
      await navigator.clipboard.writeText(text);
      write(this.copied, 'Copied');
    } catch {
      // No clipboard without a secure context or permission: then the user copies what is selected.
      const selection = window.getSelection();
      selection?.selectAllChildren(this.lines);
      write(this.copied, 'Selected: press Ctrl C');
    }
  }
}

export async function give(saved: SavedMessage, shell: Shell): Promise<void> {
  try {
    const answer = await fetch(saved.path);
    if (!answer.ok) throw new Error(`the program answered ${answer.status}`);
    download(saved.name, await answer.blob());
    shell.say(`Saved ${saved.name}`);
  } catch (error) {
    shell.say(`${saved.name} could not be fetched: ${error instanceof Error ? error.message : String(error)}`, true);
  }
}
