// How the plant of a page moves, whatever it moves by: what the controls and the picture need to know of it.
import type {Facts} from './loop';

// lean: under the mean wind; mode; static: what stands for the modes left out.
export interface Shape {
  kind: 'lean' | 'mode' | 'static';
  mode: number;       // from 1, 0 for what is no mode
  frequency: number;  // [Hz] of a mode
}

export interface Player {
  playing: boolean;
  time: number;        // [s] 0 … period
  speed: number;       // times real time
  wind: number;        // times the strongest wind of the file
  enabled: boolean[];  // for each shape
}

export interface Movement {
  readonly shapes: Shape[];
  readonly windLimit: number;  // the largest Player.wind that it can show; 0: only its own
  readonly windHint: string;   // how it comes by winds that are not in the file
  windText(wind: number): string;  // its speed
  shownText(wind: number): string;  // what of the file is on the screen; empty where that is plain
  // Puts the plant where the player wants it. Returns how far out each shape is, 1 for as far as it goes.
  show(player: Player): number[];
}

// What looks its motion up in a field that was made for one wind. `set` tells the graphics card how many samples into the
// loop it is, and how strong the wind is.
export class InFieldWind implements Movement {
  readonly shapes: Shape[] = [];
  readonly windLimit = 2;
  readonly windHint = 'Loads grow with the square of the wind speed, and so do lean and swaying here; the frequencies stay, and how fast gusts travel.';

  constructor(private readonly facts: Facts, private readonly samples: number,
              private readonly set: (now: number, wind: number) => void, private readonly shown = '') {}

  windText(wind: number): string { return `${(wind * this.facts.wind_speed_m_s).toFixed(1)} m/s`; }

  shownText(): string { return this.shown; }

  show({time, wind}: Player): number[] {
    const periods = this.facts.period_s > 0 ? time / this.facts.period_s : 0;
    this.set((periods - Math.floor(periods)) * this.samples, wind);
    return [];
  }
}

// Row `time` of a table whose rows are a loop, linear between them. The loop goes on before its begin and after its
// end; a clip that does not repeat ends with its last row. `times` are those of the rows, the last one the period.
export function rowAt(times: ArrayLike<number>, table: ArrayLike<number>, width: number, anyTime: number,
                      repeats = true): number[] {
  const period = times[times.length - 1];
  const time = anyTime >= 0 && anyTime <= period ? anyTime : anyTime - period * Math.floor(anyTime / period);
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const part = high > low ? Math.min(Math.max((time - times[low]) / (times[high] - times[low]), 0), 1) : 0;
  const last = table.length / width - 1;  // a table may leave out the row at its end
  const before = width * low, after = width * (high > last ? repeats ? 0 : last : high);
  return Array.from({length: width}, (_, i) => table[before + i] + part * (table[after + i] - table[before + i]));
}
