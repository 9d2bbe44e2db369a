// How the work of a task goes: a bar while it runs, then what came of it.
import { element } from '../dom';
import type { DoneMessage, ProgressMessage, RefusedMessage, StateMessage, Task } from '../protocol';
import { write } from './parts';

export class Work {
  readonly element: HTMLElement;
  private readonly bar: HTMLProgressElement;
  private readonly phase: HTMLElement;
  private readonly outcome: HTMLElement;
  private readonly hint: HTMLElement;
  private runs = false;
  private told = false; // by progress messages, which know more than frames do

  constructor(private readonly task: Task) {
    this.bar = element('progress', { max: 1, 'data-test': `${task}-progress`, 'aria-label': 'Progress' });
    this.phase = element('span', { class: 'phase', 'data-test': `${task}-phase` });
    this.outcome = element('p', { class: 'outcome', 'data-test': `${task}-outcome` });
    this.hint = element('p', { class: 'hint', 'data-test': `${task}-hint` });
    this.element = element('div', { class: 'work' }, this.bar, this.phase, this.outcome, this.hint);
    this.rest();
    this.tell('', '', 'plain');
  }

  running(running: StateMessage['running']): void {
    this.runs = running?.task === this.task;
    if (running?.task !== this.task) this.rest();
    else {
      if (this.bar.hidden) this.begin();
      this.element.classList.toggle('paused', running.paused);
    }
  }

  /** Something was asked for: what came of the last is no longer of interest. */
  begin(): void {
    this.told = false;
    this.tell('', '', 'plain');
    this.advance(-1, '');
  }

  /** A frame of a run. */
  stepped(step: number, steps: number): void {
    if (this.runs && !this.told) this.advance(step / steps, `step ${step} of ${steps}`);
  }

  private advance(fraction: number, phase: string): void {
    this.bar.hidden = false;
    this.phase.hidden = false;
    if (fraction < 0) this.bar.removeAttribute('value');
    else this.bar.value = fraction;
    const percent = fraction < 0 ? '' : `${Math.floor(100 * fraction)} %`;
    write(this.phase, phase === '' ? percent : percent === '' ? phase : `${phase}, ${percent}`);
  }

  progress(message: ProgressMessage): void {
    this.told = true;
    this.advance(message.fraction, message.phase);
  }

  done(message: DoneMessage): void {
    this.rest();
    const [text, look] = outcomeOf(message);
    this.tell(text, message.hint, look);
  }

  refused(message: RefusedMessage): void {
    if (!this.runs) this.rest();
    this.tell(message.what, message.hint, 'failed');
  }

  note(text: string): void {
    this.tell(text, '', 'plain');
  }

  private rest(): void {
    this.bar.hidden = true;
    this.phase.hidden = true;
  }

  private tell(text: string, hint: string, look: 'plain' | 'cancelled' | 'failed'): void {
    write(this.outcome, text);
    write(this.hint, hint);
    this.outcome.hidden = text === '';
    this.hint.hidden = hint === '';
    this.outcome.dataset.look = look;
  }
}

export function outcomeOf(message: DoneMessage): [text: string, look: 'plain' | 'cancelled' | 'failed'] {
  if (message.error !== '') return [`Failed: ${message.error}`, 'failed'];
  if (message.cancelled) return [message.text === '' ? 'Cancelled.' : `Cancelled: ${message.text}`, 'cancelled'];
  return [message.text, 'plain'];
}
