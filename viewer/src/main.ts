// Plays the loop that the page carries: evaluates the weights of the morph targets at any instant and shows them.
import './style.css';
import {readLoop, unpack, Vertices, weightsAt, type Loop} from './loop';
import {dress} from './materials';
import {Panel, type Player} from './panel';
import {Stage} from './stage';

// For scripts and tests. Positions are in metres with z up, as in every other file.
interface Tremula {
  ready: Promise<void>;
  period: number;
  vertexCount: number;
  setTime(seconds: number): void;
  pause(): void;
  vertex(index: number): [number, number, number];  // in the frame on the screen
  branchOf(index: number): number;
  alongOf(index: number): number;
}

declare global {
  interface Window { tremula: Partial<Tremula> & Pick<Tremula, 'ready'>; }
}

// Loads grow with the square of the wind speed, the mean one and (for a given intensity of turbulence) the
// fluctuating one; the answer is linear in the loads.
function shownWeights(loop: Loop, player: Player, timeShift = 0): number[] {
  const load = player.wind * player.wind;
  return weightsAt(loop, player.time + timeShift).map((weight, i) => player.enabled[i] ? load * weight : 0);
}

async function start(): Promise<void> {
  const data = document.getElementById('loop')!;
  const loop = await readLoop(await unpack(data.textContent!));
  data.remove();
  dress(loop.meshes);

  const period = loop.facts.period_s;
  const player: Player = {
    playing: !matchMedia('(prefers-reduced-motion: reduce)').matches,
    time: 0,
    speed: 1,
    wind: 1,
    enabled: loop.targetKinds.map(() => true),
  };
  const canvas = document.getElementById('stage') as HTMLCanvasElement;
  const stage = new Stage(canvas, loop);

  let changed = true;
  const panel = new Panel(loop, player, () => { changed = true; });
  const draw = (): void => {
    loop.meshes.forEach((mesh, i) => {
      const weights = shownWeights(loop, player, loop.timeShifts[i]);
      mesh.morphTargetInfluences?.splice(0, weights.length, ...weights);
    });
    panel.show(shownWeights(loop, player));
    stage.render();
    changed = false;
  };

  let last = performance.now();
  const tick = (now: number): void => {
    // A page that was hidden goes on where it stopped; the first frame may be stamped before its own start.
    const passed = Math.min(Math.max((now - last) / 1000, 0), 0.1);
    last = now;
    if (player.playing && period > 0) player.time = (player.time + passed * player.speed) % period;
    // Nothing is drawn while nothing moves.
    if (stage.moveCamera() || player.playing || changed) draw();
    requestAnimationFrame(tick);
  };
  new ResizeObserver(() => { stage.resize(); draw(); }).observe(canvas);
  draw();
  requestAnimationFrame(tick);

  const vertices = new Vertices(loop);
  Object.assign(window.tremula, {
    period,
    vertexCount: vertices.count,
    setTime: (seconds: number) => { player.time = seconds; draw(); },
    pause: () => { player.playing = false; draw(); },
    vertex: (index: number) => {
      if (changed) draw();
      return vertices.position(index);
    },
    branchOf: (index: number) => vertices.branch(index),
    alongOf: (index: number) => vertices.along(index),
  });
}

window.tremula = {ready: start()};
window.tremula.ready.catch((reason: unknown) => {
  const message = document.getElementById('message')!;
  message.textContent = `This page cannot show its plant: ${reason instanceof Error ? reason.message : String(reason)}`;
  message.hidden = false;
});
