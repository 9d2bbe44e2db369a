// Waves from impulses.
import { NumberField } from './controls';
import type { Context } from './panel';
import { Evolution } from './evolution';

export function wavePanel(context: Context, host: HTMLElement): Evolution {
  const damping = new NumberField({
    label: 'Damping β₂ of short waves',
    test: 'wave-beta-2',
    low: 0,
    change: (beta_2) => context.send({ do: 'wave.set', beta_2 }),
  });
  return new Evolution(
    {
      task: 'wave',
      noun: 'impulse',
      value: 1,
      field: 'displacement',
      hint: 'Click the surface to strike it. Click a marker to select it, drag it to move it, shift-click it to remove it.',
      csv: 'the impulses',
      place: (vertex, value) => ({ do: 'wave.impulse', vertex, value }),
      set: (what) => ({ do: 'wave.set', ...what }),
      read: ({ wave }) => ({ places: wave.impulses, time: wave.time, steps: wave.steps }),
      extra: { element: damping.element, update: ({ wave }) => damping.set(wave.beta_2) },
    },
    context,
    host,
  );
}
