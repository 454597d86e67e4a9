// The controls over the picture.
import type {Loop} from './loop';

export interface Player {
  playing: boolean;
  time: number;       // [s] 0 … period
  speed: number;      // times real time
  wind: number;       // times the wind speed of the file
  enabled: boolean[]; // for each mode from 1
}

const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

export class Panel {
  private readonly play = element<HTMLButtonElement>('play');
  private readonly time = element<HTMLInputElement>('time');
  private readonly timeText = element<HTMLOutputElement>('time-text');
  private readonly modes = element<HTMLDetailsElement>('modes');
  private readonly bars = new Map<number, HTMLElement>();  // by mode
  private readonly rows = new Map<number, HTMLButtonElement>();

  // `changed` is called after the user has changed the player.
  constructor(private readonly loop: Loop, private readonly player: Player, private readonly changed: () => void) {
    this.showFacts();
    this.time.max = String(this.period);
    this.time.addEventListener('input', () => {
      player.playing = false;
      player.time = Number(this.time.value);
      changed();
    });
    this.play.addEventListener('click', () => { this.toggle(); });
    addEventListener('keydown', (event) => { this.key(event); });

    const speed = loop.facts.wind_speed_m_s;
    this.slider('wind', (k) => { player.wind = k; return speed > 0 ? `${(k * speed).toFixed(1)} m/s` : `${k.toFixed(2)}×`; });
    this.slider('speed', (k) => { player.speed = k; return `${k.toFixed(2)}×`; });
    this.listModes();
    this.show([]);
  }

  // Follows the player; weights are those on the screen.
  show(weights: number[]): void {
    const {time, playing} = this.player;
    this.play.textContent = playing ? '❚❚' : '▶';
    this.play.setAttribute('aria-label', playing ? 'pause' : 'play');
    this.time.value = String(time);
    this.timeText.textContent = `${time.toFixed(1)} / ${this.period.toFixed(1)} s`;
    if (!this.modes.open) return;
    weights.forEach((weight, i) => {
      const bar = this.bars.get(this.loop.targetModes[i]);
      if (bar) bar.style.transform = `scaleX(${Math.max(-1, Math.min(1, weight))})`;
    });
  }

  private get period(): number { return this.loop.facts.period_s; }

  private toggle(): void {
    this.player.playing = !this.player.playing;
    this.changed();
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const onButton = event.target instanceof HTMLElement && event.target.closest('button, summary');
    if (event.key === ' ' && !onButton) this.toggle();
    else if ((event.key === 'ArrowLeft' || event.key === 'ArrowRight') && !(event.target instanceof HTMLInputElement)) {
      const step = (event.key === 'ArrowLeft' ? -1 : 1) / (this.loop.facts.frames_per_second || 30);
      this.player.playing = false;
      this.player.time = (this.player.time + step + this.period) % this.period;
      this.changed();
    } else return;
    event.preventDefault();
  }

  private slider(id: string, set: (value: number) => string): void {
    const input = element<HTMLInputElement>(id), text = element(`${id}-text`);
    const update = (): void => { text.textContent = set(Number(input.value)); };
    input.addEventListener('input', () => { update(); this.changed(); });
    input.addEventListener('dblclick', () => { input.value = '1'; update(); this.changed(); });
    update();
  }

  private showFacts(): void {
    const modes = this.loop.targetModes.filter((mode) => mode > 0);
    const hertz = modes.map((mode) => this.loop.facts.frequencies_hz[mode - 1]);
    const range = hertz.length > 0 ? ` · ${Math.min(...hertz).toFixed(2)}–${Math.max(...hertz).toFixed(2)} Hz` : '';
    element('name').textContent = this.loop.name;
    element('facts').textContent =
        `${this.period.toFixed(1).replace('.0', '')} s loop · ${modes.length} mode${modes.length === 1 ? '' : 's'}${range}`;
  }

  private listModes(): void {
    const modes = this.loop.targetModes.filter((mode) => mode > 0);
    this.modes.hidden = modes.length === 0;
    this.modes.addEventListener('toggle', this.changed);
    for (const mode of modes) {
      const row = document.createElement('button'), bar = document.createElement('i');
      row.type = 'button';
      row.append(`${mode}`, Object.assign(document.createElement('span'), {className: 'bar'}),
                 `${this.loop.facts.frequencies_hz[mode - 1].toFixed(2)} Hz`);
      row.querySelector('.bar')!.append(bar);
      row.addEventListener('click', (event) => {
        if (event.detail < 2) this.setModes((m, on) => m === mode ? !on : on);
        else if (event.detail === 2) this.setModes((m) => this.isAlone(mode) || m === mode);
      });
      this.bars.set(mode, bar);
      this.rows.set(mode, row);
      element('mode-list').append(row);
    }
    this.setModes(() => true);
  }

  private isAlone(mode: number): boolean {
    return this.player.enabled.every((on, i) => on === (i === mode - 1));
  }

  private setModes(choose: (mode: number, on: boolean) => boolean): void {
    const {enabled} = this.player;
    const before = [...enabled];
    for (let i = 0; i < enabled.length; ++i) enabled[i] = choose(i + 1, before[i]);
    for (const [mode, row] of this.rows) row.setAttribute('aria-pressed', String(enabled[mode - 1]));
    this.changed();
  }
}
