// Heat from held temperatures.
import type { Context } from './panel';
import { Evolution } from './evolution';

export function heatPanel(context: Context, host: HTMLElement): Evolution {
  return new Evolution(
    {
      task: 'heat',
      noun: 'source',
      value: 100,
      field: 'temperature',
      hint: 'Click the surface to hold a vertex at a temperature. Click a marker to select it, drag it to move it, shift-click it to remove it.',
      csv: 'the sources',
      place: (vertex, value) => ({ do: 'heat.source', vertex, value }),
      set: (what) => ({ do: 'heat.set', ...what }),
      read: ({ heat }) => ({ places: heat.sources, time: heat.time, steps: heat.steps }),
    },
    context,
    host,
  );
}
