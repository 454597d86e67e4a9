// The controls over the picture.
import type {Loop} from './loop';
import type {Player, Shape} from './movement';

const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

export class Panel {
  private readonly play = element<HTMLButtonElement>('play');
  private readonly time = element<HTMLInputElement>('time');
  private readonly timeText = element<HTMLOutputElement>('time-text');
  private readonly modes = element<HTMLDetailsElement>('modes');
  private readonly bars = new Map<number, HTMLElement>();  // by shape
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

    element<HTMLInputElement>('wind').max = String(loop.movement.windLimit);
    element('wind').parentElement!.title = loop.movement.windHint;
    element('wind').parentElement!.hidden = loop.movement.windLimit === 0;
    this.slider('wind', (k) => { player.wind = k; return loop.movement.windText(k); });
    this.slider('speed', (k) => { player.speed = k; return `${k.toFixed(2)}×`; });
    this.listModes();
    this.show([]);
  }

  // Follows the player; weights are those on the screen, 1 for as far as a shape goes.
  show(weights: number[]): void {
    const {time, playing} = this.player;
    this.play.textContent = playing ? '❚❚' : '▶';
    this.play.setAttribute('aria-label', playing ? 'pause' : 'play');
    this.time.value = String(time);
    this.timeText.textContent = `${time.toFixed(1)} / ${this.period.toFixed(1)} s`;
    if (!this.modes.open) return;
    weights.forEach((weight, i) => {
      const bar = this.bars.get(i);
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
    const update = (): void => {
      text.textContent = set(Number(input.value));
      this.showWind();
    };
    input.addEventListener('input', () => { update(); this.changed(); });
    input.addEventListener('dblclick', () => { input.value = '1'; update(); this.changed(); });
    update();
  }

  private showWind(): void { element('shown').textContent = this.loop.movement.shownText(this.player.wind); }

  private showFacts(): void {
    const hertz = this.loop.movement.shapes.filter(({kind}) => kind === 'mode').map(({frequency}) => frequency);
    const modes = `${hertz.length} mode${hertz.length === 1 ? '' : 's'}`;
    const range = hertz.length > 0 ? ` · ${Math.min(...hertz).toFixed(2)}–${Math.max(...hertz).toFixed(2)} Hz` : '';
    element('name').textContent = this.loop.name;
    const length = `${this.period.toFixed(1).replace('.0', '')} s`;
    element('facts').textContent =
        `${this.loop.facts.repeats === false ? `${length} clip, played again from its start` : `${length} loop`} · ${this.loop.field?.told ?? modes}${range}`;
  }

  // Modes, and behind them the static shapes; the lean always stays.
  private listModes(): void {
    let staticShapes = 0;
    this.loop.movement.shapes.forEach(({kind, mode, frequency}: Shape, i) => {
      if (kind === 'lean') return;
      const row = document.createElement('button'), bar = document.createElement('i');
      row.type = 'button';
      row.append(kind === 'mode' ? `${mode}` : `s${++staticShapes}`,
                 Object.assign(document.createElement('span'), {className: 'bar'}),
                 kind === 'mode' ? `${frequency.toFixed(2)} Hz` : 'static');
      if (kind === 'static') row.title = 'no mode: what the modes left out add';
      row.querySelector('.bar')!.append(bar);
      row.addEventListener('click', (event) => {
        if (event.detail < 2) this.enable((shape, on) => shape === i ? !on : on);
        else if (event.detail === 2) this.enable((shape) => this.isAlone(i) || shape === i);
      });
      this.bars.set(i, bar);
      this.rows.set(i, row);
      element('mode-list').append(row);
    });
    this.modes.hidden = this.rows.size === 0;
    this.modes.addEventListener('toggle', this.changed);
    this.enable(() => true);
  }

  private isAlone(shape: number): boolean {
    return [...this.rows.keys()].every((i) => this.player.enabled[i] === (i === shape));
  }

  private enable(choose: (shape: number, on: boolean) => boolean): void {
    for (const [shape, row] of this.rows) {
      this.player.enabled[shape] = choose(shape, this.player.enabled[shape]);
      row.setAttribute('aria-pressed', String(this.player.enabled[shape]));
    }
    this.changed();
  }
}
